"""Homework 2 across the pipe: functions of the judge's that a learner's process asks, and the same verdicts as here."""

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from course_lib import LESSON_GRID, Maze
from course_lib.checks import homework_2
from course_lib.checks.callback import Callback
from course_lib.checks.learner import Fault, Kind
from course_lib.checks.worlds import Watched
from course_lib.classroom.process import LearnerProcess, Limits, There

if sys.platform == "win32":
    pytest.skip("the judge needs a Unix system", allow_module_level=True)

ANSWERS = Path(__file__).parents[1] / "answers" / "homework_2"
CHECKS = [getattr(homework_2, name) for name in homework_2.__all__]


@pytest.fixture(scope="module")
def process(tmp_path_factory):
    with LearnerProcess(tmp_path_factory.mktemp("learner"), Limits(time_limit=20.0)) as running:
        yield running


def call(process, source, *arguments, time_limit=5.0):
    """Run `source`, which defines f, and call f."""
    assert process.run(source)[1] is None
    return process.call("f", arguments, time_limit)


def double(value):
    if not isinstance(value, int):
        raise ValueError("a whole number, please")
    return 2 * value


def multiplied(factor):
    """A function of its own for each factor."""

    def multiply(value):
        return value * factor

    return multiply


# --- functions that cross ---------------------------------------------------------------------------------------------


def test_a_function_is_answered_here(process):
    asked = []

    def add(values, number):
        asked.append(number)
        if number < 0:
            raise ValueError("no negative number, please")
        return values + number

    source = """
import pandas as pd

def f(add):
    try:
        add([1.5], -1)
    except ValueError as error:
        words = str(error)
    return add.__name__, words, add(number=1, values=pd.Series([1.5, 2.5]))
"""
    name, words, values = call(process, source, Callback(add)).value
    assert (name, words, values.tolist(), asked) == ("add", "no negative number, please", [2.5, 3.5], [-1, 1])


def test_a_world_and_two_functions_are_told_apart(process):
    world, functions = Watched(Maze(LESSON_GRID)), [Callback(multiplied(factor)) for factor in (2, 3)]
    source = "def f(a, maze, b):\n    return a(5), maze.reset()[0], b(5), a(7)"
    assert call(process, source, functions[0], world, functions[1]).value == (10, 0, 15, 14)
    assert [function.calls for function in functions] == [2, 1]
    assert len(world.episodes) == 1


def test_calls_without_end_are_stopped_and_the_process_lives(process):
    source = "def f(g):\n    while True:\n        try: g('text')\n        except Exception: pass"
    with pytest.raises(Fault, match="did not stop calling `double`") as caught:
        call(process, source, Callback(double, max_calls=50))
    assert caught.value.kind is Kind.STEPS_UP
    assert call(process, "def f(g):\n    return g(4)", Callback(double)).value == 8


def test_what_asks_and_is_not_finished_is_left_over(process):
    with pytest.raises(Fault) as caught:
        call(process, "def f(g):\n    g(4)\n    raise NotImplementedError", Callback(double))
    assert caught.value.kind is Kind.LEFT_OVER


@pytest.mark.parametrize("question", ["(7, 1)", "(-1, 1)", "('0', 1)", "()", "None", "(0,)", "(0, 1, 2)"])
def test_a_question_that_nobody_can_answer_is_an_error_there_and_none_here(process, question):
    source = f"""
def f(g):
    ask = next(cell.cell_contents for cell in g.__closure__ if callable(cell.cell_contents))
    line = next(cell.cell_contents for cell in ask.__closure__ if callable(cell.cell_contents)).__closure__
    line = next(cell.cell_contents for cell in line if hasattr(cell.cell_contents, "say"))
    line.say({{"ask": {question}}})
    return sorted(line.hear())
"""
    assert call(process, source, Callback(double)).value == ("error",)


def test_arrays_in_tuples_cross_and_their_changes_come_back(process):
    layers = ((np.zeros((2, 2)), np.ones(2)), (np.ones((2, 1)), np.zeros(1)))
    returned = call(process, "def f(layers):\n    layers[1][1][:] = 7\n    return len(layers)", layers)
    assert returned.value == 2
    assert [array.shape for array in returned.arrays] == [(2, 2), (2,), (2, 1), (1,)]
    assert returned.arrays[-1].tolist() == [7]
    assert layers[1][1].tolist() == [0]


# --- verdicts ---------------------------------------------------------------------------------------------------------


def both_verdicts(process, path, check):
    """What is said of the answer here, and across the pipe."""
    function = check.usage.split("(")[0]
    _, error = process.run(path.read_text(encoding="utf-8"))
    assert error is None
    return check(runpy.run_path(str(path))[function]), check(There(function, lambda: process))


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)
@pytest.mark.parametrize("name", ["from_the_task", "plain_loops"])
def test_a_right_answer_passes_there_too(process, name, check):
    here, there = both_verdicts(process, ANSWERS / "right" / f"{name}.py", check)
    assert here.passed
    assert there == here


@pytest.mark.parametrize(
    "name",
    [
        *("digits_reversed", "warm_up_is_nan", "a_series", "first_of_equal_extremes", "minmax_peeks"),
        *("short_as_minus_log", "table_copied", "table_resized", "max_over_impossible_actions"),
        *("two_traders_added_up", "a_position_for_each_table"),
        *("compares_the_future_too", "change_too_small", "compares_only_the_last_state", "asks_twice_the_same"),
    ],
)
def test_a_wrong_answer_is_told_the_same_there(process, name):
    path = ANSWERS / "wrong" / f"{name}.py"
    answer = runpy.run_path(str(path))
    here, there = both_verdicts(process, path, getattr(homework_2, answer["CHECK"]))
    assert there.rows == here.rows
    assert any(answer["SAYS"] in f"{row.came} {row.likely}" for row in there.rows)
