"""A class on a hub, from the first release to the feedback, for all tests of this folder."""

import os

import pytest
from needed import do_without

from . import hub, machine
from .school import School, in_class


@pytest.fixture(scope="package")
def ready():
    """Skip where no hub, or no machine of the tests' own, can be had."""
    reason = hub.why_not() or machine.why_not()
    if reason:
        do_without(reason, "COURSE_REQUIRE_HUB")


@pytest.fixture(scope="package")
def school(ready) -> School:  # noqa: ARG001 (it decides whether to skip)
    """The class after its homework has been given back; COURSE_CLASS_SIZE learners are in it."""
    with in_class(int(os.environ.get("COURSE_CLASS_SIZE", "40"))) as school:
        yield school
