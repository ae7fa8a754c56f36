"""Lines, bands and bars over two axes, as SVG."""

import math

import numpy as np

from course_lib.explore.drawing.sketch import WIDTH, Sketch
from course_lib.explore.numerals import numeral, power_of_ten
from course_lib.plots.picture import FAINT, INK, PALETTE, PAPER

DASHES = (None, "8 4", "2 3", "9 3 2 3", "14 4", "1 4")  # one for each colour of PALETTE
_LEFT, _RIGHT, _HEAD, _FOOT = 46, 8, 30, 40
_LINE = 18  # a line of the legend
_SHAPES = ("circle", "square", "up", "down", "ring")


class Chart:
    """Axes under construction. x and y are (lowest, highest); a `log` axis upwards wants positive numbers.

    legend: how many lines of it there is room for, below. names: {x: words} to stand below the axis for its numbers.
    """

    def __init__(self, title, *, x, y, xlabel, ylabel, height=200, log=False, legend=0, width=WIDTH, names=None):
        self.x, self.y, self.log, self._legend = x, y, log, 0
        self.bottom = _HEAD + 16 + height
        self.sketch = Sketch(self.bottom + _FOOT + legend * _LINE + 4, width)
        self.right, self.top = width - _RIGHT, _HEAD + 16
        self.sketch.text(6, 14, title, size=15, anchor="start", font_weight="600")
        self.sketch.text(6, 35, ylabel, size=12, anchor="start")
        self.sketch.text((_LEFT + self.right) / 2, self.bottom + 31, xlabel, size=12)
        for tick in log_ticks(*y) if log else ticks(*y):
            height_of = float(self.up(tick))
            self.sketch.line([(_LEFT, height_of), (self.right, height_of)], stroke=FAINT, stroke_opacity=0.35)
            self.sketch.text(_LEFT - 5, height_of, _label(tick), size=11.5, anchor="end")
        for tick, name in (names or {tick: _label(tick) for tick in ticks(*x)}).items():
            self.sketch.text(float(self.across(tick)), self.bottom + 12, name, size=11.5)
        self.sketch.line([(_LEFT, self.top), (_LEFT, self.bottom), (self.right, self.bottom)], stroke=INK)

    def svg(self):
        """The picture as text."""
        return self.sketch.svg()

    def across(self, x):
        """Where numbers on the x axis stand in the picture."""
        low, high = self.x
        return _LEFT + (np.asarray(x, float) - low) / ((high - low) or 1) * (self.right - _LEFT)

    def up(self, y):
        """Where numbers on the y axis stand in the picture; those outside stand at its edge."""
        low, high = self.y
        y = np.clip(np.asarray(y, float), low, high)
        share = np.log(y / low) / math.log(high / low) if self.log else (y - low) / ((high - low) or 1)
        return self.bottom - share * (self.bottom - self.top)

    def line(self, x, y, which=0, **look):
        """A line in the colour and dashes number `which`."""
        points = zip(self.across(x).tolist(), self.up(y).tolist(), strict=True)
        look = {"stroke": PALETTE[which], "stroke_width": 2, "stroke_dasharray": DASHES[which]} | look
        self.sketch.line(points, **look)

    def band(self, x, low, high, which=0):
        """The space between two lines."""
        across = self.across(x).tolist()
        there = zip(across, self.up(low).tolist(), strict=True)
        back = zip(reversed(across), reversed(self.up(high).tolist()), strict=True)
        self.sketch.line([*there, *back], closed=True, fill=PALETTE[which], fill_opacity=0.2)

    def points(self, x, y, which=0, *, size=4, shape="circle"):
        """Marks: a "circle", a "square", a triangle "up" or "down", or a "ring", whose colour is the paper's."""
        for px, py in zip(np.atleast_1d(self.across(x)), np.atleast_1d(self.up(y)), strict=True):
            self._mark(float(px), float(py), which, size, shape)

    def bar(self, x, y, which=0, *, width=24, shift=0.0, hollow=False):
        """A bar from the axis up to y, `shift` pixels beside x; hollow: an outline filled with dots."""
        middle, height = float(self.across(x)) + shift, float(self.up(y))
        look = {"fill": "url(#dotted)" if hollow else PALETTE[which], "stroke": INK, "stroke_width": 1.2}
        self.sketch.rect(middle - width / 2, height, width, self.bottom - height, **look)

    def note(self, x, y, words, *, shift=0.0):
        """A few words above a point, `shift` pixels beside it."""
        self.sketch.text(float(self.across(x)) + shift, float(self.up(y)) - 12, words, size=11.5)

    def rule(self, y, words, *, above=True):
        """A dotted line across, with its name on the right."""
        height = float(self.up(y))
        self.sketch.line([(_LEFT, height), (self.right, height)], stroke=INK, stroke_dasharray="1 3")
        halo = {"stroke": PAPER, "stroke_width": 4, "paint_order": "stroke"}  # other lines may cross the name
        self.sketch.text(self.right - 2, height + (-8 if above else 9), words, size=11.5, anchor="end", **halo)

    def legend(self, words, which, *, kind="line"):
        """One more line of the legend; kind: how it is drawn, "line", "band", "circle", "square", "bar", "hollow" or
        another shape of `points`.
        """
        y = self.bottom + _FOOT + 10 + self._legend * _LINE
        self._legend += 1
        if kind in _SHAPES:
            self._mark(24, y, which, 4, kind)
        elif kind in ("bar", "hollow"):
            fill = "url(#dotted)" if kind == "hollow" else PALETTE[which]
            self.sketch.rect(12, y - 6, 24, 12, fill=fill, stroke=INK, stroke_width=1.2)
        else:
            if kind == "band":
                self.sketch.rect(8, y - 6, 32, 12, fill=PALETTE[which], fill_opacity=0.2)
            look = {"stroke": PALETTE[which], "stroke_width": 2.5, "stroke_dasharray": DASHES[which]}
            self.sketch.line([(8, y), (40, y)], **look)
        self.sketch.text(48, y, words, size=12, anchor="start")

    def room(self, lines):
        """Take so many lines of the legend's room for a drawing of one's own; gives its upper edge."""
        self._legend += lines
        return self.bottom + _FOOT + 1 + (self._legend - lines) * _LINE

    def _mark(self, x, y, which, size, shape):
        look = {"fill": PALETTE[which], "stroke": "#ffffff", "stroke_width": 0.8}
        if shape == "circle":
            self.sketch.circle(x, y, size, **look)
        elif shape == "ring":
            self.sketch.circle(x, y, size - 0.5, fill=PAPER, stroke=INK, stroke_width=1.5)
        elif shape == "square":
            self.sketch.rect(x - size, y - size, 2 * size, 2 * size, **look)
        else:
            tip = -size if shape == "up" else size
            self.sketch.line([(x - size, y - tip), (x + size, y - tip), (x, y + tip)], closed=True, **look)


def ticks(low, high, most=6):
    """Round numbers from `low` to `high`, at most `most` or one more."""
    if high <= low:
        return [low]
    rough = (high - low) / most
    step = 10 ** math.floor(math.log10(rough))
    step *= next(factor for factor in (1, 2, 5, 10) if factor * step >= rough * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [round(i * step, 10) for i in range(first, math.floor(high / step + 1e-9) + 1)]


def log_ticks(low, high):
    """1, 2, 5, 10, 20, … from `low` to `high`, or only the powers of ten where the others would be too many.

    Where they are fewer than 3, round numbers at equal distances.
    """
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = (1, 2, 5) if len(powers) <= 4 else (1,)
    found = [s * 10.0**p for p in powers for s in steps if low * 0.999 <= s * 10.0**p <= high * 1.001]
    return found if len(found) >= 3 else ticks(low, high, most=8)


def _label(tick):
    power = round(math.log10(abs(tick))) if tick else 0
    if not -4 <= power <= 4 and math.isclose(tick, 10.0**power):
        return power_of_ten(power)
    return numeral(tick, ",.0f" if abs(tick) >= 1000 else "g")
