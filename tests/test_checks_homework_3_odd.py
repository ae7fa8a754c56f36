"""Odd answers to the tasks of homework 3: whatever a function does, a check says so in words."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib.checks import homework_3

CHECKS = [getattr(homework_3, name) for name in homework_3.__all__]

seeds = st.integers(0, 2**32 - 1)


def chaos(seed):
    """A function that does anything: errors, arguments broken, values of every kind and shape."""
    rng = np.random.default_rng(seed)

    def function(*arguments):
        passed = [argument for argument in arguments if isinstance(argument, np.ndarray)]
        array = passed[rng.integers(len(passed))]
        match rng.integers(14):
            case 0:
                raise [ValueError, IndexError, NotImplementedError, SystemExit, KeyError][rng.integers(5)]("chaos")
            case 1:
                array[...] = 1
            case 2:
                array.resize((3, 5), refcheck=False)
            case 3:
                return (number for number in array)
            case 4:
                print("chaos" * rng.integers(1000))
        shape = [(), (0,), (len(array),), array.shape, (240, 3), (240, 2), (3,), (2,), (30, 3)][rng.integers(9)]
        values = rng.normal(size=shape) * 10.0 ** rng.integers(-3, 300)
        if rng.random() < 0.5:
            values = np.full(shape, [np.nan, np.inf, -np.inf, 0.0, 5.0][rng.integers(5)])
        odd = [None, True, -1, 2.5, "done", {"a": values}, [values, [1]], values.tolist(), values.astype(complex)]
        return odd[rng.integers(len(odd))] if rng.random() < 0.4 else values

    return function


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds)
def test_nothing_odd_confuses_a_check(seed):
    for any_check in CHECKS:
        verdict = any_check(chaos(seed), seed=seed % 5)
        assert not verdict.passed
        assert "check itself" not in repr(verdict), verdict
        verdict.html()


@pytest.mark.parametrize("any_check", CHECKS, ids=lambda any_check: any_check.name)
def test_the_same_seed_gives_the_same_verdict(any_check):
    for seed in range(3):
        assert any_check(chaos(seed), seed=seed) == any_check(chaos(seed), seed=seed)


@pytest.mark.parametrize("any_check", CHECKS, ids=lambda any_check: any_check.name)
def test_tensors_are_no_arrays_whatever_they_hold(any_check):
    torch = pytest.importorskip("torch")
    for value in (torch.ones(3, 3, requires_grad=True), [torch.ones(2)], (torch.ones(2), torch.ones(2))):
        verdict = any_check(lambda *_, value=value: value)
        assert verdict.points == 0
        assert "`.detach().numpy()`" in verdict.rows[0].likely
