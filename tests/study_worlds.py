"""Functions that train, for the tests of studies: importable, so that other processes find them."""

import os
import time
from concurrent.futures import Executor, Future
from pathlib import Path

import numpy as np

from course_lib import study

GRID = {"alpha": [0.1, 0.5], "epsilon": [0.1, 0.3], "env": {"slip": 0.2}, "num_episodes": 60}
TABLES = GRID | {"curve": "episode_return", "every": 7}
NETWORKS = {"env": {"slip": 0.1}, "num_episodes": 6, "max_steps": 20, "learning_rate": [0.001, 0.01], "hidden": [[5]]}


def drawn(seed, size=3, scale=1.0):
    """No training at all, but numbers that depend on the seed and the settings alone."""
    rng = np.random.default_rng(seed)
    return {"number": scale * rng.normal(), "curve": rng.normal(size=size)}


def slow(seed, pause=0.05, size=3):
    """`drawn`, after a while."""
    time.sleep(pause)
    return drawn(seed, size)


def slow_tables(seeds, pause=0.02, **settings):
    """Tables, after a while."""
    time.sleep(pause)
    return study.train_tables(seeds, **settings)


def fails(seed, bad=(3,), log=None, pause=0.0):
    """Fails for some seeds; writes down in the folder `log` that it was called."""
    time.sleep(pause)
    if log is not None:
        Path(log, str(seed)).touch()
    if seed in bad:
        raise ZeroDivisionError("one division too many")
    return {"number": float(seed)}


def ends_its_process(seed, of_seed=2, parent=0):
    """Ends the process that it runs in, unless that is `parent`."""
    if seed == of_seed and os.getpid() != parent:
        os._exit(9)
    return {"number": float(seed)}


def of_sets(seed):
    """Has a constant without an order."""
    return {"number": float(str(seed) in {"1", "2", "three", "four", "five"})}


def fails_once(seed, mark):
    """Fails where nobody has been before."""
    if not Path(mark).exists():
        Path(mark).touch()
        raise OSError("not now")
    return {"number": float(seed)}


class InOrder(Executor):
    """Does the work in a given order, in this thread, once everything has been handed in: `order` of the places."""

    def __init__(self, order):
        self.order, self.waiting = order, []

    def submit(self, function, *arguments, **keywords):
        future = Future()
        self.waiting.append((future, function, arguments, keywords))
        if len(self.waiting) == len(self.order):
            for place in self.order:
                future_, function, arguments, keywords = self.waiting[place]
                future_.set_result(function(*arguments, **keywords))
        return future


def same(one, other):
    """Whether two results are the same to the last bit."""
    return (
        one.settings == other.settings
        and one.labels == other.labels
        and one.seeds.tolist() == other.seeds.tolist()
        and {name: array.tobytes() for name, array in one.measures.items()}
        == {name: array.tobytes() for name, array in other.measures.items()}
        and {(name, label): runs.tobytes() for name, curves in one.curves.items() for label, runs in curves.items()}
        == {(name, label): runs.tobytes() for name, curves in other.curves.items() for label, runs in curves.items()}
    )
