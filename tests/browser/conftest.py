"""One JupyterLab and one browser for all tests of this folder."""

from importlib.util import find_spec

import pytest
from needed import do_without

from .lab import BROWSERS, find_browser, jupyter_lab, open_browser, open_lab

PROMISE = "COURSE_REQUIRE_BROWSER"


@pytest.fixture(scope="package")
def browser():
    if not find_spec("playwright"):
        do_without('needs playwright: pip install -e ".[browser]"', PROMISE)
    program = find_browser()
    if not program:
        do_without(f"needs one of {', '.join(BROWSERS)}", PROMISE)
    with open_browser(program) as browser:
        yield browser


@pytest.fixture(scope="package")
def lab(browser):
    with jupyter_lab() as server, open_lab(browser, server) as lab:
        yield lab
