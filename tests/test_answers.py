"""Answers to the homework, as learners give them: the right ones pass, each wrong one meets the words meant for it."""

import runpy
from pathlib import Path

import pytest

from course_lib.checks import homework_1
from course_lib.checks.verdict import Outcome

ANSWERS = Path(__file__).with_name("answers")
RIGHT = sorted(ANSWERS.glob("*/right/*.py"))
WRONG = sorted(ANSWERS.glob("*/wrong/*.py"))
CHECKS = {"homework_1": homework_1}


def files(paths):
    return pytest.mark.parametrize("path", paths, ids=[path.stem for path in paths])


def function_of(check):
    """The name of the function that a check is about."""
    return check.usage.split("(")[0]


def checks_of(path):
    module = CHECKS[path.parents[1].name]
    return [getattr(module, name) for name in module.__all__]


def test_there_are_many_answers():
    assert len(RIGHT) >= 8
    assert len(WRONG) >= 28


@files(RIGHT)
def test_a_right_answer_passes(path):
    answer = runpy.run_path(str(path))
    its_checks = [check for check in checks_of(path) if function_of(check) in answer]
    assert its_checks, "it defines none of the functions that the homework asks for"
    assert answer["__doc__"], "its docstring tells its style"
    for check in its_checks:
        for seed in (0, 1):
            verdict = check(answer[function_of(check)], seed=seed)
            assert verdict.passed, verdict
            assert verdict.points == verdict.max_points


@files(WRONG)
@pytest.mark.filterwarnings("ignore:.*encountered in divide:RuntimeWarning")  # one of them divides by zero
def test_a_wrong_answer_is_told_what_is_wrong(path):
    answer = runpy.run_path(str(path))
    assert answer["__doc__"], "its docstring tells the mistake"
    check = getattr(CHECKS[path.parents[1].name], answer["CHECK"])
    verdict = check(answer[function_of(check)], time_limit=answer.get("TIME_LIMIT", 10.0))
    assert verdict.outcome is Outcome.NOT_YET
    assert verdict.points < verdict.max_points
    assert "check itself" not in repr(verdict), "a mistake of ours"
    first = next(row for row in verdict.rows if row.outcome is Outcome.NOT_YET)
    assert answer["SAYS"], "it says which words are meant for it"
    assert answer["SAYS"] in f"{first.came} {first.likely}", verdict
