"""What a teacher does with a class, again and again and by hand, and what is said where it cannot be done."""

import os
import subprocess
import sys
import warnings

import nbformat
import pytest

from course_lib.classroom import course as course_module
from course_lib.classroom.course import Course, homeworks_of_the_course
from course_lib.classroom.submissions import read_submission

from .school import (
    HOMEWORK,
    NEARLY,
    NOTEBOOK,
    RIGHT,
    filled_in,
    hand_in,
    new_class,
    source_notebook,
    with_tricks,
)

# --- a teacher's hand -------------------------------------------------------------------------------------------------


def test_points_given_by_hand_stay_and_new_work_counts(course, release):
    hand_in(course, "ann", HOMEWORK, release)
    assert course.autograde(HOMEWORK)[0].score == 0
    with course.ledger.gradebook() as gradebook:
        gradebook.find_grade("task_1", NOTEBOOK.removesuffix(".ipynb"), HOMEWORK, "ann").manual_score = 3
        gradebook.db.commit()
    hand_in(course, "ann", HOMEWORK, filled_in(release, RIGHT))
    assert course.autograde(HOMEWORK)[0].points == {"task_1": 3, "task_2": 2}
    for worse in (filled_in(release, {"shout": "# break the judge"}), b"{"):
        hand_in(course, "ann", HOMEWORK, worse)
        assert course.autograde(HOMEWORK)[0].points == {"task_1": 3, "task_2": 0}


def test_only_some_can_be_graded(course, release):
    for learner in ("ann", "bob"):
        hand_in(course, learner, HOMEWORK, filled_in(release, RIGHT))
    assert [grade.learner for grade in course.autograde(HOMEWORK, learners=["bob"])] == ["bob"]
    assert {row["learner"]: row["score"] for row in course.grades()} == {"ann": 0, "bob": 6}
    with pytest.raises(ValueError, match="there is no learner called nobody"):
        course.autograde(HOMEWORK, learners=["bob", "nobody"])


def test_whatever_goes_wrong_with_one_the_others_are_graded(course, release, monkeypatch):
    def read(folder, *arguments):
        if folder.parent.name == "ann":
            raise MemoryError("what nobody thought of")
        return read_submission(folder, *arguments)

    for learner in ("ann", "bob"):
        hand_in(course, learner, HOMEWORK, filled_in(release, RIGHT))
    assert [grade.score for grade in course.autograde(HOMEWORK)] == [6, 6]
    monkeypatch.setattr(course_module, "read_submission", read)
    ann, bob = course.autograde(HOMEWORK)
    assert (ann.score, bob.score) == (0, 6)
    assert ann.remarks == ("It could not be graded and has no points: MemoryError: what nobody thought of",)


def test_what_sqlalchemy_warns_nbgrader_of_is_not_for_teachers(course, release):
    from sqlalchemy.exc import SAWarning

    hand_in(course, "ann", HOMEWORK, filled_in(release, RIGHT))
    with warnings.catch_warnings(action="error", category=SAWarning):
        assert course.autograde(HOMEWORK)[0].score == 6


def test_a_teacher_who_stops_it_stops_it(course, release, monkeypatch):
    hand_in(course, "ann", HOMEWORK, release)
    stopped = {"success": False, "error": "Traceback\nKeyboardInterrupt\n"}
    monkeypatch.setattr(type(course.nbgrader), "autograde", lambda *_: stopped)
    with pytest.raises(KeyboardInterrupt):
        course.autograde(HOMEWORK)


