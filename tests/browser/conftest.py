"""One JupyterLab and one browser for all tests of this folder."""

import os
from importlib.util import find_spec

import pytest

from .lab import BROWSERS, find_browser, jupyter_lab, open_browser, open_lab


def do_without(reason):
    """Skip where a learner has no browser for tests; where one is promised (CI), its absence is a failure."""
    if os.environ.get("COURSE_REQUIRE_BROWSER") == "1":
        pytest.fail(reason, pytrace=False)
    pytest.skip(reason)


@pytest.fixture(scope="package")
def browser():
    if not find_spec("playwright"):
        do_without('needs playwright: pip install -e ".[browser]"')
    program = find_browser()
    if not program:
        do_without(f"needs one of {', '.join(BROWSERS)}")
    with open_browser(program) as browser:
        yield browser


@pytest.fixture(scope="package")
def lab(browser):
    with jupyter_lab() as server, open_lab(browser, server) as lab:
        yield lab
