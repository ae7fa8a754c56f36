"""What tests need and a learner may not have."""

import os

import pytest


def do_without(reason, promise):
    """Skip the test for this reason; where `promise`, COURSE_REQUIRE_… of the environment, is 1 (CI), it fails."""
    if os.environ.get(promise) == "1":
        pytest.fail(reason, pytrace=False)
    pytest.skip(reason)
