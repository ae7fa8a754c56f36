"""A maze drawn from above as SVG, each cell of it known to the browser by its number."""

import numpy as np

from course_lib.explore.drawing.sketch import WIDTH, Sketch, shade
from course_lib.explore.numerals import short, two_places
from course_lib.maze import MOVES, Action, Tile
from course_lib.plots.board import acting_states, best_actions
from course_lib.plots.picture import BLUE, INK, ORANGE, PAPER, RED, YELLOW

_MARGIN, _HEAD, _FOOT = 28, 30, 8  # left of the cells for row numbers, above for the title and columns, below
_NARROW = 50  # pixels: in a narrower cell there is none to spare between a number and what stands below it
_KEY_STEPS = 8
_MOST_NUMBERS = 12  # columns up to which a cell has room for numbers
SIGNS = {Action.UP: "↑", Action.DOWN: "↓", Action.LEFT: "←", Action.RIGHT: "→"}
ARROWS = {action: f"{sign} {action.name.lower()}" for action, sign in SIGNS.items()}
OPEN, UNKNOWN = "#ececea", "#d5d5d1"


class Board:
    """A maze under construction. Cells are told by their state's number; `q` is float[S, A]."""

    def __init__(self, world, title):
        self.world, self.cell = world, (WIDTH - _MARGIN - 8) / max(world.columns, world.rows)
        self.left = _MARGIN + (WIDTH - _MARGIN - 8 - self.cell * world.columns) / 2
        self.top = _HEAD + 18
        self.sketch = Sketch(round(self.top + self.cell * world.rows + _FOOT))
        self.roomy = max(world.columns, world.rows) <= _MOST_NUMBERS
        self.sketch.text(self.left, 14, title, size=15, anchor="start", font_weight="600")
        self._number_rows_and_columns()

    def svg(self):
        """The picture as text."""
        return self.sketch.svg()

    def middle(self, state):
        """Where the middle of a cell lies, (x, y)."""
        row, column = divmod(int(state), self.world.columns)
        return self.left + (column + 0.5) * self.cell, self.top + (row + 0.5) * self.cell

    def fill(self, state, colour):
        """A cell in one colour, with a thin gap to the next."""
        row, column = divmod(int(state), self.world.columns)
        gap = 1 if self.roomy else 0.2
        x, y, side = self.left + column * self.cell + gap, self.top + row * self.cell + gap, self.cell - 2 * gap
        self.sketch.rect(x, y, side, side, fill=colour, data_cell=int(state))

    def tiles(self, shown=None, colours=()):
        """Floor and walls, with every cell's number; `shown`, bool[S]: the cells that are known, by default all.

        colours: {state: a colour} for floor that is to have another.
        """
        for s, tile in enumerate(self.world.grid.flat):
            known = shown is None or shown[s]
            floor = dict(colours).get(s, OPEN)
            self.fill(s, (UNKNOWN if not known else "url(#slanted)" if tile == Tile.WALL else floor))
            self.number(s, "#ffffff" if known and tile == Tile.WALL else INK)

    def walls(self):
        """Only the walls."""
        for s in np.flatnonzero(self.world.grid == Tile.WALL):
            self.fill(s, "url(#slanted)")
            self.number(s, "#ffffff")

    def number(self, state, colour=INK):
        """The state's number, small, in the corner of its cell."""
        if self.roomy:
            x, y = self.middle(state)
            corner = self.cell / 2 - 4
            down = 6 if self.cell >= _NARROW else 3
            self.sketch.text(x - corner, y - corner + down, state, size=11, anchor="start", colour=colour)

    def values(self, values, low, high):
        """A number and its colour in every cell that the mouse can act in."""
        for s in acting_states(self.world):
            colour, ink = shade(values[s], low, high)
            self.fill(s, colour)
            if self.roomy:
                self.number(s, ink)
                x, y = self.middle(s)
                size = min(14.0, max(11.0, self.cell / 4.5))
                up = 0.1 if self.cell >= _NARROW else 0.06
                self.sketch.text(x, y - up * self.cell, short(values[s]), size=size, colour=ink)

    def wedges(self, q, low, high):
        """Four wedges a cell, one for each action, with its value; the best of a cell are bold and framed."""
        half = self.cell / 2 - 1
        for s in acting_states(self.world):
            x, y = self.middle(s)
            best = best_actions(q[s])
            best = best if len(best) < len(Action) else []
            for a in Action:
                down, right = (int(step) for step in MOVES[a])
                colour, ink = shade(q[s, a], low, high)
                corners = self._wedge(s, a)
                self.sketch.line(corners, closed=True, fill=colour, stroke=PAPER, data_cell=int(s))
                if a in best:
                    inner = [(0.1 * x + 0.9 * cx + right, 0.1 * y + 0.9 * cy + down) for cx, cy in corners]
                    self.sketch.line(inner, closed=True, fill="none", stroke=RED, stroke_width=2.2)
                if self.cell / 7 >= 9:  # smaller numbers are not to be read
                    look = {"font_weight": "700"} if a in best else {}
                    text, size = two_places(q[s, a]), min(11.0, self.cell / 7)
                    out = 0.6 if len(text) < 5 else 0.57  # a sign needs room as well
                    self.sketch.text(x + right * half * out, y + down * half * 0.7, text, size=size, colour=ink, **look)

    def frame_wedge(self, state, action, colour=BLUE):
        """A thick dashed frame around one wedge: the changed one."""
        corners, look = self._wedge(state, action), {"closed": True, "fill": "none", "stroke_linejoin": "round"}
        self.sketch.line(corners, stroke="#ffffff", stroke_width=5, **look)
        self.sketch.line(corners, stroke=colour, stroke_width=3, stroke_dasharray="6 3", **look)

    def tag(self, state):
        """The state's number on a slip of paper, to be read on any colour."""
        if self.roomy:
            x, y = self.middle(state)
            x, y = x - self.cell / 2 + 2, y - self.cell / 2 + 2
            self.sketch.rect(x, y, 5 + 6.5 * len(str(state)), 13, fill=PAPER, rx=2, data_cell=int(state))
            self.sketch.text(x + 2.5, y + 6.5, state, size=11, anchor="start")

    def arrows(self, q, marked=()):
        """An arrow for every best action of a cell; none where all are alike, since nothing is known there.

        marked: pairs (state, action) whose arrows are filled, the others being white.
        """
        for s in acting_states(self.world):
            best = best_actions(q[s])
            for a in best if len(best) < len(Action) else []:
                place = {"lift": 0.24, "start": 0.03, "length": 0.2} if self.roomy else {}  # below the cell's value
                if self.roomy and self.cell < _NARROW:
                    place = {"lift": 0.27, "start": 0.03, "length": 0.16}
                self.arrow(s, a, colour=RED if (s, a) in marked else "#ffffff", **place)

    def arrow(self, state, action, *, lift=0.0, aside=0.0, start=0.06, length=0.28, colour="#ffffff"):
        """An arrow from the middle of a cell the way the action moves; lift: lower down, aside: right, in cells."""
        x, y = self.middle(state)
        down, right = (int(step) for step in MOVES[action])
        x, y = x + (aside + right * start) * self.cell, y + (lift + down * start) * self.cell
        shaft, head, tip = 0.025 * self.cell, 0.075 * self.cell, length * self.cell
        outline = [(0, shaft), (tip * 0.6, shaft), (tip * 0.6, head), (tip, 0)]
        outline += [(along, -across) for along, across in reversed(outline[:3])]
        corners = [(x + right * along - down * across, y + down * along + right * across) for along, across in outline]
        self.sketch.line(corners, closed=True, fill=colour, stroke=INK, stroke_width=0.9)

    def frame(self, state, colour=BLUE, *, inset=3):
        """A thick frame around a cell: the chosen one; inset: how many pixels inside it."""
        row, column = divmod(int(state), self.world.columns)
        x, y = self.left + column * self.cell + inset, self.top + row * self.cell + inset
        look, side = {"fill": "none", "rx": 3}, self.cell - 2 * inset
        self.sketch.rect(x, y, side, side, stroke="#ffffff", stroke_width=6, **look)
        self.sketch.rect(x, y, side, side, stroke=colour, stroke_width=3.5, **look)

    def mouse(self, state, size=0.22):
        """The mouse in its cell; size: in cells."""
        x, y = self.middle(state)
        r = size * self.cell
        for ear in (-0.8, 0.8):
            self.sketch.circle(x + ear * r, y - 0.8 * r, 0.55 * r, fill="#b9a7a0", stroke=INK)
        self.sketch.add("ellipse", cx=x, cy=y, rx=1.05 * r, ry=0.95 * r, fill="#8d7b74", stroke=INK)
        for eye in (-0.4, 0.4):
            self.sketch.circle(x + eye * r, y - 0.15 * r, 0.14 * r, fill=INK)
        self.sketch.circle(x, y + 0.45 * r, 0.18 * r, fill="#f2b8c6", stroke=INK, stroke_width=0.5)

    def cheese(self, goals=None):
        """A piece of cheese in each of `goals`, by default in all there are."""
        for goal in self.world.goals if goals is None else goals:
            x, y = self.middle(goal)
            r = self.cell
            corners = [(x - 0.3 * r, y + 0.2 * r), (x + 0.3 * r, y + 0.2 * r), (x + 0.3 * r, y - 0.2 * r)]
            self.sketch.line(corners, closed=True, fill=YELLOW, stroke=ORANGE, stroke_width=1.5, data_cell=int(goal))
            for dx, dy, size in ((0.16, 0.07, 0.05), (0.0, 0.13, 0.035), (0.23, -0.05, 0.03)):
                self.sketch.circle(x + dx * r, y + dy * r, size * r, fill=ORANGE)

    def key(self, low, high):
        """Below the maze: the colours from `low` to `high`, as `shade` has them. What is beyond looks like the end."""
        top, wide = self.sketch.height, 14
        self.sketch.height += 24
        self.sketch.text(self.left, top + 9, f"{short(low)} or less", size=12, anchor="start")
        for i in range(_KEY_STEPS):
            colour, _ = shade(i, 0, _KEY_STEPS - 1)
            self.sketch.rect(WIDTH / 2 + (i - _KEY_STEPS / 2) * wide, top + 2, wide, 14, fill=colour)
        right = self.left + self.cell * self.world.columns
        self.sketch.text(right, top + 9, f"{short(high)} or more", size=12, anchor="end")

    def note(self, state, words, *, colour=INK, down=0.36, size=11):
        """A few words in a cell, by default at its foot; down: how far below its middle, in cells."""
        x, y = self.middle(state)
        self.sketch.text(x, y + down * self.cell, words, size=size, colour=colour)

    def _wedge(self, state, action):
        """The corners of an action's wedge, the cell's middle first."""
        x, y = self.middle(state)
        half = self.cell / 2 - 1
        down, right = (int(step) for step in MOVES[action])
        return [
            (x, y),
            (x + (right - down) * half, y + (down - right) * half),
            (x + (right + down) * half, y + (down + right) * half),
        ]

    def corner_note(self, state, words, *, top=False):
        """A few words on a strip of paper in a corner of a cell, the lower right one or the upper right one."""
        x, y = self.middle(state)
        width, y = 5.8 * len(words) + 4, y + (-1 if top else 1) * (self.cell / 2 - (9 if self.cell >= _NARROW else 7))
        x += self.cell / 2 - 2 - width / 2
        self.sketch.rect(x - width / 2, y - 7, width, 14, fill=PAPER, rx=2, data_cell=int(state))
        self.sketch.text(x, y, words, size=11)

    def _number_rows_and_columns(self):
        every = max(1, self.world.columns // 10, self.world.rows // 10)
        for column in range(0, self.world.columns, every):
            self.sketch.text(self.left + (column + 0.5) * self.cell, self.top - 10, column, size=11)
        for row in range(0, self.world.rows, every):
            self.sketch.text(self.left - 12, self.top + (row + 0.5) * self.cell, row, size=11)


def place(world, state):
    """A cell in words."""
    row, column = divmod(int(state), world.columns)
    return f"cell {int(state)} (row {row}, column {column})"
