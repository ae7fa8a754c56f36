"""What a check cell is worth: a teacher's own checks, too, judged apart from the learner's code."""

import pytest

from course_lib.classroom.process import Limits
from course_lib.classroom.session import Session

ANSWER = "def double(x): return 2 * x\ndef broken(x): 1 / 0\ndef lists(x): return [x, x]"
IMPORTS = ["from course_lib.checks import homework_1 as checks"]


@pytest.fixture(scope="module")
def output(nbgrader, tmp_path_factory):  # noqa: ARG001 (it decides whether to skip)
    """output(source): what the judge makes of that check cell, worth 4 points."""
    from course_lib.classroom.judge import judged

    with Session(tmp_path_factory.mktemp("judge"), Limits(time_limit=5.0)) as session:
        session.run(ANSWER)
        yield lambda source: judged(source, IMPORTS, session, 4.0)


@pytest.mark.parametrize(
    ("source", "points"),
    [
        ("assert double(2) == 4", 4),
        ("double(2) == 4", 4),
        ("double(2) == 5", 0),
        ("score = 1.5 * (double(2) == 4)\nscore", 1.5),
        ("score = 0\nfor x in [1, 2, 3]:\n    score += double(x) == 2 * x\nscore", 3),
        ("100", 4),
        ("-1", 0),
        ("float('nan')", 0),
        ("'done'", 4),
        ("assert lists(3) == (3, 3)", 4),
        ("", 4),
    ],
)
def test_a_teachers_own_check(output, source, points):
    assert float(output(source).data["text/plain"]) == points


@pytest.mark.parametrize(
    "source", ["assert double(2) == 5", "broken(2)", "missing(2)", "double", "tsak_1", "1 / 0", "double(2, 3)"]
)
def test_what_goes_wrong_is_worth_nothing(output, source):
    assert output(source).output_type == "error"


def test_a_check_of_the_course(output):
    shown = output("task = checks.goes_on_after_a_bump(double)\ntask")
    assert float(shown.data["text/plain"]) == 0
    assert "Task 1" in shown.data["text/html"]
