"""Work collected from an exchange in which anybody may have put anything; without a hub, and under one account."""

import os
import shutil
import subprocess
import sys
from datetime import UTC, datetime, timedelta

import nbformat
import pytest

from course_lib.classroom.__main__ import main
from course_lib.classroom.course import Course
from course_lib.classroom.exchange import NOT_GIVEN, Exchange

from .school import HOMEWORK, JUDGE, NEARLY, NOTEBOOK, RIGHT, STAND_IN, filled_in, hand_in, source_notebook

pwd = pytest.importorskip("pwd", reason="there is no exchange on Windows")
ME = pwd.getpwuid(os.getuid()).pw_name
NOW = datetime.now(UTC)


@pytest.fixture(scope="module")
def published(nbgrader, tmp_path_factory):  # noqa: ARG001 (it decides whether to skip)
    """A folder with a class and its exchange, to be copied."""
    folder = tmp_path_factory.mktemp("published")
    nbformat.write(source_notebook(), folder / NOTEBOOK)
    (folder / "exchange").mkdir()
    (folder / "exchange").chmod(0o1777)
    course = Course.new(folder / "demo", {HOMEWORK: folder / NOTEBOOK}, exchange=folder / "exchange")
    course.release(HOMEWORK)
    Exchange(course).publish(HOMEWORK)
    return folder


@pytest.fixture
def shared(published, tmp_path):
    """A class whose homework is on an exchange, with both of its own."""
    shutil.copytree(published, tmp_path, dirs_exist_ok=True)
    settings = tmp_path / "demo" / "nbgrader_config.py"
    settings.write_text(settings.read_text().replace(JUDGE, STAND_IN).replace(str(published), str(tmp_path)))
    return Exchange(Course(tmp_path / "demo"))


def submit(exchange, answers, *, learner=ME, when=NOW, end="+x", leave_out=()):
    """What nbgrader's `submit` leaves on the exchange; the folder."""
    stamp = f"{when:%Y-%m-%d %H:%M:%S.%f} UTC"
    folder = exchange.folder / "inbound" / f"{learner}+{HOMEWORK}+{stamp}{end}"
    folder.mkdir()
    release = nbformat.read(exchange.folder / "outbound" / HOMEWORK / NOTEBOOK, as_version=4)
    nbformat.write(filled_in(release, answers), folder / NOTEBOOK)
    for name, text in (("timestamp.txt", stamp), ("submission_secret.txt", f"secret of {learner}")):
        if name not in leave_out:
            (folder / name).write_text(text)
    return folder


def score(exchange):
    return {grade.learner: grade.score for grade in exchange.course.autograde(HOMEWORK)}


# --- what is on the exchange ------------------------------------------------------------------------------------------


def test_what_others_may_do_there(shared):
    modes = {path.name: path.stat().st_mode & 0o7777 for path in shared.folder.iterdir()}
    assert modes == {"inbound": 0o3733, "outbound": 0o755}
    assert shared.folder.stat().st_mode & 0o022 == 0
    released = shared.folder / "outbound" / HOMEWORK
    assert [path.name for path in released.iterdir()] == [NOTEBOOK]
    assert "BEGIN" not in (released / NOTEBOOK).read_text()


def test_the_folder_of_a_class_is_closed(shared):
    assert shared.course.folder.stat().st_mode & 0o077 == 0


def test_published_again_the_new_one_is_there(shared):
    outbound = shared.folder / "outbound" / HOMEWORK / NOTEBOOK
    outbound.chmod(0o644)
    outbound.write_text("old")
    assert shared.publish(HOMEWORK) == outbound.parent
    assert "double" in outbound.read_text()


def test_a_page_goes_where_only_its_secret_leads(shared):
    from nbgrader.utils import notebook_hash

    submit(shared, RIGHT)
    shared.collect(HOMEWORK)
    assert score(shared) == {ME: 6}
    shared.course.feedback(HOMEWORK)
    assert shared.give_back(HOMEWORK) == [ME]
    name = notebook_hash(secret=f"secret of {ME}", notebook_id=NOTEBOOK.removesuffix(".ipynb"))
    (page,) = (shared.folder / "feedback").iterdir()
    assert page.name == f"{name}.html"
    assert page.stat().st_mode & 0o444 == 0o444
    assert (shared.folder / "feedback").stat().st_mode & 0o077 == 0o011


