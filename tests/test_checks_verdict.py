"""How a verdict is shown: as a table, as text, as points, and never as something that the learner's code wrote."""

import re
from html.parser import HTMLParser

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib.checks.verdict import Hint, Outcome, Row, Verdict

PASSED = Row(Outcome.PASSED, "a `small` maze", "one walk")
NOT_YET = Row(Outcome.NOT_YET, "a maze", "one walk", "two `walks`", "your loop goes on.", "S . G\nS start")
NOT_STARTED = Row(Outcome.NOT_STARTED, "a maze", "one walk")
# What JupyterLab keeps of an output that it does not trust.
KEPT_TAGS = {"p", "b", "table", "thead", "tbody", "tr", "th", "td", "pre", "code", "br"}


class Reader(HTMLParser):
    """The tags, attributes and text of a page; complains of tags that are not closed."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.attributes, self.texts, self.open = set(), set(), [], []
        self.feed(html)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        self.attributes |= {name for name, _ in attrs}
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)

    @property
    def text(self):
        return "".join(self.texts)


@pytest.mark.parametrize(
    ("rows", "outcome", "points"),
    [
        ([PASSED, PASSED], Outcome.PASSED, 2.0),
        ([PASSED, NOT_YET], Outcome.NOT_YET, 1.0),
        ([NOT_YET, NOT_YET], Outcome.NOT_YET, 0.0),
        ([NOT_STARTED, NOT_STARTED], Outcome.NOT_STARTED, 0.0),
        ([NOT_STARTED, PASSED], Outcome.NOT_YET, 1.0),
        ([NOT_STARTED, NOT_YET], Outcome.NOT_YET, 0.0),
    ],
)
def test_the_outcome_and_the_points_of_rows(rows, outcome, points):
    verdict = Verdict("Task", tuple(rows))
    assert (verdict.outcome, verdict.points, verdict.max_points) == (outcome, points, 2.0)
    assert verdict.passed == (outcome is Outcome.PASSED)
    assert f"Task: {outcome}" in repr(verdict)
    assert f"Task: {outcome}" in Reader(verdict.html()).text
    assert f"{points:.0f} of 2 points" in repr(verdict)


def test_every_form_of_it_says_the_same():
    verdict = Verdict("Task", (PASSED, NOT_YET), "Stuck? Run `checks.walks.hint()`.", "step 1\nstep 2")
    for text in (repr(verdict), Reader(verdict.html()).text):
        for words in ("✓ passed", "✗ not yet", "a small maze", "Expected: one walk", "Got: two walks"):
            assert words.replace("✓ passed", "✓") in text
        assert "It looks as if your loop goes on." in text
        assert "S . G\n" in text
        assert "step 1\n" in text
        assert "Run checks.walks.hint()." in text
        assert "`" not in text
    assert "<code" in verdict.html()


def test_a_row_that_passed_or_was_not_started_says_nothing_more():
    for row in (PASSED, NOT_STARTED):
        assert "Expected" not in repr(Verdict("Task", (row,)))
        assert "Expected" not in Verdict("Task", (row,)).html()


def test_each_outcome_says_what_to_do_next():
    assert "passed" in repr(Verdict("Task", (PASSED,), "more"))
    assert "more" not in repr(Verdict("Task", (PASSED,), "more"))
    assert "hidden checks" in repr(Verdict("Task", (PASSED,)))
    assert "Write your code in the cell above" in repr(Verdict("Task", (NOT_STARTED,)))
    assert repr(Verdict("Task", (NOT_YET,), "more")).endswith("more")


def test_outcomes_are_told_by_words_and_marks_and_never_by_colour():
    html = Verdict("Task", (PASSED, NOT_YET, NOT_STARTED)).html()
    assert "color" not in html
    assert "background" not in html
    for words in ("✓ passed", "✗ not yet", "○ not started"):
        assert words in html


@pytest.mark.parametrize("place", ["tried", "expected", "came", "likely", "map", "printed", "title", "more"])
@pytest.mark.parametrize("words", ["<script>alert(1)</script>", "`<img src=x onerror=y>`", '"><b>&amp;', "</pre></td>"])
def test_nothing_that_was_written_elsewhere_is_html(place, words):
    row = {"tried": "t", "expected": "e", "came": "c", "likely": "l", "map": "m"}
    verdict = {"title": "t", "more": "m", "printed": "p"}
    (row if place in row else verdict)[place] = words
    title = verdict.pop("title")
    reader = Reader(Verdict(title, (Row(Outcome.NOT_YET, **row),), **verdict).html())
    assert reader.tags <= KEPT_TAGS
    assert reader.attributes <= {"style"}
    assert words.replace("`", "") in reader.text.replace("`", "")


@settings(derandomize=True, deadline=None)
@given(st.text(), st.text(), st.text())
def test_any_text_can_be_shown_and_written_to_a_file(came, likely, printed):
    verdict = Verdict("Task", (Row(Outcome.NOT_YET, "a maze", "one walk", came, likely),), "", printed)
    Reader(verdict.html())
    for text in (verdict.html(), repr(verdict)):
        text.encode("utf-8")
        assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f\x1b\u202e\ud800-\udfff]", text)


def test_colours_of_a_terminal_and_bars_that_redraw_themselves_become_lines():
    printed = "\x1b[31mred\x1b[0m\n 10%\r 20%\r\n\tend\x08"
    assert "    red\n     10%\n     20%\n" in repr(Verdict("Task", (NOT_YET,), "", printed))
    assert "\N{REPLACEMENT CHARACTER}" in repr(Verdict("Task", (NOT_YET,), "", printed))


@settings(derandomize=True, deadline=None)
@given(st.text(max_size=500), st.text(max_size=500), st.text(max_size=2000))
def test_no_line_of_the_text_is_longer_than_a_page_is_wide(came, likely, printed):
    row = Row(Outcome.NOT_YET, "a maze " * 20, "one walk " * 20, came, likely)
    assert max(map(len, repr(Verdict("A task " * 20, (row,), "more " * 40, printed)).split("\n"))) <= 90


def test_of_many_lines_that_were_printed_the_first_are_shown():
    verdict = Verdict("Task", (NOT_YET,), "", "a line\n" * 1000)
    for text in (repr(verdict), verdict.html()):
        assert text.count("a line") == 20
        assert "… and 980 more" in text


def test_a_line_without_spaces_is_broken():
    text = repr(Verdict("Task", (Row(Outcome.NOT_YET, "a maze", "one walk", "x" * 300),), "", "y" * 300))
    assert max(map(len, text.split("\n"))) <= 90


def test_backticks_that_do_not_pair_stay_as_they_are():
    assert "one ` only" in Verdict("Task", (Row(Outcome.NOT_YET, "t", "e", "one ` only"),)).html()


def test_a_notebook_shows_the_table_and_a_terminal_the_text(monkeypatch):
    monkeypatch.delenv("NBGRADER_EXECUTION", raising=False)
    verdict = Verdict("Task", (PASSED, NOT_YET))
    assert verdict._repr_mimebundle_() == {"text/html": verdict.html(), "text/plain": repr(verdict)}


@pytest.mark.parametrize("rows", [(PASSED, NOT_YET, PASSED), (NOT_YET,), (NOT_STARTED,)])
def test_nbgrader_reads_the_points(rows, monkeypatch):
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")
    verdict = Verdict("Task", rows)
    bundle = verdict._repr_mimebundle_(include=None, exclude=None)
    assert float(bundle["text/plain"]) == verdict.points
    assert bundle["text/html"] == verdict.html()
    utils = pytest.importorskip("nbgrader.utils", reason="nbgrader is not installed")
    from nbformat.v4 import new_code_cell, new_output

    cell = new_code_cell(outputs=[new_output("execute_result", bundle, execution_count=1)])
    cell.metadata.nbgrader = {"grade": True, "solution": False, "points": 3}
    assert utils.determine_grade(cell) == (verdict.points, 3)


def test_a_hint_in_both_forms(monkeypatch):
    monkeypatch.delenv("NBGRADER_EXECUTION", raising=False)
    hint = Hint(2, 3, "Keep a `set` of <cells>. " * 10)
    assert repr(hint).startswith("Hint 2 of 3: Keep a set of <cells>.")
    assert max(map(len, repr(hint).split("\n"))) <= 90
    bundle = hint._repr_mimebundle_()
    assert bundle["text/plain"] == repr(hint)
    reader = Reader(bundle["text/html"])
    assert reader.tags <= KEPT_TAGS
    assert "Keep a set of <cells>." in reader.text
