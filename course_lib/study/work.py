"""What one piece of work does, wherever it is done: train the agents of a cell, and check what comes back."""

import numpy as np

from course_lib.study.plan import described


class CellFailed(RuntimeError):
    """Training failed for a setting and a seed, which its text names; what it failed with is its cause."""


def run_cell(train, at_once, settings, seeds, stop=None):
    """What `train` makes of a block of seeds: {name: float64[B] or float64[B, N]}.

    at_once   whether `train` takes all of them in one call
    stop      asked between one seed and the next; where it says yes, None is returned
    Raises `CellFailed`.
    """
    if at_once:
        return _trained(train, np.array(seeds, np.int64), settings, seeds, len(seeds))
    results = []
    for seed in seeds:
        if stop is not None and stop():
            return None
        results.append(_trained(train, seed, settings, (seed,), None))
        if _shapes(results[-1]) != _shapes(results[0]):
            forms = [_form(_shapes(result)) for result in (results[-1], results[0])]
            raise CellFailed(f"{described(settings, (seed,))}: gave {forms[0]}, others {forms[1]}")
    return {name: np.array([result[name] for result in results]) for name in results[0]}


def check_alike(cells, results):
    """`ValueError` unless all cells gave the same names, and those of a setting curves of one length."""
    shapes = [{name: array.shape[1:] for name, array in arrays.items()} for arrays in results]
    first = {}
    for i, cell in enumerate(cells):
        of_setting = first.setdefault(cell.setting, i)
        for other in (0, of_setting):
            numbers = [{name: len(shape) for name, shape in shapes[j].items()} for j in (i, other)]
            if numbers[0] != numbers[1] or (other == of_setting and shapes[i] != shapes[other]):
                where, there = (described(each.settings, each.seeds) for each in (cell, cells[other]))
                raise ValueError(f"{where}: gave {_form(shapes[i])}, but {there} gave {_form(shapes[other])}")


def _trained(train, seed, settings, seeds, count):
    """The arrays that one call gives; whatever goes wrong names the settings and the seeds."""
    try:
        given = train(seed, **settings)
        if not isinstance(given, dict) or not given:
            raise ValueError(f"a function that trains must return {{name: number or curve}}, got {given!r}")
        return {name: _numbers(name, value, settings, count) for name, value in given.items()}
    except Exception as error:
        # the text alone, since other processes get no more than that
        raise CellFailed(f"{described(settings, seeds)}: {type(error).__name__}: {error}") from error


def _numbers(name, value, settings, count):
    """A number or a curve as float64, or those of `count` agents."""
    if not isinstance(name, str) or name in settings or name in ("seed", "seeds"):
        raise ValueError(f"a measure needs a name that is no setting's, got {name!r}")
    try:
        array = np.asarray(value)
        array = array.astype(np.float64) if array.dtype.kind in "biuf" else None
    except ValueError:  # rows of unequal lengths
        array = None
    if array is None:
        raise ValueError(f"{name} must be a number or a curve of numbers, got {value!r}")
    leading = () if count is None else (count,)
    if array.shape[: len(leading)] != leading or array.ndim - len(leading) > 1:
        wanted = "a number or a curve [N]" if count is None else f"[{count}] numbers or [{count}, N] curves"
        raise ValueError(f"{name} must be {wanted}, got shape {[*array.shape]}")
    return array


def _shapes(arrays):
    return {name: array.shape for name, array in arrays.items()}


def _form(shapes):
    """What came, in words."""
    return ", ".join(sorted(f"{name}{[*shape] if shape else ''}" for name, shape in shapes.items()))
