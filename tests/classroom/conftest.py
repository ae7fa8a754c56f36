"""A class for the tests that need nbgrader."""

import shutil
from importlib.util import find_spec

import nbformat
import pytest
from needed import do_without

from course_lib.classroom.course import Course

from .school import HOMEWORK, new_class


@pytest.fixture(scope="session")
def nbgrader():
    """Skip where a learner has no nbgrader; where it is promised (CI), its absence is a failure."""
    if not find_spec("nbgrader"):
        do_without('needs nbgrader: pip install -e ".[teach]"', "COURSE_REQUIRE_NBGRADER")


@pytest.fixture(scope="session")
def released_class(nbgrader, tmp_path_factory):  # noqa: ARG001 (it decides whether to skip)
    """The folder of a class with the small homework released, to be copied: a gradebook takes a second to make."""
    course = new_class(tmp_path_factory.mktemp("released"))
    course.release(HOMEWORK)
    return course.folder


@pytest.fixture
def course(released_class, tmp_path):
    """A class of its own with the small homework released."""
    shutil.copytree(released_class, tmp_path / "class")
    return Course(tmp_path / "class")


@pytest.fixture
def release(released_class):
    return nbformat.read(next(released_class.glob("release/*/*.ipynb")), as_version=4)
