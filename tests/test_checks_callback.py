"""The function between judge and learner: one side answers and counts, the other looks like any function."""

import contextlib
import copy
import inspect

import numpy as np
import pandas as pd
import pytest

from course_lib.checks.callback import Callback, asking
from course_lib.checks.check import Check, Trial
from course_lib.checks.here import Here
from course_lib.checks.learner import Fault, Kind, arrays_in
from course_lib.checks.plain import Strange
from course_lib.checks.worlds import EnoughSteps


def call(function, *arguments, time_limit=5.0):
    return Here(function).call(*arguments, time_limit=time_limit)


def fault_of(function, *arguments):
    with pytest.raises(Fault) as caught:
        call(function, *arguments)
    return caught.value


def scale(values, factor):
    if not isinstance(values, np.ndarray):
        raise ValueError("scale takes an array")
    values *= factor
    return values


def side_of_the_learner(callback):
    return asking(callback.name, callback.parameters, callback.answer)


# --- the judge's side -------------------------------------------------------------------------------------------------


def test_what_comes_and_goes_is_plain():
    seen = []

    def keep(value):
        seen.append(value)
        return [np.float32(0.5), {"not": "plain"}]

    judge = Callback(keep)
    assert judge.answer([1, np.int8(2)]) == (0.5, Strange("dict"))
    judge.answer(object())
    assert seen == [(1, 2), Strange("object")]
    assert judge.calls == 2


def test_neither_side_can_change_the_others_arrays():
    kept = np.ones(3)

    def give(values):
        values[:] = 7
        return kept

    judge = Callback(give)
    given = np.zeros(3)
    answer = judge.answer(given)
    answer[:] = 9
    assert not given.any()
    assert kept.tolist() == [1, 1, 1]


def test_calls_have_a_limit_that_except_exception_lets_pass():
    judge = Callback(scale, max_calls=5)
    for _ in range(5):
        judge.answer(np.ones(2), 2)
    assert judge.exhausted
    with pytest.raises(EnoughSteps, match="calling `scale`"):
        judge.answer(np.ones(2), 2)
    assert judge.calls == 5


def test_a_call_that_is_refused_counts_too():
    judge = Callback(scale, max_calls=3)
    for arguments in (("a", 2), (), (1, 2, 3)):
        with pytest.raises(ValueError, match="scale"):
            judge.answer(*arguments)
    with pytest.raises(EnoughSteps):
        judge.answer("a", 2)


# --- the learner's side -----------------------------------------------------------------------------------------------


def test_it_looks_like_a_function():
    function = side_of_the_learner(Callback(scale))
    assert callable(function)
    assert function.__name__ == "scale"
    assert str(inspect.signature(function)) == "(values, factor)"
    np.testing.assert_array_equal(function(np.ones(2), 3), [3, 3])
    np.testing.assert_array_equal(function(factor=3, values=np.ones(2)), [3, 3])
    np.testing.assert_array_equal(copy.deepcopy(function)(np.ones(2), 3), [3, 3])


@pytest.mark.parametrize("arguments", [(), (1,), (1, 2, 3)])
def test_a_wrong_number_of_arguments_is_told_as_python_tells_it_and_asks_nobody(arguments):
    judge = Callback(scale)
    with pytest.raises(TypeError, match=r"missing a required argument|too many positional"):
        side_of_the_learner(judge)(*arguments)
    with pytest.raises(TypeError, match="unexpected keyword argument 'by'"):
        side_of_the_learner(judge)(1, 2, by=3)
    assert judge.calls == 0


def test_what_can_be_an_array_arrives_as_one():
    class Prices:
        def __array__(self, dtype=None, copy=None):
            return np.array([1.0, 2.0])

    for values in (pd.Series([1.0, 2.0], index=["a", "b"]), Prices()):
        np.testing.assert_array_equal(side_of_the_learner(Callback(scale))(values, np.int64(2)), [2, 4])


def test_one_process_hands_it_over():
    judge = Callback(scale)

    def twice(function, values):
        return function(function(values, 2), 2)

    np.testing.assert_array_equal(call(twice, judge, np.ones(2)).value, [4, 4])
    assert judge.calls == 2


def test_an_error_of_the_judges_is_an_error_in_the_learners_line():
    def asks(function):
        return function("text", 2)

    fault = fault_of(asks, Callback(scale))
    assert fault.kind is Kind.RAISED
    assert str(fault).startswith("ValueError: scale takes an array, in line")
    assert str(fault).endswith('of `asks`: `return function("text", 2)`')


def test_calls_without_end_are_stopped_in_words():
    def goes_on(function):
        while True:
            with contextlib.suppress(Exception):
                function("text", 2)

    judge = Callback(scale, max_calls=50)
    fault = fault_of(goes_on, judge)
    assert fault.kind is Kind.STEPS_UP
    assert str(fault) == "your code did not stop calling `scale`"
    trial = Trial("a function", "an end", lambda run, _: run(Callback(scale, max_calls=50)))
    verdict = Check("c", title="t", usage="f(function)", trials=[trial], hints=["h"])(goes_on)
    assert "maze" not in repr(verdict)
    assert "goes on, whatever answer it gets" in verdict.rows[0].likely


def test_what_asks_and_is_not_finished_is_left_over_and_not_unstarted():
    def left_over(function):
        function(np.ones(1), 1)
        raise NotImplementedError

    def not_started(function):
        raise NotImplementedError

    assert fault_of(left_over, Callback(scale)).kind is Kind.LEFT_OVER
    assert fault_of(not_started, Callback(scale)).kind is Kind.NOT_STARTED


# --- arrays in tuples -------------------------------------------------------------------------------------------------


def test_arrays_in_tuples_are_copied_and_seen_as_they_are_after_the_call():
    layers = ((np.zeros(2), np.ones(1)), (np.zeros((1, 1)), 3.0))

    def learn(first, given):
        given[0][0][1] = 5
        given[1][0][:] = 6
        first[:] = 4

    returned = call(learn, np.zeros(1), layers)
    assert [array.tolist() for array in returned.arrays] == [[4], [0, 5], [1], [[6]]]
    assert not any(array.any() for array in (layers[0][0], layers[1][0])), "the check's own arrays are never passed on"
    assert [array.shape for array in arrays_in((1, layers, "a"))] == [(2,), (1,), (1, 1)]
