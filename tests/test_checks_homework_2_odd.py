"""Homework 2: functions that do anything confuse no check."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib.checks import homework_2

seeds = st.integers(0, 2**32 - 1)


def oddity(seed):
    """A function that does anything: breaks its arguments, calls what it is given, raises, returns something."""
    rng = np.random.default_rng(seed)

    def function(*arguments):
        arrays = [argument for argument in arguments if isinstance(argument, np.ndarray)]
        for argument in arguments:
            if callable(argument) and rng.random() < 0.8:
                argument(*[arrays[0], 3, "text", arrays[0][:3], [np.nan] * 4, None][: rng.integers(3)])
        for array in arrays:
            if rng.random() < 0.2 and array.flags.writeable:
                array[rng.integers(len(array))] = -5
        match rng.integers(12):
            case 0:
                raise [ValueError, IndexError, NotImplementedError, SystemExit, KeyError][rng.integers(5)]("odd")
            case 1:
                return (x for x in arrays)
            case 2:
                return arrays[0].astype(int) if arrays else 3
            case 3:
                return rng.integers(-2, 9, len(arrays[-1]) if arrays else 4)
            case 4:
                return np.full(len(arrays[-1]) if arrays else 4, [np.nan, np.inf, 0, 1][rng.integers(4)])
        values = [None, 3, -1, np.nan, True, [1, 2], (arrays, 3), "done", {}, -np.inf, [[]], 1j]
        return values[rng.integers(len(values))]

    return function


@settings(derandomize=True, deadline=None, max_examples=60)
@given(seeds)
def test_no_function_confuses_a_check(seed):
    for name in homework_2.__all__:
        verdict = getattr(homework_2, name)(oddity(seed), seed=seed % 5)
        assert not verdict.passed
        assert "check itself" not in repr(verdict), verdict
        verdict.html()