def test_work_that_the_judge_broke_at_has_its_page_too(shared):
    submit(shared, {"double": "# break the judge"})
    shared.collect(HOMEWORK)
    assert score(shared) == {ME: 0}
    shared.course.feedback(HOMEWORK)
    assert shared.give_back(HOMEWORK) == [ME]


def test_who_cannot_have_a_page_does_not_stop_the_others(shared):
    release = nbformat.read(shared.course.released(HOMEWORK), as_version=4)
    hand_in(shared.course, "ann", HOMEWORK, filled_in(release, RIGHT))  # by e-mail
    submit(shared, NEARLY)
    shared.collect(HOMEWORK)
    score(shared)
    shared.course.feedback(HOMEWORK)
    assert shared.give_back(HOMEWORK) == [ME]
    assert shared.give_back(HOMEWORK) == [ME]
    remarks = shared.course.ledger.remarks(HOMEWORK)
    assert [said.startswith(NOT_GIVEN) for said in remarks["ann"]] == [True]
    assert remarks[ME] == []


# --- collecting -------------------------------------------------------------------------------------------------------


def test_the_newest_work_counts(shared):
    submit(shared, RIGHT, when=NOW - timedelta(minutes=2))
    assert shared.collect(HOMEWORK) == ([ME], [])
    assert score(shared) == {ME: 6}
    submit(shared, NEARLY)
    assert shared.collect(HOMEWORK) == ([ME], [])
    assert shared.collect(HOMEWORK) == ([], [])
    assert score(shared) == {ME: 4}
    assert sorted(path.name for path in (shared.course.folder / "submitted" / ME).iterdir()) == [HOMEWORK]


def test_work_in_anothers_name_is_left_alone(shared):
    submit(shared, RIGHT)
    submit(shared, {}, learner="somebody", when=NOW + timedelta(minutes=1))
    submit(shared, {}, learner="%2E%2E", end="")
    learners, notes = shared.collect(HOMEWORK)
    assert learners == [ME]
    assert len(notes) == 2
    assert all(f"is not collected: it was put there by {ME}." in note for note in notes)
    assert [path.name for path in (shared.course.folder / "submitted").iterdir()] == [ME]


@pytest.mark.parametrize(
    "name", [f"{ME}+{HOMEWORK}+never+x", f"x+{HOMEWORK}+y", f"+{HOMEWORK}+", f"a+{HOMEWORK}+{'9' * 30}"]
)
def test_a_name_that_is_none_stops_nobody(shared, name):
    (shared.folder / "inbound" / name).mkdir()
    submit(shared, RIGHT)
    learners, (note,) = shared.collect(HOMEWORK)
    assert learners == [ME]
    assert note.startswith(f"{name} is not collected: ")


def test_what_is_no_folder_is_not_followed(shared):
    stamp = f"{NOW:%Y-%m-%d %H:%M:%S.%f} UTC"
    (shared.folder / "inbound" / f"{ME}+{HOMEWORK}+{stamp}+x").symlink_to(shared.course.folder / "source" / HOMEWORK)
    learners, (note,) = shared.collect(HOMEWORK)
    assert learners == []
    assert "it is no folder" in note


def test_links_and_pipes_in_it_are_left_out(shared):
    folder = submit(shared, {})
    (folder / NOTEBOOK).unlink()
    (folder / NOTEBOOK).symlink_to(shared.course.folder / "source" / HOMEWORK / NOTEBOOK)
    (folder / "source").symlink_to(shared.course.folder / "source")
    os.mkfifo(folder / "pipe.txt")
    learners, notes = shared.collect(HOMEWORK)
    assert learners == [ME]
    assert len(notes) == 2
    collected = shared.course.folder / "submitted" / ME / HOMEWORK
    assert sorted(path.name for path in collected.iterdir()) == ["submission_secret.txt", "timestamp.txt"]
    assert score(shared) == {ME: 0}


@pytest.mark.parametrize("name", ["timestamp.txt", "submission_secret.txt"])
def test_what_is_still_being_copied_waits_and_what_was_there_stays(shared, name):
    submit(shared, RIGHT, when=NOW - timedelta(minutes=2))
    shared.collect(HOMEWORK)
    folder = submit(shared, NEARLY, leave_out=[name])
    learners, (note,) = shared.collect(HOMEWORK)
    assert learners == []
    assert "collect again in a minute" in note
    assert score(shared) == {ME: 6}
    (folder / name).write_text(f"{NOW:%Y-%m-%d %H:%M:%S.%f} UTC")
    assert shared.collect(HOMEWORK) == ([ME], [])
    assert score(shared) == {ME: 4}


