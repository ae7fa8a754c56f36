"""Feedback pages are opened by teachers too: nothing that a learner wrote runs in them."""

from importlib.util import find_spec

import pytest
from browser.lab import find_browser, open_browser
from nbformat.v4 import new_markdown_cell

from .school import HOMEWORK, hand_in

ATTACKS = "<script>alert(1)</script> <img src=x onerror=alert(2)> <iframe src='javascript:parent.alert(3)'></iframe>"


@pytest.fixture
def page(course, release):
    release.cells.insert(0, new_markdown_cell(f"{ATTACKS}\n\nand [this](javascript:alert(4))"))
    hand_in(course, "eve", HOMEWORK, release)
    course.autograde(HOMEWORK)
    return course.feedback(HOMEWORK)["eve"]


def test_the_policy_stands_before_all_else(page):
    text = page.read_text()
    assert text.index("Content-Security-Policy") < text.index("<title>") < text.index("alert(1)")


def test_no_script_of_a_learners_runs(page):
    if not find_spec("playwright") or not find_browser():
        pytest.skip("needs playwright and a browser")
    heard = []
    with open_browser(find_browser()) as browser:
        tab = browser.new_page()
        tab.on("dialog", lambda dialog: (heard.append(dialog.message), dialog.dismiss()))
        tab.set_default_timeout(10_000)
        tab.goto(page.as_uri())
        tab.get_by_role("link", name="this", exact=True).click()
        tab.wait_for_timeout(300)
        assert tab.get_by_text("Task 1").count() > 0
    assert heard == []
