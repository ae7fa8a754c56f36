"""What a check has to say: a small table that reads well as HTML and as plain text, and a score."""

import os
import re
import textwrap
from dataclasses import dataclass
from enum import StrEnum
from html import escape


class Outcome(StrEnum):
    NOT_STARTED = "not started"
    NOT_YET = "not yet"
    PASSED = "passed"


_MARKS = {Outcome.NOT_STARTED: "○", Outcome.NOT_YET: "✗", Outcome.PASSED: "✓"}
_WIDTH, _MOST_LINES = 88, 20  # lines of what the learner's code printed
_TERMINAL_COLOURS = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")
# No colours of our own: the page's are readable in its light and in its dark theme.
_CELL = "text-align:left;vertical-align:top;overflow-wrap:break-word"
_WRAPS = "white-space:pre-wrap;overflow-wrap:anywhere"


@dataclass(frozen=True)
class Row:
    """One thing that was tried: what was expected, what came, and which misunderstanding it looks like."""

    outcome: Outcome
    tried: str
    expected: str
    came: str = ""
    likely: str = ""
    map: str = ""  # a picture of where it happened

    @property
    def findings(self):
        """(name, words) of what there is to say about a row that did not pass."""
        if self.outcome is not Outcome.NOT_YET:
            return []
        named = [("Expected", self.expected), ("Got", self.came), ("It looks as if", self.likely)]
        return [(name, _printable(words)) for name, words in named if words]


@dataclass(frozen=True)
class Verdict:
    """The rows of one check. As the last value of a cell it shows itself; `points` count the rows that passed."""

    title: str
    rows: tuple[Row, ...]
    more: str = ""  # how to get a hint
    printed: str = ""  # what the learner's code printed meanwhile

    @property
    def outcome(self):
        outcomes = {row.outcome for row in self.rows}
        return outcomes.pop() if len(outcomes) == 1 else Outcome.NOT_YET

    @property
    def passed(self):
        return self.outcome is Outcome.PASSED

    @property
    def points(self):
        return float(sum(row.outcome is Outcome.PASSED for row in self.rows))

    @property
    def max_points(self):
        return float(len(self.rows))

    @property
    def _closing(self):
        if self.passed:
            return "Public checks passed: go on below. (If your homework is graded, hidden checks may follow.)"
        if self.outcome is Outcome.NOT_STARTED:
            return (
                "Write your code in the cell above, run that cell, then run this one again. If it is written already: "
                "`raise NotImplementedError` still stands before it, and has to go."
            )
        return self.more

    @property
    def _heading(self):
        return f"{self.title}: {self.outcome}", f"{self.points:.0f} of {self.max_points:.0f} points"

    def __repr__(self):
        return "\n".join(self._lines())

    def _lines(self):
        outcome, points = self._heading
        yield from _wrapped(f"{outcome} ({points})", "", "  ")
        for row in self.rows:
            yield from _wrapped(f"{row.outcome}: {row.tried}", f"  {_MARKS[row.outcome]} ", "      ")
            for name, words in row.findings:
                yield from _wrapped(f"{name}{'' if name.endswith('if') else ':'} {words}", "      ", "        ")
            if row.map:
                yield textwrap.indent(row.map, "        ")
        if self.printed:
            yield "  Your code printed:"
            for line in _beginning(self.printed):
                yield from textwrap.wrap(line, _WIDTH - 4, initial_indent="    ", subsequent_indent="    ") or [""]
        yield from _wrapped(self._closing, "  ", "  ")

    def _repr_mimebundle_(self, include=None, exclude=None):  # noqa: ARG002 (IPython's signature)
        if os.environ.get("NBGRADER_EXECUTION"):  # it reads the points from the plain text
            return {"text/html": self.html(), "text/plain": repr(self.points)}
        return {"text/html": self.html(), "text/plain": repr(self)}

    def html(self):
        """The verdict as an HTML table. All words that came from the learner's code are escaped."""
        outcome, points = self._heading
        head = f'<tr><th style="{_CELL}">outcome</th><th style="{_CELL}">what was tried</th></tr>'
        rows = "".join(_html_row(row) for row in self.rows)
        printed = escape("\n".join(_beginning(self.printed)))
        printed = f'<p>Your code printed:</p><pre style="{_WRAPS}">{printed}</pre>' if printed else ""
        table = f'<table style="margin-left:0"><thead>{head}</thead><tbody>{rows}</tbody></table>'
        return f"<p><b>{_html(outcome)}</b> ({points})</p>{table}{printed}<p>{_html(self._closing)}</p>"


def _html_row(row):
    tried = _html(row.tried)
    if row.findings:
        lines = [f"<b>{tried}</b>"]
        lines += [f"{name}{'' if name.endswith('if') else ':'} {_html(words)}" for name, words in row.findings]
        tried = "<br>".join(lines) + (f'<pre style="text-align:left">{escape(row.map)}</pre>' if row.map else "")
    outcome = f'<td style="{_CELL};white-space:nowrap;width:6em">{_MARKS[row.outcome]} {row.outcome}</td>'
    return f'<tr>{outcome}<td style="{_CELL}">{tried}</td></tr>'


def _html(words):
    """Escaped words, with `code` between backticks set as code."""
    parts = escape(words).split("`")
    if len(parts) % 2 == 0:
        return escape(words)
    return "".join(f'<code style="{_WRAPS}">{part}</code>' if i % 2 else part for i, part in enumerate(parts))


def _wrapped(words, first, then):
    return textwrap.wrap(words.replace("`", ""), _WIDTH, initial_indent=first, subsequent_indent=then)


def _printable(text):
    """Text that can be shown and stored anywhere: a learner's code may print what moves a cursor or a whole line."""
    text = _TERMINAL_COLOURS.sub("", text).replace("\r\n", "\n").replace("\r", "\n").expandtabs()
    return "".join(c if c == "\n" or c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def _beginning(printed):
    lines = _printable(printed).rstrip().split("\n")
    more = len(lines) - _MOST_LINES
    return lines if more <= 0 else [*lines[:_MOST_LINES], f"… and {more} more of what was kept"]


@dataclass(frozen=True)
class Hint:
    """One hint of several."""

    number: int
    of: int
    words: str

    def __repr__(self):
        return "\n".join(_wrapped(f"Hint {self.number} of {self.of}: {self.words}", "", ""))

    def _repr_mimebundle_(self, include=None, exclude=None):  # noqa: ARG002 (IPython's signature)
        html = f"<p><b>Hint {self.number} of {self.of}.</b> {_html(self.words)}</p>"
        return {"text/html": html, "text/plain": repr(self)}