def test_a_time_that_cannot_be_is_said(shared):
    submit(shared, RIGHT, when=NOW - timedelta(hours=5))
    learners, (note,) = shared.collect(HOMEWORK)
    assert learners == [ME]
    assert f"{NOW - timedelta(hours=5):%Y-%m-%d %H:%M}" in note


def test_nbgraders_own_command_collects_the_same_way(shared):
    submit(shared, RIGHT)
    submit(shared, {}, learner="somebody")
    command = [sys.executable, "-m", "nbgrader", "collect", HOMEWORK]
    subprocess.run(command, cwd=shared.course.folder, check=True, capture_output=True)
    assert [path.name for path in (shared.course.folder / "submitted").iterdir()] == [ME]


# --- copying ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def copy_own_files(nbgrader):  # noqa: ARG001 (it decides whether to skip)
    from course_lib.classroom.collect import copy_own_files

    return copy_own_files


def test_only_what_belongs_to_the_owner_is_copied(copy_own_files, tmp_path):
    source = tmp_path / "source"
    (source / "data").mkdir(parents=True)
    (source / "data" / "a.csv").write_text("1")
    for hidden in (".git", "__pycache__"):
        (source / hidden).mkdir()
        (source / hidden / "b").write_text("2")
    assert copy_own_files(source, tmp_path / "a", os.getuid(), 10) == []
    assert [path.name for path in (tmp_path / "a").rglob("*")] == ["data", "a.csv"]
    assert len(copy_own_files(source, tmp_path / "b", os.getuid() + 1, 10)) == 1
    assert [path.name for path in (tmp_path / "b").rglob("*")] == ["data"]


def test_too_much_is_refused(copy_own_files, tmp_path):
    (tmp_path / "source").mkdir()
    (tmp_path / "source" / "a").write_bytes(b"x" * 11)
    with pytest.raises(ValueError, match="larger than"):
        copy_own_files(tmp_path / "source", tmp_path / "a", os.getuid(), 10)


# --- what cannot be done ----------------------------------------------------------------------------------------------


def test_a_class_without_an_exchange_says_so(course, capsys):
    for command in (["collect", HOMEWORK], ["release", HOMEWORK, "--exchange"], ["feedback", HOMEWORK, "--exchange"]):
        assert main([*command, "--folder", str(course.folder)]) == 1
        assert capsys.readouterr().err.startswith("error: this class has no exchange")


def test_an_exchange_that_is_not_there_is_refused_before_anything_is_made(nbgrader, tmp_path):  # noqa: ARG001
    with pytest.raises(FileNotFoundError, match="exchange"):
        Course.new(tmp_path / "demo", {}, exchange=tmp_path / "nowhere")
    with pytest.raises(ValueError, match="letters"):
        Course.new(tmp_path / "a class", {}, exchange=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_collected_before_the_release(shared, tmp_path):  # noqa: ARG001
    course = Course.new(tmp_path / "second", {HOMEWORK: tmp_path / NOTEBOOK}, exchange=tmp_path / "exchange")
    exchange = Exchange(course)
    for step in (exchange.publish, exchange.collect, exchange.give_back):
        with pytest.raises(FileNotFoundError, match="not been released"):
            step(HOMEWORK)


def test_from_the_command_line(shared, capsys):
    folder = ["--folder", str(shared.course.folder)]
    assert main(["release", HOMEWORK, "--exchange", *folder]) == 0
    assert capsys.readouterr().out.endswith(f"{shared.folder}/outbound/{HOMEWORK}\n")
    assert main(["collect", HOMEWORK, *folder]) == 0
    assert capsys.readouterr() == ("no new work\n", "")
    submit(shared, RIGHT)
    submit(shared, {}, learner="somebody")
    assert main(["collect", HOMEWORK, *folder]) == 0
    said = capsys.readouterr()
    assert said.out == f"new work of {ME}\n"
    assert "somebody" in said.err
    assert main(["autograde", HOMEWORK, *folder]) == 0
    assert main(["feedback", HOMEWORK, "--exchange", *folder]) == 0
    assert capsys.readouterr().out.endswith("given back to 1 of 1\n")
