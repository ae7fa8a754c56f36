"""What a study is made of: settings, seeds and the function that trains; and what is wrong with them."""

import inspect
import itertools
import json
import sys
from dataclasses import dataclass

import numpy as np

from course_lib.validate import number, whole_number

_SEVERAL = (list, tuple, range, np.ndarray)


@dataclass(frozen=True)
class Cell:
    """One piece of work: a setting and a block of seeds. `setting` is its place among the settings."""

    setting: int
    settings: dict
    seeds: tuple


def settings_in(grid):
    """The settings that `grid` describes, a list of dictionaries of plain values; `ValueError` for anything else.

    {name: values}: every combination, the last name changing fastest; a list, tuple, range or array holds several
    values, anything else is one. A list of dictionaries: those.
    """
    if isinstance(grid, dict):
        several = {name: list(values) if isinstance(values, _SEVERAL) else [values] for name, values in grid.items()}
        chosen = [dict(zip(several, values, strict=True)) for values in itertools.product(*several.values())]
    elif isinstance(grid, list | tuple) and all(isinstance(settings, dict) for settings in grid):
        chosen = list(grid)
    else:
        raise ValueError(f"grid must be {{name: values}}, or a list of dictionaries of settings, got {grid!r}")
    if not chosen:
        raise ValueError(f"grid must hold at least one setting, got {grid!r}")
    chosen = [{_name(name): plain(name, value) for name, value in settings.items()} for settings in chosen]
    texts = [as_text(settings) for settings in chosen]
    again = [settings for settings, text in zip(chosen, texts, strict=True) if texts.count(text) > 1]
    if again:
        raise ValueError(f"grid must hold every setting once, got {again[0]!r} several times")
    return chosen


def seeds_in(seeds):
    """The seeds, a tuple of whole numbers, each once: 0 to `seeds` - 1, or those that are listed."""
    try:
        seeds = range(whole_number("seeds", seeds, at_least=1)) if not hasattr(seeds, "__iter__") else seeds
        chosen = tuple(whole_number("a seed", seed, below=2**63) for seed in seeds)
    except TypeError:
        raise ValueError(f"seeds must be how many, or a list of whole numbers, got {seeds!r}") from None
    if not chosen or len(set(chosen)) < len(chosen):
        raise ValueError(f"seeds must be at least one, and each once, got {len(chosen)}, {len(set(chosen))} different")
    return chosen


def cells_of(settings, seeds, block):
    """The pieces of work, setting by setting, each with at most `block` seeds."""
    block = whole_number("block", block, at_least=1)
    blocks = [seeds[first : first + block] for first in range(0, len(seeds), block)]
    return [Cell(i, chosen, part) for i, chosen in enumerate(settings) for part in blocks]


def takes_blocks(train, settings):
    """Whether `train` takes many `seeds` at once, or one `seed`; `ValueError` if neither, or not those settings."""
    if not inspect.isfunction(train):
        raise ValueError(f"train must be a function, such as one begun by def train(seed, alpha):, got {train!r}")
    signature = inspect.signature(train)
    first = next(iter(signature.parameters), None)
    if first not in ("seed", "seeds"):
        raise ValueError(f"the first argument of {train.__name__} must be seed (one) or seeds (many), got {first!r}")
    for chosen in settings:
        try:
            signature.bind(0, **chosen)
        except TypeError as error:
            raise ValueError(f"{train.__name__}{signature} cannot be called with {chosen}: {error}") from None
    return first == "seeds"


def check_importable(train):
    """`ValueError` unless another process finds `train` by its name, as it must to run it."""
    module, found = train.__module__, sys.modules.get(train.__module__)
    for part in train.__qualname__.split("."):
        found = getattr(found, part, None)
    if module != "__main__" and found is train:
        return
    where = "in a notebook or a script" if module == "__main__" else f"within another function of {module}"
    raise ValueError(
        f"{train.__name__} is defined {where}, where other processes do not find it. Put it into a file of its own"
        f" beside the notebook and import it from there (on a cluster: copy the file to every computer, into the folder"
        f" where python -m dask is started), or leave out the executor: threads take any function"
    )


def labels_of(settings):
    """A text for each setting, all different: what it has that others have not, as in 'alpha = 0.1, epsilon = 0.5'."""
    names = list(dict.fromkeys(name for chosen in settings for name in chosen))
    varied = [name for name in names if len({as_text(chosen.get(name)) for chosen in settings}) > 1] or names
    for say in (str, repr):  # 1 and "1" look alike until they are quoted
        said = [", ".join(f"{name} = {say(chosen[name])}" for name in varied if name in chosen) for chosen in settings]
        if len(set(said)) == len(said):
            break
    return [label or "all runs" for label in said]


def described(settings, seeds):
    """Words for a piece of work, for errors."""
    chosen = ", ".join(f"{name} = {value!r}" for name, value in settings.items())
    which = f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"
    return f"{chosen}, {which}" if chosen else which


def as_text(value):
    """JSON in which equal settings look alike, and 1, 1.0 and true do not."""
    return json.dumps(value, sort_keys=True)


def _name(name):
    if not isinstance(name, str) or not name.isidentifier():
        raise ValueError(f"a setting's name must be that of an argument, got {name!r}")
    if name in ("seed", "seeds"):
        raise ValueError("the seeds of a study are given by seeds=, not in its grid")
    return name


def plain(name, value):
    """The value as JSON can hold it (numpy's numbers as Python's, tuples as lists); `ValueError` for any other."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        return number(f"setting {name}", value)
    if isinstance(value, list | tuple):
        return [plain(name, part) for part in value]
    if isinstance(value, dict) and all(isinstance(key, str) for key in value):
        return {key: plain(name, part) for key, part in value.items()}
    raise ValueError(
        f"setting {name} must be plain (numbers, text, None, lists and dictionaries of them), got {value!r}; make what"
        f" is not plain, such as an environment, in the function that trains"
    )
