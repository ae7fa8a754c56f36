"""Two functions that train, for a study's cells: tables, and networks side by side."""

import threading

import gymnasium
import numpy as np

from course_lib.maze import Maze
from course_lib.q_table import train_side_by_side
from course_lib.validate import whole_number

_CURVES = ("episode_return", "episode_length")
_torch_is_free = threading.Lock()  # its number of threads is the whole process's


def thinned(curve, every):
    """The mean of each `every` entries along the last axis, [..., N] to [..., ceil(N / every)].

    The last is the mean of what is left. So a curve of a thousand episodes becomes one of fifty points, and a study
    stays small. `ValueError` if every < 1.
    """
    every, curve = whole_number("every", every, at_least=1), np.asarray(curve, dtype=np.float64)
    firsts = np.arange(0, curve.shape[-1], every)
    counts = np.minimum(firsts + every, curve.shape[-1]) - firsts
    return np.add.reduceat(curve, firsts, axis=-1) / counts if len(firsts) else curve


def train_tables(seeds, *, env=None, num_episodes=1000, max_steps=1000, curve=None, every=20, **settings):
    """`QAgent`s, one a seed, each trained alone; for `study.run`.

    env        {} or the rules of a `Maze`, such as {"slip": 0.2}; or the id of a Gymnasium environment
    curve      "episode_return" or "episode_length", kept as the mean of each `every` episodes; None: no curve
    settings   of `QAgent`: alpha, gamma, epsilon, …
    Gives mean_return and mean_length, of all episodes, end_return, of the last tenth of them, and the curve. The
    environment is one for all, seeded anew by each agent. `ValueError` as for `QAgent`.
    """
    world, num_episodes = _world(env), whole_number("num_episodes", num_episodes, at_least=1)
    _, history = train_side_by_side(world, seeds, num_episodes, max_steps=max_steps, **settings)
    return _measured(history, curve, every)


def train_networks(seeds, *, env=None, num_episodes=100, max_steps=1000, curve=None, every=5, **settings):
    """`DQNAgent`s, as many as there are seeds, trained side by side; for `study.run`.

    As `train_tables`, with the settings of `DQNAgent`. Networks of one process take turns with those of other threads,
    as torch's threads are shared; processes share the work. Seeds that do not follow each other are trained one by one.
    """
    from course_lib.dqn import DQNAgent

    num_episodes, parts = whole_number("num_episodes", num_episodes, at_least=1), []
    for run in _following(seeds):
        with _torch_is_free:
            agents = DQNAgent(_world(env), num_agents=len(run), seed=run[0], **settings)
            parts.append(_measured(agents.train(num_episodes, max_steps=max_steps), curve, every))
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _following(seeds):
    """The seeds in runs of which each is one more than the one before: an ensemble's are."""
    runs = []
    for seed in map(int, seeds):
        if runs and seed == runs[-1][-1] + 1:
            runs[-1].append(seed)
        else:
            runs.append([seed])
    return runs


def _world(env):
    """The environment that a setting names; `ValueError` if there is no such thing."""
    if env is None or isinstance(env, dict):
        try:
            return Maze(**(env or {}))
        except TypeError as error:
            raise ValueError(f"env must be the rules of a Maze, got {env!r}: {error}") from None
    try:
        return gymnasium.make(env)
    except (gymnasium.error.Error, ImportError, AttributeError, TypeError) as error:
        raise ValueError(f"there is no environment {env!r}: {' '.join(str(error).split())}") from None


def _measured(history, curve, every):
    """The measures of one agent or of many: numbers or [E], and the curve, [N] or [E, N]."""
    returns, lengths = history.episode_return, history.episode_length
    last = max(1, len(history) // 10)
    measures = {
        "mean_return": returns.mean(axis=-1),
        "end_return": returns[..., -last:].mean(axis=-1),
        "mean_length": lengths.mean(axis=-1),
    }
    if curve is None:
        return measures
    if curve not in _CURVES:
        raise ValueError(f"curve must be None, {' or '.join(map(repr, _CURVES))}, got {curve!r}")
    return measures | {curve: thinned(getattr(history, curve), every)}
