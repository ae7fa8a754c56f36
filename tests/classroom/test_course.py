"""A class from the first release to the last page, with all kinds of learners in it."""

import csv
import os
from pathlib import Path
from types import SimpleNamespace

import nbformat
import pytest

from course_lib.classroom.ledger import student_id

from .school import (
    FORMULA,
    HIDDEN,
    HOMEWORK,
    NEARLY,
    NOTEBOOK,
    ODD_NAMES,
    RIGHT,
    filled_in,
    hand_in,
    new_class,
    with_tricks,
)

WITHOUT_POINTS = ["cut", "empty folder", "breaker", "door", "untouched", "gus", "zoe"]


@pytest.fixture(scope="module")
def school(nbgrader, tmp_path_factory):  # noqa: ARG001 (it decides whether to skip)
    """A graded class: its `course`, the `grades` by learner, the feedback `pages` and what was handed in."""
    course = new_class(tmp_path_factory.mktemp("school"))
    release = nbformat.read(course.release(HOMEWORK), as_version=4)
    right = filled_in(release, RIGHT)
    submitted = course.folder / "submitted"
    for learner in ("ann", *ODD_NAMES):
        hand_in(course, learner, HOMEWORK, right)
    hand_in(course, "bob", HOMEWORK, filled_in(release, NEARLY))
    hand_in(course, "untouched", HOMEWORK, release)
    hand_in(course, "otherwise", HOMEWORK, right, name="mine.ipynb")
    hand_in(course, "cut", HOMEWORK, nbformat.writes(right).encode()[:700])
    hand_in(course, "tricks", HOMEWORK, with_tricks(release))
    hand_in(course, "breaker", HOMEWORK, filled_in(release, RIGHT | {"shout": "# break the judge"}))
    (submitted / "empty folder" / HOMEWORK).mkdir(parents=True)
    (submitted / "door").symlink_to(submitted / "files")
    (submitted / "readme.txt").write_text("No learner.")
    (submitted / ".ipynb_checkpoints").mkdir()
    files = hand_in(course, "files", HOMEWORK, right).parent
    (files / "data").mkdir()
    (files / "data" / "maze.csv").write_text("1,2")
    (files / "numpy.py").write_text("raise SystemExit")
    (files / "timestamp.txt").write_text("yesterday")
    (files / "solutions").symlink_to(course.folder / "source")
    (files / "source.csv").symlink_to(course.folder / "source" / HOMEWORK / NOTEBOOK)
    (course.folder / "roster.csv").write_text("\ufefflearner;group\nann;1\nzoe;2\n\n", encoding="utf-8")
    with course.ledger.gradebook() as gradebook:
        gradebook.add_student("gus")
    before = tree(submitted)
    grades = {grade.learner: grade for grade in course.autograde(HOMEWORK)}
    pages = course.feedback(HOMEWORK)
    return SimpleNamespace(course=course, release=release, grades=grades, pages=pages, before=before)


def tree(folder):
    """Everything in a folder: names, content, times and rights."""
    found = {}
    for place, folders, files in os.walk(folder):
        for path in (os.path.join(place, name) for name in (*folders, *files)):
            status = os.lstat(path)
            content = Path(path).read_bytes() if os.path.isfile(path) else b""
            found[path] = (status.st_mode, status.st_mtime_ns, content)
    return found


# --- grades -----------------------------------------------------------------------------------------------------------


def test_everybody_has_a_grade(school):
    expected = {"ann", "bob", "otherwise", "tricks", "files", *ODD_NAMES, *WITHOUT_POINTS}
    assert set(school.grades) == set(school.course.learners) == expected


@pytest.mark.parametrize("learner", ["ann", "otherwise", "files", *ODD_NAMES])
def test_right_is_right_whatever_the_learners_name(school, learner):
    grade = school.grades[learner]
    assert (grade.points, grade.score, grade.max_score) == ({"task_1": 4, "task_2": 2}, 6, 6)


def test_hidden_tests_count(school):
    assert school.grades["bob"].points == {"task_1": 2, "task_2": 2}


def test_tricks_with_check_cells_earn_nothing(school):
    assert school.grades["tricks"].points == school.grades["bob"].points
    assert len(school.grades["tricks"].remarks) == 2


@pytest.mark.parametrize("learner", WITHOUT_POINTS)
def test_what_cannot_be_graded_has_no_points_and_never_stops_the_others(school, learner):
    grade = school.grades[learner]
    assert (grade.points, grade.score, grade.max_score) == ({"task_1": 0, "task_2": 0}, 0, 6)


