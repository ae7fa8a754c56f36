"""What a learner waits for: the three checks of homework 1 on a whole answer, against the 5 seconds they may take.

    python tests/benchmarks/checks.py

The answers are the right ones of `tests/answers`: a wrong one is done sooner, or runs into the limit of its calls.
"""

import runpy
from pathlib import Path

from measure import medians, seconds, show

from course_lib.checks import homework_1

LIMIT = 5.0  # seconds, for all checks of a homework together
ANSWERS = Path(__file__).parents[1] / "answers" / "homework_1" / "right"
REFERENCE = "from_the_lesson"


def whole_answers():
    """{name: its functions} of the right answers that have all the functions asked for."""
    names = [getattr(homework_1, name).usage.split("(")[0] for name in homework_1.__all__]
    answers = {path.stem: runpy.run_path(str(path)) for path in sorted(ANSWERS.glob("*.py"))}
    return {stem: answer for stem, answer in answers.items() if all(name in answer for name in names)}


def check_all(answer, seed=0):
    """The verdicts of all checks on an answer; it has to pass them."""
    checks = [getattr(homework_1, name) for name in homework_1.__all__]
    verdicts = [check(answer[check.usage.split("(")[0]], seed=seed) for check in checks]
    if not all(verdict.passed for verdict in verdicts):
        raise ValueError(f"a right answer did not pass:\n{verdicts}")
    return verdicts


def main(repeats=5, answers=None):
    answers = answers or whole_answers()
    runs = {name: lambda answer=answer: seconds(lambda: check_all(answer)) for name, answer in answers.items()}
    taken = medians(runs, repeats)
    slowest = max(taken, key=taken.get)
    rows = [("answer", "seconds", f"of the {LIMIT:g} s allowed")]
    rows += [
        (f"{what}, {name}", f"{taken[name]:.2f}", f"{taken[name] / LIMIT:.2f}")
        for what, name in (("the reference", REFERENCE), ("the slowest", slowest))
    ]
    show(f"The checks of homework 1 on {len(answers)} right answers, medians of {repeats} in turn", rows)


if __name__ == "__main__":
    main()
