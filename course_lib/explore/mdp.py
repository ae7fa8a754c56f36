"""Lesson 1, touch the transition function: a row of T on the maze, and how often it comes out that way."""

from html import escape

import numpy as np

from course_lib.explore.controls import Button, Dials, Panel, View
from course_lib.explore.drawing.board import ARROWS, Board, acting_states, place
from course_lib.explore.drawing.chart import Chart
from course_lib.explore.explorer import Explorer
from course_lib.explore.numerals import numeral
from course_lib.explore.worlds import own_maze, with_rules
from course_lib.maze import Action, Tile
from course_lib.plots.picture import BLUE, RED
from course_lib.validate import whole_number

_TRIES = {"1 move": 1, "100 moves": 100, "10,000 moves": 10_000}
_ROOMY = 70  # pixels of a cell with room for a number and a chance side by side
_BESIDE = 18  # pixels that a bar stands left or right of its cell's place


class Transitions:
    """One row of T, for a cell and an action that can be chosen, and moves drawn from it.

    maze      a `Maze` of at most 8 rows and columns, by default lesson 1's on ice; seed: of the drawn moves
    cell      the chosen state; chances, float[S]: T(s, a, ·); counts, int64[S]: where the drawn moves landed
    """

    title = "Touch the transition function"

    def __init__(self, maze=None, *, seed=0):
        self._maze = maze = own_maze(maze, slip=0.2, wall_reward=0.0, wall_ends_episode=False)
        self._random = np.random.default_rng(whole_number("seed", seed))
        self._slippery = with_rules(maze, slip=0.5)  # where a move may lead at all, whatever the slip
        stops = {
            "slip": ("slip", sorted({round(0.05 * i, 2) for i in range(21)} | {maze.slip}), "{:.3g}".format),
            "action": ("action a", list(Action), ARROWS.get),
        }
        self.dials = Dials(stops, slip=maze.slip, action=Action.RIGHT)
        self.cell = maze.start
        self._look()

    def turn(self, name, at):
        """Another "slip" or "action"; what was drawn from the old row is forgotten."""
        self.dials.turn(name, at)
        self._look()

    def press(self, name):
        """Draw "1 move", "100 moves" or "10,000 moves" from the row, or "forget" them."""
        if name == "forget":
            self._look()
        elif name in _TRIES:
            self._draw(_TRIES[name])
        else:
            raise ValueError(f"the buttons are {', '.join(_TRIES)} and forget, got {name!r}")

    def choose(self, cell):
        """Another cell s. In a wall and in a goal there is nothing to do, so the cell stays what it was."""
        cell = whole_number("cell", cell, below=self.world.grid.size)
        if cell == self.cell:
            return  # whoever clicks it again keeps the moves
        if cell in acting_states(self.world):
            self.cell = cell
            self._look()
        elif self.world.grid.flat[cell] == Tile.WALL:
            self.message = f"Cell {cell} is a wall: the mouse never gets into it, so nothing can be done there."
        else:
            self.message = f"Cell {cell} holds a cheese: the episode ends there, so nothing more can be done."

    def arrow(self, action):
        """The next cell that way in which the mouse can act."""
        there = ahead = self.cell
        while (ahead := self.world.cell_ahead(ahead, action)) != there:
            there = ahead
            if there in acting_states(self.world):
                self.choose(there)
                return
        self.message = f"There is no cell to choose {action.name.lower()} from cell {self.cell}."

    def view(self):
        """The row on the maze, as bars, and as a table."""
        controls = [self.dials.slider("slip"), self.dials.choice("action")]
        controls += [Button(name, name) for name in _TRIES] + [Button("forget", "forget", idle=not self.tries)]
        panels = (self._map(), self._bars(), self._table())
        return View(controls=tuple(controls), panels=panels, message=self.message)

    @property
    def tries(self):
        """How many moves have been drawn."""
        return int(self.counts.sum())

    @property
    def gap(self):
        """The largest difference between the share of a next state and its probability; None before the first move."""
        return float(np.abs(self.counts / self.tries - self.chances).max()) if self.tries else None

    def _look(self):
        self.world = with_rules(self._maze, slip=self.dials.slip)
        mdp, row = self.world.mdp, (self.cell, self.dials.action)
        size = self.world.grid.size
        self.chances = np.bincount(mdp.next_state[row], weights=mdp.probability[row], minlength=size)
        self.reward = float((mdp.probability[row] * mdp.reward[row]).sum())
        self.ends = float(mdp.probability[row][mdp.terminal[row]].sum())
        self.landings = list(dict.fromkeys(self._slippery.mdp.next_state[row].tolist()))  # the meant one comes first
        self.counts, self.landed = np.zeros(size, np.int64), None
        self.message = f"{self._row_in_words()} {self._pays()}."

    def _draw(self, tries):
        drawn = self._random.multinomial(tries, self.chances)
        self.counts += drawn
        self.landed = int(drawn.argmax()) if tries == 1 else None
        told = f"Move {self.tries:,} landed in cell {self.landed}." if tries == 1 else f"{self.tries:,} moves."
        near = f"The shares are at most {self.gap:.4f} away from T; 1/√n is {self.tries**-0.5:.4f}."
        self.message = f"From cell {self.cell}, {self._action}: {told} {near}"

    @property
    def _moves(self):
        return f"{self.tries:,} move" + "s" * (self.tries != 1)

    @property
    def _action(self):
        return self.dials.action.name.lower()

    def _row_in_words(self):
        parts = []
        for s in (s for s in self.landings if self.chances[s]):
            where = f"stays in cell {s}" if s == self.cell else f"gets to cell {s}"
            parts.append(f"{where} with probability {self.chances[s]:.3g}")
        return f"From cell {self.cell}, {self._action}: the mouse {', '.join(parts)}."

    def _pays(self):
        ends = "does not end the episode" if not self.ends else "ends the episode"
        chance = f" with probability {self.ends:.3g}" if 0 < self.ends < 1 else ""
        return f"The reward to expect is R(s, a) = {numeral(self.reward, '.3g')}; the move {ends}{chance}"

    def _map(self):
        board = Board(self.world, f"T(s = {self.cell}, a = {self._action}, s')")
        reached = [s for s in self.landings if self.chances[s]]
        board.tiles(colours={s: _tint(self.chances[s]) for s in reached})
        board.cheese()
        board.mouse(self.cell, size=0.14)
        roomy = board.cell >= _ROOMY
        beside = {"aside": -0.27, "start": -0.1, "length": 0.22}  # of the mouse: before it stands the cell's chance
        ahead = {"start": 0.17, "length": 0.25}
        over_the_chance = self.dials.action == (Action.UP if roomy else Action.DOWN)
        board.arrow(self.cell, self.dials.action, **(beside if over_the_chance else ahead))
        board.frame(self.cell, BLUE)
        board.tag(self.cell)
        board.corner_note(self.world.start, "start" if roomy else "S", top=not roomy)
        for s in reached:
            board.note(
                s, f"{self.chances[s]:.3g}", down=-0.33 if roomy else 0.27, size=max(11, min(15, board.cell / 4))
            )
        if self.landed is not None:
            x, y = board.middle(self.landed)
            aside, down = (-0.3, 0.3) if roomy else (-0.38, 0.0)
            if not roomy and self.dials.action in (Action.LEFT, Action.DOWN):
                aside = 0.38  # on the left is the arrow
            x, y = x + aside * board.cell, y + down * board.cell
            board.sketch.circle(x, y, 0.08 * board.cell, fill=RED, stroke="#ffffff", stroke_width=2)
        hint = "Click a cell, or go to it with the arrow keys. A dot marks where a single move landed."
        hint += "" if roomy else " S: the start."
        words = f"{place(self.world, self.cell).capitalize()} is chosen. {self._row_in_words()}"
        words += f" The last move landed in cell {self.landed}." if self.landed is not None else ""
        return Panel("map", words, board.svg(), board=hint)

    def _bars(self):
        names = {i: f"cell {s}" + " (stays)" * (s == self.cell) for i, s in enumerate(self.landings)}
        chart = Chart(
            f"Next states after {self._moves}", x=(-0.5, len(names) - 0.5), y=(0, 1.1), xlabel="next state s'",
            ylabel="probability; share of the moves", height=210, legend=2, names=names,
        )  # fmt: skip
        told = []
        for i, s in enumerate(self.landings):
            chart.bar(i, self.chances[s], 0, width=32, shift=-_BESIDE)
            chart.note(i, self.chances[s], f"{self.chances[s]:.3g}", shift=-_BESIDE)
            told.append(f"cell {s}: probability {self.chances[s]:.3g}")
            if self.tries:
                share = self.counts[s] / self.tries
                chart.bar(i, share, width=32, shift=_BESIDE, hollow=True)
                chart.note(i, share, f"{round(share, 3):g}", shift=_BESIDE)
                told[-1] += f", share {round(share, 3):g}"
        chart.legend("T(s, a, s'), the probability", 0, kind="bar")
        drawn = f"share of {self._moves}" if self.tries else "share of the moves: none drawn yet"
        chart.legend(drawn, 0, kind="hollow")
        return Panel("bars", f"After {self._moves}. {'; '.join(told)}.", chart.svg())

    def _table(self):
        head = ("s'", "T", "moves", "share", "share − T")
        rows = []
        for s in self.landings:
            drawn = ("–", "–", "–")
            if self.tries:
                share = self.counts[s] / self.tries
                drawn = (f"{self.counts[s]:,}", f"{share:.3f}", numeral(share - self.chances[s], "+.3f"))
            rows.append((f"{s} (stays)" if s == self.cell else str(s), f"{self.chances[s]:.3g}", *drawn))
        lines = [f"{self._pays()}."]
        if self.tries:
            lines += [f"Largest |share − T|: {self.gap:.4f}.", f"1/√n, rarely exceeded: {self.tries**-0.5:.4f}."]
        head = "".join(f'<th scope="col">{escape(text)}</th>' for text in head)
        html = f"<table><tr>{head}</tr>{''.join(map(_row, rows))}</table>"
        html += f"<p>{'<br>'.join(escape(line) for line in lines)}</p>"
        return Panel("table", html=html)


def transitions(maze=None):
    """A row of T on the maze, and moves drawn from it beside it; by default lesson 1's maze on ice.

    Cell, action and slip can be chosen. `ValueError` for what is no `Maze`, and for one of more than 8 rows or columns.
    """
    return Explorer(Transitions(maze))


def _row(texts):
    first, *rest = map(escape, texts)
    cells = "".join(f"<td>{text}</td>" for text in rest)
    return f'<tr><th scope="row" style="font-weight:400;text-align:left">{first}</th>{cells}</tr>'


def _tint(share):
    """From the floor's colour to sky blue."""
    low, high = (0xEC, 0xEC, 0xEA), (0x56, 0xB4, 0xE9)
    weight = 0.25 + 0.75 * float(share)
    return "#" + "".join(f"{round(a + (b - a) * weight):02x}" for a, b in zip(low, high, strict=True))