@pytest.mark.parametrize(
    ("learner", "remarks"),
    [
        ("ann", []),
        ("untouched", []),
        ("zoe", ["Nothing handed in."]),
        ("gus", ["Nothing handed in."]),
        ("cut", [f"{NOTEBOOK} is not JSON", "Nothing to grade"]),
        ("empty folder", ["Nothing to grade: the submission's folder holds no notebook"]),
        ("door", ["Nothing to grade: the submission's folder is a link"]),
        ("breaker", ["It could not be graded and has no points: RuntimeError: the judge is broken"]),
        ("otherwise", [f"{NOTEBOOK} was not there or not readable; mine.ipynb was graded."]),
        ("files", ["Code in files of its own is not used: numpy.py.", "timestamp.txt holds no time"]),
    ],
)
def test_remarks_say_why(school, learner, remarks):
    found = school.grades[learner].remarks
    assert len(found) == len(remarks)
    for remark, start in zip(found, remarks, strict=True):
        assert remark.startswith(start)


@pytest.mark.parametrize("learner", sorted({*WITHOUT_POINTS} - {"gus", "zoe"}))
def test_the_gradebook_holds_zeros_where_there_was_something_to_grade(school, learner):
    with school.course.ledger.gradebook() as gradebook:
        submission = gradebook.find_submission(HOMEWORK, student_id(learner))
        grades = [grade for notebook in submission.notebooks for grade in notebook.grades]
        assert [grade.auto_score for grade in grades] == [0, 0]
        assert not any(grade.needs_manual_grade for grade in grades)


def test_nothing_that_was_handed_in_is_changed(school):
    assert tree(school.course.folder / "submitted") == school.before


def test_data_files_come_along_and_links_and_modules_do_not(school):
    folder = school.course.folder / "autograded" / "files" / HOMEWORK
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert found == {NOTEBOOK, "data/maze.csv"}
    door = school.course.folder / "autograded" / "door" / HOMEWORK
    assert [path.name for path in door.rglob("*")] == [NOTEBOOK]


def test_grading_again_changes_nothing(school):
    again = school.course.autograde(HOMEWORK, learners=["ann", "tricks", "breaker", "cut"])
    assert again == [school.grades[grade.learner] for grade in again]
    assert len(again) == 4


def test_the_table_has_a_row_for_everyone(school, tmp_path):
    rows = school.course.grades(tmp_path / "grades.csv")
    assert {row["learner"]: row["score"] for row in rows} == {
        learner: grade.score for learner, grade in school.grades.items()
    }
    assert list(rows[0]) == ["learner", "homework", "task_1", "task_2", "score", "max_score", "remarks"]
    assert [path.name for path in tmp_path.iterdir()] == ["grades.csv"]
    with open(tmp_path / "grades.csv", encoding="utf-8-sig", newline="") as file:
        written = {row["learner"]: row for row in csv.DictReader(file)}
    assert written["ann"] == {
        key: str(value) for key, value in school.course.ledger.grade(HOMEWORK, "ann").row().items()
    }
    assert FORMULA not in written
    assert "'" + FORMULA in written


# --- feedback ---------------------------------------------------------------------------------------------------------


def test_everybody_who_handed_something_in_has_a_page(school):
    assert set(school.pages) == set(school.grades) - {"gus", "zoe"}
    for learner, path in school.pages.items():
        score = school.grades[learner].score
        assert f"(Score: {score} / 6.0)" in path.read_text(), learner


def test_no_page_shows_a_hidden_test(school):
    graded = school.course.folder / "autograded" / "ann" / HOMEWORK / NOTEBOOK
    for hidden in HIDDEN:
        assert hidden in graded.read_text(), "it was graded with hidden tests"
    for path in school.pages.values():
        words = path.read_text()
        for secret in ("secret_number", "secret_words", "123456", "quiet please"):
            assert secret not in words


def test_a_page_shows_the_learners_own_code(school):
    assert "BEGIN HIDDEN TESTS" in school.pages["tricks"].read_text()
    assert "a table" in school.pages["bob"].read_text()


@pytest.mark.parametrize("path", [os.defpath, None])
def test_the_environment_is_left_as_it_was(nbgrader, tmp_path, monkeypatch, path):  # noqa: ARG001
    monkeypatch.delenv("PATH") if path is None else monkeypatch.setenv("PATH", path)
    before = dict(os.environ)
    course = new_class(tmp_path)
    course.release(HOMEWORK)
    assert (course.folder / "gradebook.db").is_file(), "it was made without `alembic` in PATH"
    assert dict(os.environ) == before
