"""python -m course_lib.classroom: what it prints, what it says is wrong, and its exit codes."""

import re
import subprocess
import sys

import nbformat
import pytest

from course_lib.classroom.__main__ import main

from .school import HOMEWORK, NEARLY, NOTEBOOK, RIGHT, filled_in, hand_in, source_notebook

NOTHING = "Nothing to grade: no notebook of this homework can be read."
COMMANDS = ["new", "release", "collect", "autograde", "feedback", "grades", "template", "hub", "links"]


def said(capsys, *arguments):
    """(exit code, what was printed, what was said to be wrong)."""
    try:
        code = main([str(argument) for argument in arguments])
    except SystemExit as end:
        code = end.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_help_names_every_command_and_needs_no_nbgrader():
    code = (
        "import sys; sys.modules['nbgrader'] = None; from course_lib.classroom.__main__ import main; main(['--help'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    for command in COMMANDS:
        assert re.search(rf"\n +{command}\s", done.stdout)
    assert len(done.stdout.splitlines()) < 30


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(capsys, command):
    code, printed, _ = said(capsys, command, "--help")
    assert code == 0
    assert printed.startswith(f"usage: python -m course_lib.classroom {command}")


@pytest.mark.parametrize(
    "arguments", [[], ["grade"], ["autograde"], ["release", "homework_1", "--loud"], ["template", "a"]]
)
def test_what_is_not_understood_ends_with_2(capsys, arguments):
    code, _, wrong = said(capsys, *arguments)
    assert code == 2
    assert "usage: " in wrong


def test_without_nbgrader_it_says_what_to_install(capsys, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "nbgrader", None)
    for arguments in (["new", tmp_path / "class"], ["grades"], ["template", "a", "b"]):
        assert said(capsys, *arguments) == (1, "", 'error: this needs nbgrader: pip install -e ".[teach]"\n')


def test_a_class_from_the_first_command_to_the_last(course, release, capsys, tmp_path):
    folder = ["--folder", course.folder]
    assert said(capsys, "release", HOMEWORK, *folder) == (0, f"{course.folder}/release/{HOMEWORK}/{NOTEBOOK}\n", "")
    hand_in(course, "ann", HOMEWORK, filled_in(release, RIGHT))
    hand_in(course, "bob", HOMEWORK, filled_in(release, NEARLY))
    hand_in(course, "c\x1b[1m", HOMEWORK, b"")
    table = [
        "learner  homework    score   remarks",
        "ann      homework_1  6 of 6",
        "bob      homework_1  4 of 6",
        f"c?[1m    homework_1  0 of 6  {NOTEBOOK} is empty. {NOTHING}",
    ]
    code, printed, wrong = said(capsys, "autograde", HOMEWORK, *folder)
    assert (code, printed.splitlines(), wrong) == (0, table, "")
    code, printed, _ = said(capsys, "autograde", HOMEWORK, "--learner", "bob", *folder)
    assert (code, printed.splitlines()) == (0, [table[0], table[2]])
    code, printed, _ = said(capsys, "feedback", HOMEWORK, *folder)
    assert (code, len(printed.splitlines())) == (0, 3)
    code, printed, _ = said(capsys, "grades", "--csv", tmp_path / "grades.csv", *folder)
    assert (code, printed.splitlines()) == (0, table)
    assert (tmp_path / "grades.csv").read_text(encoding="utf-8-sig").startswith("learner,homework,task_1,task_2,score")


def test_a_new_class_has_the_courses_homework(nbgrader, capsys, tmp_path):  # noqa: ARG001 (it decides whether to skip)
    code, printed, _ = said(capsys, "new", tmp_path / "class")
    assert (code, printed) == (0, f"made {tmp_path / 'class'} with homework_1, homework_2, homework_3\n")
    for name in ("homework_1/04_homework_1", "homework_2/05_homework_2", "homework_3/07_homework_3"):
        assert (tmp_path / "class" / "source" / f"{name}.ipynb").is_file()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["feedback", HOMEWORK], "nothing of homework_1 has been graded yet"),
        (["release", "homework_7"], "there is no homework_7 here, only homework_1"),
        (["autograde", HOMEWORK, "--learner", "nobody"], "there is no learner called nobody"),
        (["grades", "--csv", "no/folder/grades.csv"], "there is no folder"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line_and_ends_with_1(course, capsys, arguments, problem):
    code, _, wrong = said(capsys, *arguments, "--folder", course.folder)
    assert code == 1
    assert wrong.startswith("error: ")
    assert problem in wrong
    assert wrong.count("\n") == 1


def test_stopping_it_is_no_traceback(course, capsys, monkeypatch):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(type(course), "autograde", stop)
    assert said(capsys, "autograde", HOMEWORK, "--folder", course.folder) == (
        1,
        "",
        "stopped; what was graded so far is kept\n",
    )


def test_a_template_needs_no_class(nbgrader, capsys, tmp_path):  # noqa: ARG001 (it decides whether to skip)
    nbformat.write(source_notebook(), tmp_path / "source.ipynb")
    assert said(capsys, "template", tmp_path / "source.ipynb", tmp_path / "a.ipynb") == (0, "", "")
    assert "BEGIN" not in (tmp_path / "a.ipynb").read_text()
    (tmp_path / "source.ipynb").write_text("{")
    code, _, wrong = said(capsys, "template", tmp_path / "source.ipynb", tmp_path / "b.ipynb")
    assert (code, wrong.startswith("error: "), wrong.count("\n")) == (1, True, 1)
    assert not (tmp_path / "b.ipynb").exists()
