"""A class hands in homework 1: some of it right, some broken, some meant to cheat. Everybody gets what they earned."""

import csv
import os
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell

from course_lib.classroom.confine import can_confine
from course_lib.classroom.course import Course

from .school import cell_of, filled_in, hand_in

HOMEWORK = "homework_1"
SOURCE = Path(__file__).parents[2] / "notebooks" / "solutions" / "04_homework_1.ipynb"
ANSWERS = {name: cell_of(nbformat.read(SOURCE, as_version=4), name).source for name in ("task_1", "task_2", "task_3")}
NOTHING, ALL = (0, 0, 0), (6, 6, 5)


@dataclass(frozen=True)
class Case:
    """What a learner hands in, made from the released notebook; the points it is worth, task by task; the remark."""

    make: object
    points: tuple
    remark: str = ""


def answered(release, **answers):
    return filled_in(release, ANSWERS | answers)


def with_cell(notebook, source, before=None):
    """A copy with one more cell: at the top, or before the cell of that name."""
    notebook = deepcopy(notebook)
    place = notebook.cells.index(cell_of(notebook, before)) if before else 0
    notebook.cells.insert(place, new_code_cell(source))
    return notebook


def cheated(source):
    """An unanswered notebook with a cell that tries to get points another way; run before and after the imports."""

    def make(release):
        return with_cell(with_cell(release, source, before="task_1_check"), source)

    return make


def check_cells_edited(release, *, answers):
    notebook = filled_in(release, answers)
    for number in (1, 2, 3):
        cell_of(notebook, f"task_{number}_check").source = f"task_{number} = 5.0\ntask_{number}"
    return notebook


def check_cells_deleted(release):
    notebook = answered(release)
    notebook.cells = [cell for cell in notebook.cells if not cell.metadata.get("nbgrader", {}).get("grade")]
    return notebook


def check_cells_copied(release):
    notebook = deepcopy(release)
    for number in (1, 2, 3):
        for place in (0, len(notebook.cells)):
            copy = deepcopy(cell_of(release, f"task_{number}_check"))
            copy.source, copy.id, copy.metadata.nbgrader["points"] = "5.0", f"copy-{number}-{place}", 500
            notebook.cells.insert(place, copy)
    return notebook


def all_marked_as_checks(release):
    """A cell of the learner's own that claims to be a check cell of the teacher's, under a name that nobody knows."""
    notebook = answered(release)
    tag = deepcopy(cell_of(notebook, "task_1_check").metadata)
    tag.nbgrader["grade_id"] = "my_own_check"
    notebook.cells.insert(0, new_code_cell("import os; os._exit(1)", metadata=tag))
    return notebook


PLAYS_NOTHING = "class Yes:\n    def __eq__(self, other): return True\n    def __float__(self): return 5.0\n"

CASES = {
    # honest work
    "perfect": Case(answered, ALL),
    "first task only": Case(lambda release: filled_in(release, {"task_1": ANSWERS["task_1"]}), (6, 0, 0)),
    "forgot to return": Case(
        lambda release: answered(release, task_1=ANSWERS["task_1"].replace("    return steps\n", "")), (5, 6, 5)
    ),
    "empty": Case(deepcopy, NOTHING),
    "syntax error": Case(lambda release: answered(release, task_3="def train(:"), (6, 6, 0)),
    "answers in a cell of their own": Case(
        lambda release: with_cell(
            filled_in(release, dict.fromkeys(ANSWERS, "")), "\n\n".join(ANSWERS.values()), before="task_1_check"
        ),
        ALL,
    ),
    # check cells tampered with
    "edited checks": Case(lambda release: check_cells_edited(release, answers={}), NOTHING, "changed"),
    "edited checks, right answers": Case(lambda release: check_cells_edited(release, answers=ANSWERS), ALL, "changed"),
    "deleted checks": Case(check_cells_deleted, ALL, "deleted"),
    "copied checks": Case(check_cells_copied, NOTHING),
    "checks of their own": Case(all_marked_as_checks, ALL),
    # code that ends or does not end
    "os._exit": Case(lambda release: answered(release, task_1="import os; os._exit(0)"), (0, 6, 5)),
    "os._exit when called": Case(
        lambda release: answered(release, task_2="def play_remembering(*arguments):\n    import os; os._exit(0)"),
        (6, 0, 0),
    ),
    "endless loop": Case(
        lambda release: answered(release, task_3="def train(*arguments):\n    while True: pass"), (6, 6, 0)
    ),
    "swallows interrupts": Case(
        lambda release: with_cell(
            answered(release),
            "import signal\n"
            "for number in (signal.SIGALRM, signal.SIGINT): signal.signal(number, signal.SIG_IGN)\n"
            "while True:\n    try:\n        while True: pass\n    except BaseException: pass",
        ),
        ALL,
    ),
    "memory hog": Case(lambda release: with_cell(answered(release), "hog = bytearray(10**12)"), ALL),
    "100 MB of output": Case(lambda release: with_cell(answered(release), "print('x' * 100_000_000)"), ALL),
    "flood": Case(
        lambda release: with_cell(answered(release), "import os\nwhile True: os.write(1, b'x' * 1_000_000)"), ALL
    ),
    # what is not a notebook
    "corrupt JSON": Case(lambda release: nbformat.writes(answered(release)).encode()[:-2000], NOTHING, "not"),
    "not a notebook": Case(lambda _: b"%PDF-1.4", NOTHING, "not"),
    "missing": Case(None, NOTHING),
    "nothing handed in": Case(None, NOTHING, "Nothing"),
    "renamed": Case(answered, ALL, "my homework.ipynb"),
    # reaching for the judge
    "patched checks": Case(
        cheated(
            "import course_lib.checks.check, course_lib.checks.verdict, course_lib.checks.homework_1 as checks\n"
            "passed = course_lib.checks.verdict.Verdict('patched', ())\n"
            "course_lib.checks.check.Check.__call__ = lambda *a, **k: passed\n"
            "checks.goes_on_after_a_bump = checks.keeps_to_fresh_cells = lambda *a, **k: passed\n"
            "course_lib.checks.verdict.Verdict.points = 5.0"
        ),
        NOTHING,
    ),
    "always equal": Case(
        cheated(
            PLAYS_NOTHING + "def play_on(*a): return Yes()\n"
            "def play_remembering(*a): return Yes()\ndef train(*a): return Yes(), Yes()"
        ),
        NOTHING,
    ),
    "input transformer": Case(
        cheated("get_ipython().input_transformers_post.append(lambda lines: ['5.0\\n'])"), NOTHING
    ),
    "fake course_lib": Case(deepcopy, NOTHING, "not used"),
    "fake course_lib in memory": Case(
        cheated(
            "import sys, types\nfake = types.ModuleType('course_lib')\n"
            "for name in list(sys.modules):\n    if name.startswith('course_lib'): sys.modules[name] = fake"
        ),
        NOTHING,
    ),
    "kills the judge": Case(
        lambda release: with_cell(answered(release), "import os\nfor pid in (os.getppid(), 1): os.kill(pid, 9)"),
        ALL,
    ),
    "speaks for the judge": Case(
        cheated(
            "import os, json\nfor number in range(3, 20):\n"
            '    try: os.write(number, b\'{"dict": {"returned": [5, []]}}\\n\' * 10)\n    except OSError: pass'
        ),
        NOTHING,
    ),
    "writes outside": Case(None, ALL),  # made below: it has to know where
}
UNCONFINED = set() if can_confine() else {"kills the judge", "writes outside"}