def test_plain_nbgrader_uses_the_same_judge_and_is_not_stopped_by_copies(course, release):
    hand_in(course, "ann", HOMEWORK, filled_in(release, RIGHT))
    hand_in(course, "tricks", HOMEWORK, with_tricks(release))
    done = subprocess.run(
        [sys.executable, "-m", "nbgrader", "autograde", HOMEWORK],
        cwd=course.folder,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert "The check cell task_1 had been changed" in done.stderr
    assert {row["learner"]: row["score"] for row in course.grades()} == {"ann": 6, "tricks": 4}


def test_where_no_page_can_be_made_a_remark_says_so_until_it_can(course, release, monkeypatch):
    hand_in(course, "ann", HOMEWORK, filled_in(release, RIGHT))
    course.autograde(HOMEWORK)
    failed = {"success": False, "error": "Traceback\nValueError: no page today"}
    with monkeypatch.context() as patch:
        patch.setattr(type(course.nbgrader), "generate_feedback", lambda *_: failed)
        for _ in range(2):
            assert course.feedback(HOMEWORK) == {}
    said = ("No feedback page could be made: ValueError: no page today",)
    assert course.ledger.grade(HOMEWORK, "ann").remarks == said
    assert list(course.feedback(HOMEWORK)) == ["ann"]
    assert course.ledger.grade(HOMEWORK, "ann").remarks == ()


# --- releases ---------------------------------------------------------------------------------------------------------


def change_source(course, change):
    path = course.folder / "source" / HOMEWORK / NOTEBOOK
    source = nbformat.read(path, as_version=4)
    change(source.cells)
    nbformat.write(source, path)


def test_a_release_can_be_made_again_with_other_hidden_tests(course, release):
    hand_in(course, "bob", HOMEWORK, filled_in(release, NEARLY))
    assert course.autograde(HOMEWORK)[0].score == 4
    change_source(
        course, lambda cells: cells[4].update(source=cells[4].source.replace("123456", "3").replace("246912", "6"))
    )
    course.release(HOMEWORK)
    assert course.autograde(HOMEWORK)[0].score == 6


def test_a_release_that_fails_says_why_and_leaves_the_old_one(course, release):
    hand_in(course, "ann", HOMEWORK, filled_in(release, RIGHT))
    course.autograde(HOMEWORK)
    change_source(course, lambda cells: cells.pop(4))
    with pytest.raises(RuntimeError, match=f"{HOMEWORK} was not released: RuntimeError: Cannot add or remove cells"):
        course.release(HOMEWORK)
    assert nbformat.read(course.folder / "release" / HOMEWORK / NOTEBOOK, as_version=4) == release
    assert course.autograde(HOMEWORK)[0].score == 6


def test_a_new_class_is_nbgraders_folder(nbgrader, tmp_path):  # noqa: ARG001
    course = new_class(tmp_path)
    assert course.homeworks == [HOMEWORK]
    assert sorted(path.name for path in course.folder.iterdir()) == ["nbgrader_config.py", "source", "submitted"]
    assert course.learners == []
    assert course.grades() == []


def test_what_is_missing_is_said(nbgrader, tmp_path):  # noqa: ARG001
    course = new_class(tmp_path)
    with pytest.raises(FileNotFoundError, match="homework_1 has not been released yet"):
        course.autograde(HOMEWORK)
    with pytest.raises(ValueError, match="there is no homework_7 here, only homework_1"):
        course.release("homework_7")
    with pytest.raises(FileExistsError, match="is there already and not empty"):
        Course.new(course.folder, {})
    with pytest.raises(FileNotFoundError, match="is not the folder of a class"):
        Course(tmp_path)
    with pytest.raises(FileNotFoundError, match="there is no notebook"):
        Course.new(tmp_path / "other", {HOMEWORK: tmp_path / "missing.ipynb"})
    assert not (tmp_path / "other").exists()
    (tmp_path / "[1]").mkdir()
    with pytest.raises(ValueError, match="nbgrader cannot work in"):
        Course.new(tmp_path / "[1]" / "class", {})


def test_a_damaged_gradebook_is_said_in_a_sentence(nbgrader, tmp_path):  # noqa: ARG001
    course = new_class(tmp_path)
    (course.folder / "gradebook.db").write_bytes(b"no database at all, but long enough to be looked at" * 100)
    with pytest.raises(RuntimeError, match=r"the gradebook .* cannot be used: file is not a database"):
        course.release(HOMEWORK)


def test_a_roster_without_names_is_said(course):
    (course.folder / "roster.csv").write_text("name\nann\n")
    with pytest.raises(ValueError, match="no column called learner; its first line is 'name'"):
        course.autograde(HOMEWORK)


def test_the_courses_own_homeworks_are_found_or_missed(tmp_path, monkeypatch):
    monkeypatch.setattr(course_module, "SOLUTIONS", tmp_path)
    with pytest.raises(FileNotFoundError, match="needs a clone of the course's repository"):
        homeworks_of_the_course()
    nbformat.write(source_notebook(), tmp_path / NOTEBOOK)
    assert homeworks_of_the_course() == {HOMEWORK: tmp_path / NOTEBOOK}
