"""Homework as learners get it: what nbgrader would release, links that lead somewhere, and a note of its source."""

import json
import subprocess
import sys
from copy import deepcopy

import nbformat
import pytest

from course_lib.classroom.templates import fingerprint, is_stale, template, write_template

from .school import HIDDEN, cell_of, released_notebook, source_notebook, tag


def texts(notebook):
    return [(cell.cell_type, cell.source) for cell in notebook.cells]


@pytest.fixture
def source():
    return source_notebook()


@pytest.fixture
def made(nbgrader, source):  # noqa: ARG001 (it decides whether to skip)
    return template(source, made_from="solutions/a.ipynb")


# --- what is in it ----------------------------------------------------------------------------------------------------


def test_solutions_and_hidden_tests_are_out_and_all_else_is_there(made):
    assert texts(made) == texts(released_notebook())


def test_it_is_cell_by_cell_what_nbgrader_releases(made, release):
    assert [dict(cell) for cell in made.cells] == [dict(cell) for cell in release.cells]
    assert all(cell.metadata.nbgrader.checksum for cell in made.cells if "nbgrader" in cell.metadata)


def test_what_is_given_out_is_locked_and_solutions_can_be_edited(made):
    for name in ("imports", "about_task_1", "task_1"):
        assert cell_of(made, name).metadata["editable"] is False
        assert cell_of(made, name).metadata["deletable"] is False
    assert "editable" not in cell_of(made, "double").metadata


def test_no_cell_ends_in_blank_lines(made):
    assert all(cell.source == cell.source.rstrip() for cell in made.cells)


@pytest.mark.parametrize("hidden", HIDDEN)
def test_no_word_of_the_hidden_tests_is_left(made, hidden):
    assert hidden in json.dumps(source_notebook())
    assert hidden not in json.dumps(made)


def test_outputs_are_out(nbgrader, source):  # noqa: ARG001
    source.cells[1].outputs = [nbformat.v4.new_output("stream", text="secret_number is 123456")]
    source.cells[1].execution_count = 7
    cell = template(source).cells[1]
    assert (cell.outputs, cell.execution_count) == ([], None)


def test_the_source_stays_as_it_is(made, source):  # noqa: ARG001
    assert source == source_notebook()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("[a](../03_q_table.ipynb)", "[a](03_q_table.ipynb)"),
        ("[a](../03_q_table.ipynb#part) and [b](../02.ipynb)", "[a](03_q_table.ipynb#part) and [b](02.ipynb)"),
        ("![maze](../pictures/maze.png)", "![maze](pictures/maze.png)"),
        ('<img alt="maze" src="../pictures/maze.png">', '<img alt="maze" src="pictures/maze.png">'),
        ("<a href='../README.md'>", "<a href='README.md'>"),
        ("See [it].\n\n[it]: ../03_q_table.ipynb", "See [it].\n\n[it]: 03_q_table.ipynb"),
        ("[a](../../README.md)", "[a](../README.md)"),
        ("[a](https://example.org/../x) goes `../up`", "[a](https://example.org/../x) goes `../up`"),
    ],
)
def test_links_are_those_of_a_notebook_one_folder_up(nbgrader, source, before, after):  # noqa: ARG001
    source.cells[0].source = before
    assert template(source).cells[0].source == after


def test_code_is_no_text_with_links(nbgrader, source):  # noqa: ARG001
    source.cells[1].source = "names['a'](../1)"
    assert template(source).cells[1].source == source.cells[1].source


# --- what it says of its source ---------------------------------------------------------------------------------------


def test_a_template_is_fresh_until_its_source_changes(made, source):
    assert not is_stale(made, source)
    for change in (
        lambda cells: cells.pop(),
        lambda cells: cells.reverse(),
        lambda cells: cells[1].update(source="import cmath"),
        lambda cells: cells[1].update(cell_type="raw"),
        lambda cells: cells[4].metadata.nbgrader.update(points=5),
    ):
        changed = deepcopy(source)
        change(changed.cells)
        assert is_stale(made, changed)


def test_outputs_ids_and_other_metadata_make_nothing_stale(made, source):
    source.cells[1].outputs = [nbformat.v4.new_output("stream", text="more")]
    source.cells[1].execution_count, source.cells[1].id = 3, "renamed"
    source.cells[1].metadata["collapsed"] = True
    assert not is_stale(made, source)


def test_a_notebook_that_names_no_source_is_stale(source):
    assert is_stale(released_notebook(), source)


def test_both_may_come_straight_from_their_files(made, source):
    in_lines = json.loads(nbformat.writes(source))
    assert isinstance(in_lines["cells"][2]["source"], list)
    assert not is_stale(json.loads(nbformat.writes(made)), in_lines)
    assert fingerprint(in_lines) == fingerprint(source)


def test_a_written_template_says_where_its_source_is(nbgrader, source, tmp_path):  # noqa: ARG001
    (tmp_path / "solutions").mkdir()
    nbformat.write(source, tmp_path / "solutions" / "a.ipynb")
    write_template(tmp_path / "solutions" / "a.ipynb", tmp_path / "a.ipynb")
    written = nbformat.read(tmp_path / "a.ipynb", as_version=4)
    nbformat.validate(written)
    assert written.metadata["course"] == {"made_from": "solutions/a.ipynb", "sha256": fingerprint(source)}
    assert texts(written) == texts(released_notebook())


# --- what can go wrong ------------------------------------------------------------------------------------------------


def test_a_source_that_is_marked_wrongly_is_refused(nbgrader, source):  # noqa: ARG001
    source.cells[1].source = "### BEGIN SOLUTION\nimport math\n### END SOLUTION"
    with pytest.raises(RuntimeError, match="non-solution cell"):
        template(source)


def test_a_source_that_nbgrader_cannot_take_is_refused_in_our_words(nbgrader, source):  # noqa: ARG001
    source.cells[1].metadata.update(tag("task_1", grade=True, points=1, locked=True))
    with pytest.raises(ValueError, match="not a source that nbgrader can take: Duplicate grade id: task_1"):
        template(source)


def without_nbgrader(code):
    blocked = f"import sys; sys.modules['nbgrader'] = None\n{code}"
    return subprocess.run([sys.executable, "-c", blocked], capture_output=True, text=True, timeout=60)


def test_staleness_is_known_without_nbgrader_and_without_jupyter():
    code = """
sys.modules['nbformat'] = None
from course_lib.classroom.templates import is_stale, fingerprint
source = {"cells": [{"cell_type": "code", "source": ["1"], "metadata": {}}], "metadata": {}}
print(is_stale({"metadata": {"course": {"sha256": fingerprint(source)}}}, source), is_stale({"metadata": {}}, source))
"""
    assert without_nbgrader(code).stdout.split() == ["False", "True"]


@pytest.mark.parametrize(
    "code",
    [
        "from course_lib.classroom.templates import template; template(None)",
        "from course_lib.classroom.templates import write_template; write_template('a', 'b')",
        "from course_lib.classroom.course import Course; Course('.')",
        "from course_lib.classroom.course import Course; Course.new('there_is_none')",
    ],
)
def test_without_nbgrader_one_sentence_says_what_to_install(code):
    last = without_nbgrader(code).stderr.strip().splitlines()[-1]
    assert last == 'ModuleNotFoundError: this needs nbgrader: pip install -e ".[teach]"'
