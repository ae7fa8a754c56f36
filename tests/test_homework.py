"""The homework that lies in the course: every template is that of its source, untouched, and worth what it says."""

import importlib
import re
from pathlib import Path

import nbformat
import pytest

from course_lib.checks.check import Check
from course_lib.classroom.templates import is_stale

NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"
SOURCES = sorted(NOTEBOOKS.glob("solutions/[0-9][0-9]_homework_*.ipynb"))


@pytest.fixture(params=SOURCES, ids=lambda path: path.stem)
def source(request):
    return nbformat.read(request.param, as_version=4)


@pytest.fixture
def template(request, source):  # noqa: ARG001 (to be told apart by it)
    return nbformat.read(NOTEBOOKS / request.node.callspec.params["source"].name, as_version=4)


@pytest.fixture
def homework(request):
    """The module that checks it."""
    name = re.sub(r"^\d+_", "", request.node.callspec.params["source"].stem)
    return importlib.import_module(f"course_lib.checks.{name}")


def check_cells(notebook):
    return [cell for cell in notebook.cells if cell.metadata.get("nbgrader", {}).get("grade")]


def shown(cell):
    """The plain text of what a check cell shows."""
    return cell.outputs[-1].data["text/plain"]


def test_there_is_homework():
    assert SOURCES


def test_every_template_has_its_source():
    assert {path.name for path in NOTEBOOKS.glob("[0-9]*_homework_*.ipynb")} == {path.name for path in SOURCES}


def test_no_template_is_stale(source, template):
    assert not is_stale(template, source), "make it again: python -m course_lib.classroom template, then store_outputs"


def test_a_template_gives_nothing_away(template):
    assert not re.search("SOLUTION|HIDDEN", nbformat.writes(template))


def test_every_check_of_an_untouched_template_says_not_started(template):
    for cell in check_cells(template):
        assert re.match(r".*: not started \(0 of \d+ points\)", shown(cell)), cell.source
        assert "✓" not in shown(cell)


def test_every_check_of_the_source_is_passed_in_hidden_mazes_too(source):
    for cell in check_cells(source):
        assert "BEGIN HIDDEN TESTS" in cell.source
        assert re.match(r".*: passed \(", shown(cell)), cell.source


def test_every_task_has_its_check_and_its_points(source, homework):
    checks = [value for value in vars(homework).values() if isinstance(value, Check)]
    used = [re.search(r"checks\.(\w+)\((\w+)\)", cell.source).groups() for cell in check_cells(source)]
    assert [getattr(homework, name) for name, _ in used] == checks
    for cell, check, (_, function) in zip(check_cells(source), checks, used, strict=True):
        assert cell.metadata.nbgrader.points == check.max_points
        assert check.usage.startswith(f"{function}(")


def test_every_task_begins_with_a_signature_and_its_meaning(template):
    tasks = [cell.source for cell in template.cells if cell.metadata.get("nbgrader", {}).get("solution")]
    assert len(tasks) == len(check_cells(template))
    stub = re.compile(r'def \w+\(.*\):\n    """.*"""\n    raise NotImplementedError  # your code here', re.DOTALL)
    assert [task for task in tasks if not stub.fullmatch(task)] == []
