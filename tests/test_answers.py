"""Answers to the homework, as learners give them: the right ones pass, each wrong one meets the words meant for it."""

import importlib
import runpy
from pathlib import Path

import pytest

from course_lib import checks
from course_lib.checks.verdict import Outcome

ANSWERS = Path(__file__).with_name("answers")
RIGHT = sorted(ANSWERS.glob("*/right/*.py"))
WRONG = sorted(ANSWERS.glob("*/wrong/*.py"))
HOMEWORK = sorted(folder.name for folder in ANSWERS.glob("homework_*"))
CHECKS = {name: importlib.import_module(f"course_lib.checks.{name}") for name in HOMEWORK}


def files(paths):
    return pytest.mark.parametrize("path", paths, ids=[f"{path.parents[1].name}-{path.stem}" for path in paths])


def function_of(check):
    """The name of the function that a check is about."""
    return check.usage.split("(")[0]


def checks_of(path):
    module = CHECKS[path.parents[1].name]
    return [getattr(module, name) for name in module.__all__]


@pytest.mark.parametrize("name", HOMEWORK)
def test_there_are_many_answers(name):
    assert len([path for path in RIGHT if path.parents[1].name == name]) >= 5
    wrong = [path for path in WRONG if path.parents[1].name == name]
    assert len(wrong) >= 12
    checked = {runpy.run_path(str(path))["CHECK"] for path in wrong}
    assert checked == set(CHECKS[name].__all__), "there are some for each check"


def test_every_homework_has_answers():
    folders = Path(checks.__file__).parent.glob("homework_*/__init__.py")
    assert set(HOMEWORK) == {path.parent.name for path in folders}


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
@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")  # some of them divide by zero
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
