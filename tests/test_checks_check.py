"""A check: trials in order, what stops them, hints, and what happens when the mistake is ours."""

import importlib
import re
from pathlib import Path

import numpy as np
import pytest

from course_lib import checks
from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.learner import Fault, Kind, Learner, Returned
from course_lib.checks.verdict import Outcome

FOLDERS = sorted(path.parent.name for path in Path(checks.__file__).parent.glob("homework_*/__init__.py"))
HOMEWORK = [importlib.import_module(f"course_lib.checks.{name}") for name in FOLDERS]
CHECKS = [getattr(homework, name) for homework in HOMEWORK for name in homework.__all__]
each_check = pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)


DONE_NOTHING = [
    *(None, 0, 1.5, "done", (), [[]], {}, (None, None), (np.zeros((16, 4)), 0), float("nan"), 10**400),
    *(True, False, np.zeros(60), np.zeros(60, int), np.full(60, -1), [], [None] * 60, np.array(3), np.zeros((60, 2))),
    *(np.full(60, np.inf), [2**64] * 60, [-(2**64)] * 60, ["1"] * 60, [[1, 2], [3]], np.ones(60, bool), 1j),
]


def check_of(*runs, hints=("first", "second")):
    trials = [Trial(f"trial {i}", "a value", run) for i, run in enumerate(runs)]
    return Check("sums", title="Sums", usage="add(a, b)", trials=trials, hints=hints)


def outcomes(verdict):
    return [row.outcome for row in verdict.rows]


def add(a, b):
    return a + b


def fine(call, _seed):
    assert call(1, 2).value == 3


def finds_fault(_call, _seed):
    raise NotYet("four", "you count twice.", "a map")


def says(kind):
    def run(_call, _seed):
        raise Fault(kind, f"words for {kind}")

    return run


# --- trials -----------------------------------------------------------------------------------------------------------


def test_each_trial_is_a_row_and_a_point():
    verdict = check_of(fine, finds_fault, fine)(add)
    assert outcomes(verdict) == [Outcome.PASSED, Outcome.NOT_YET, Outcome.PASSED]
    assert (verdict.points, verdict.max_points) == (2.0, 3.0)
    row = verdict.rows[1]
    assert (row.tried, row.expected, row.came, row.likely, row.map) == (
        "trial 1",
        "a value",
        "four",
        "you count twice.",
        "a map",
    )
    assert "checks.sums.hint()" in verdict.more
    assert check_of(fine, fine, fine).max_points == 3.0


def test_seed_time_limit_and_prints_reach_where_they_belong():
    seen = []

    def look(call, seed):
        seen.append((seed, call.time_limit))
        call(1, 2)

    def talkative(*_):
        print("adding")

    verdict = check_of(look)(talkative, seed=7, time_limit=2)
    assert seen == [(7, 2.0)]
    assert verdict.printed == "adding\n"
    for wrong in ({"seed": -1}, {"seed": 1.5}, {"time_limit": "soon"}):
        with pytest.raises(ValueError, match="must be"):
            check_of(look)(add, **wrong)


@pytest.mark.parametrize("kind", [Kind.LEFT_OVER, Kind.RAISED, Kind.STEPS_UP])
def test_a_fault_leaves_the_other_trials(kind):
    verdict = check_of(says(kind), fine)(add)
    assert outcomes(verdict) == [Outcome.NOT_YET, Outcome.PASSED]
    assert verdict.rows[0].came == f"words for {kind}"


@pytest.mark.parametrize("kind", [Kind.NO_FUNCTION, Kind.SIGNATURE, Kind.TIME_UP, Kind.INTERRUPTED, Kind.DIED])
def test_after_some_faults_nothing_more_is_tried(kind):
    verdict = check_of(fine, says(kind), fine, fine)(add)
    assert outcomes(verdict) == [Outcome.PASSED, Outcome.NOT_YET, Outcome.NOT_YET, Outcome.NOT_YET]
    assert [row.came for row in verdict.rows[2:]] == ["not tried after that"] * 2


def test_what_is_not_started_is_not_started_in_every_row():
    def unwritten(a, b):
        raise NotImplementedError  # your code here

    verdict = check_of(fine, fine)(unwritten)
    assert outcomes(verdict) == [Outcome.NOT_STARTED] * 2
    assert verdict.points == 0


def test_a_last_finding_is_the_last():
    def enough(_call, _seed):
        raise NotYet("for ever", "it never ends.", last=True)

    assert [row.came for row in check_of(enough, fine)(add).rows] == ["for ever", "not tried after that"]


def test_what_was_said_is_not_said_again():
    verdict = check_of(finds_fault, fine, finds_fault, says(Kind.RAISED), says(Kind.RAISED))(add)
    assert [row.came for row in verdict.rows] == [
        "four",
        "",
        "the same as above",
        "words for raised",
        "the same as above",
    ]
    assert [bool(row.likely) for row in verdict.rows] == [True, False, False, False, False]
    assert verdict.points == 1


@pytest.mark.parametrize("kind", list(Kind))
def test_every_kind_of_fault_is_a_row_and_never_points(kind):
    assert check_of(says(kind))(add).points == 0