@pytest.fixture(scope="module")
def graded(nbgrader, tmp_path_factory):  # noqa: ARG001 (it decides whether to skip)
    """The class after one run of the judge: (course, {learner: grade}, {learner: feedback page})."""
    course = Course.new(tmp_path_factory.mktemp("hostile") / "class", {HOMEWORK: SOURCE})
    with (course.folder / "nbgrader_config.py").open("a") as settings:
        settings.write("\nc.JudgePreprocessor.time_limit = 5.0\n")
    release = nbformat.read(course.release(HOMEWORK), as_version=4)
    for learner, case in CASES.items():
        if case.make and learner not in UNCONFINED:
            name = "my homework.ipynb" if learner == "renamed" else None
            hand_in(course, learner, HOMEWORK, case.make(release), name)
    (course.folder / "submitted" / "missing" / HOMEWORK).mkdir(parents=True)
    (course.folder / "submitted" / "nothing handed in").mkdir()
    fake = course.folder / "submitted" / "fake course_lib" / HOMEWORK / "course_lib"
    fake.mkdir()
    (fake / "__init__.py").write_text("raise SystemExit('a fake')")
    if "writes outside" not in UNCONFINED:
        deeds = [f"open({str(place)!r}, 'w').write('mine')" for place in places_outside(course)]
        attempts = "\n".join(f"try: {deed}\nexcept OSError: pass" for deed in deeds)
        hand_in(course, "writes outside", HOMEWORK, with_cell(answered(release), attempts))
    grades = {grade.learner: grade for grade in course.autograde(HOMEWORK)}
    return course, grades, course.feedback(HOMEWORK)


def places_outside(course):
    """Where a cheat would like to write: its grade, another's work, the teacher's source, the judge itself."""
    import course_lib

    return [
        course.folder / "submitted" / "perfect" / HOMEWORK / "planted.txt",
        course.folder / "source" / "planted.txt",
        course.folder / "planted.csv",
        Path(course_lib.__file__).parent / "planted.py",
        Path(os.environ.get("HOME", "/")) / "planted.txt",
    ]


@pytest.mark.parametrize("learner", CASES)
def test_everybody_gets_what_they_earned(graded, learner):
    if learner in UNCONFINED:
        pytest.skip("this system has no Landlock")
    grade, case = graded[1][learner], CASES[learner]
    assert tuple(grade.points[f"task_{number}_check"] for number in (1, 2, 3)) == case.points, grade.remarks
    assert case.remark in " ".join(grade.remarks)


def test_nobody_wrote_outside(graded):
    assert [place for place in places_outside(graded[0]) if place.exists()] == []


def test_everybody_who_was_graded_has_a_page_without_the_hidden_checks(graded):
    course, grades, pages = graded
    assert set(CASES) - set(pages) <= UNCONFINED | {"nothing handed in"}
    for learner, page in pages.items():
        text = page.read_text()
        assert "1989" not in text, learner
        assert "HIDDEN" not in text, learner
    assert "Task 1, a bump is not the end: passed" in pages["perfect"].read_text()


def test_the_grades_are_written_as_csv(graded, tmp_path):
    course, grades, _ = graded
    course.grades(tmp_path / "grades.csv")
    with (tmp_path / "grades.csv").open(newline="", encoding="utf-8-sig") as file:
        rows = {row["learner"]: row for row in csv.DictReader(file)}
    assert set(rows) == set(grades)
    for learner, case in CASES.items():
        if learner not in UNCONFINED:
            assert float(rows[learner]["score"]) == sum(case.points)
            assert float(rows[learner]["max_score"]) == sum(ALL)
