"""The course's own homework with its real judge: what its author wrote has all points, what learners get has none."""

import re
from html import unescape

import nbformat
import pytest

from course_lib.classroom.course import Course, homeworks_of_the_course

from .school import cell_of, filled_in, hand_in, name_of


@pytest.fixture(scope="module", params=homeworks_of_the_course().items(), ids=lambda homework: homework[0])
def graded(request, nbgrader, tmp_path_factory):  # noqa: ARG001 (it decides whether to skip)
    """(source, release, grades by learner, pages) of one homework, solved by "author" and untouched by "reader"."""
    name, path = request.param
    course = Course.new(tmp_path_factory.mktemp(name) / "class", {name: path})
    source = nbformat.read(path, as_version=4)
    release = nbformat.read(course.release(name), as_version=4)
    solutions = {
        name_of(cell): cell.source for cell in source.cells if cell.metadata.get("nbgrader", {}).get("solution")
    }
    hand_in(course, "author", name, filled_in(release, solutions))
    hand_in(course, "reader", name, release)
    grades = {grade.learner: grade for grade in course.autograde(name)}
    return source, release, grades, course.feedback(name)


def test_the_authors_solution_has_all_points(graded):
    grade = graded[2]["author"]
    assert grade.score == grade.max_score > 0
    assert grade.remarks == ()


def test_what_learners_get_has_none(graded):
    grade = graded[2]["reader"]
    assert set(grade.points.values()) == {0}
    assert grade.remarks == ()


def test_the_template_is_what_nbgrader_releases(graded):
    source, release, _, _ = graded
    (path,) = (path for path in homeworks_of_the_course().values() if nbformat.read(path, as_version=4) == source)
    template = nbformat.read(path.parents[1] / path.name, as_version=4)
    assert [(cell.cell_type, cell.source, cell.metadata) for cell in template.cells] == [
        (cell.cell_type, cell.source, cell.metadata) for cell in release.cells
    ]


def test_no_page_shows_a_hidden_test(graded):
    source, release, _, pages = graded
    hidden = [
        line
        for cell in source.cells
        if cell.metadata.get("nbgrader", {}).get("grade")
        for line in cell.source.splitlines()
        if line.strip() and line not in cell_of(release, name_of(cell)).source
    ]
    assert hidden
    for page in pages.values():
        shown = unescape(re.sub(r"<[^>]*>", "", page.read_text()))
        assert all(line in shown for line in cell_of(release, "task_1_check").source.splitlines()), "code can be found"
        assert not [line for line in hidden if line.strip() in shown]