@pytest.mark.parametrize(
    ("words", "likely"),
    [
        ("RecursionError: maximum recursion depth exceeded", "Use a loop"),
        ("SystemExit: 0", "`return`"),
        ("AttributeError: this maze shows no 'grid': a mouse has no map", "asks for the map"),
        ("ValueError: no such cell", ""),
    ],
)
def test_some_errors_have_a_likely_cause(words, likely):
    def run(_call, _seed):
        raise Fault(Kind.RAISED, words)

    row = check_of(run)(add).rows[0]
    assert likely in row.likely
    assert bool(row.likely) == bool(likely)


def test_a_check_may_know_what_an_error_looks_like():
    def run(_call, _seed):
        raise Fault(Kind.RAISED, "IndexError: index 16 is out of bounds for axis 0")

    check = Check(
        "c", title="t", usage="f()", trials=[Trial("t", "e", run)], hints=["h"], likely={"out of .* axis": "l."}
    )
    assert check(add).rows[0].likely == "l."


def test_an_interrupt_between_two_calls_ends_the_check_quietly():
    def run(_call, _seed):
        raise KeyboardInterrupt

    verdict = check_of(run, fine)(add)
    assert [row.came for row in verdict.rows] == ["you stopped it", "not tried after that"]


# --- a mistake of ours ------------------------------------------------------------------------------------------------


def broken(_call, _seed):
    return {}["no such key"]


def test_a_mistake_in_a_check_is_no_traceback_and_no_point():
    verdict = check_of(broken, fine)(add)
    assert outcomes(verdict) == [Outcome.NOT_YET, Outcome.PASSED]
    assert verdict.points == 1
    assert re.fullmatch(r"the check itself failed: KeyError in test_checks_check.py, line \d+", verdict.rows[0].came)
    assert "show this to your teacher" in verdict.rows[0].likely


def test_a_learner_that_breaks_the_interface_breaks_one_row():
    class Broken(Learner):
        name = "broken"

        def call(self, *_arguments, **_limits):
            raise RuntimeError("the pipe has gone")

    verdict = check_of(fine, broken)(Broken())
    assert verdict.points == 0
    assert "RuntimeError" in verdict.rows[0].came


def test_any_learner_will_do():
    class Remote(Learner):
        name = "remote"
        printed = "from afar"

        def call(self, *arguments, **_limits):
            return Returned(sum(arguments), ())

    verdict = check_of(fine)(Remote())
    assert verdict.passed
    assert verdict.printed == "from afar"


# --- work that several trials share -----------------------------------------------------------------------------------


def test_shared_work_is_done_once_a_check_and_its_failure_is_kept_too():
    done = []

    def shared(outcome):
        def run(call, _seed):
            def work():
                done.append(outcome)
                if outcome is not None:
                    raise outcome
                return "value"

            assert call.once("work", work) == "value"

        return run

    check = check_of(shared(None), shared(None))
    assert check(add).passed
    assert check(add).passed
    assert len(done) == 2, "once for each call of the check"
    for failure in (NotYet("came", "likely."), Fault(Kind.RAISED, "words")):
        done.clear()
        assert check_of(shared(failure), shared(failure))(add).points == 0
        assert len(done) == 1


# --- hints ------------------------------------------------------------------------------------------------------------


def test_hints_come_in_order_and_then_from_the_first():
    check = check_of(fine)
    assert [(check.hint().number, check.hint().words) for _ in range(2)] == [(1, "second"), (1, "second")]
    other = check_of(fine)
    check.hint()
    assert other.hint().words == "first", "each check counts its own"
    assert (other.hint().number, other.hint().of) == (2, 2)


# --- the checks of the homework ---------------------------------------------------------------------------------------


def test_the_names_of_checks_are_those_they_are_known_by():
    for homework in HOMEWORK:
        assert [getattr(homework, name).name for name in homework.__all__] == homework.__all__
        assert {value.name for value in vars(homework).values() if isinstance(value, Check)} == set(homework.__all__)
    assert len({check.name for check in CHECKS}) == len(CHECKS)


@each_check
def test_the_words_of_a_check(check):
    assert check.usage in repr(check)
    assert len(check.hints) >= 3
    said = [*check.hints, check.title, *(words for trial in check.trials for words in (trial.tried, trial.expected))]
    for words in said:
        assert words.strip() == words != ""
        assert words.count("`") % 2 == 0, words
        assert "*" not in re.sub(r"`[^`]*`", "", words), "nobody reads Markdown here"
    assert len({trial.tried for trial in check.trials}) == len(check.trials)


@each_check
def test_the_stub_that_is_handed_out_is_not_started(check):
    names = {}
    exec(f"def {check.usage}:\n    raise NotImplementedError  # your code here\n", names)
    verdict = check(names[check.usage.split("(")[0]])
    assert verdict.outcome is Outcome.NOT_STARTED
    assert outcomes(verdict) == [Outcome.NOT_STARTED] * len(check.trials)


@each_check
@pytest.mark.parametrize("value", DONE_NOTHING, ids=lambda value: repr(value)[:20])
def test_a_function_that_does_nothing_gets_no_points_and_no_mistake_of_ours(check, value):
    verdict = check(lambda *_: value)
    assert verdict.outcome is Outcome.NOT_YET
    assert verdict.points == 0
    assert "check itself" not in repr(verdict)
