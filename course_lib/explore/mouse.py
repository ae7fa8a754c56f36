"""Lesson 0, be the mouse: a maze in the dark, what was felt in it, and a learning curve of one's own."""

import json
from pathlib import Path

import numpy as np

from course_lib.explore.controls import Button, Panel, View
from course_lib.explore.drawing.board import ARROWS, Board, place
from course_lib.explore.drawing.chart import Chart
from course_lib.explore.numerals import signed
from course_lib.explore.worlds import counted, own_maze
from course_lib.files import write_whole
from course_lib.maze import Action, Tile
from course_lib.validate import number, whole_number

KEPT_IN = "my_mouse.json"
_SHOWN_WALKS = 10  # at least so many have room on the curve


class BlindMaze:
    """A maze of which only what was walked through or bumped into is seen.

    maze      a `Maze` of at most 20 x 20 cells, best one in which a bump does not end the walk
    keep      a file for the walks that were finished, or None. It is written after every walk; where that fails, the
              message says so
    returns   the reward of every finished walk; lengths: its moves
    """

    title = "Be the mouse"

    def __init__(self, maze=None, *, keep=None):
        self.maze = own_maze(maze, most=20, wall_ends_episode=False)
        self.keep, self._earlier = keep, None
        self._forget()

    def press(self, name):
        """Move the mouse by the name of an action in small letters, or "forget" everything."""
        if name == "forget":
            self._earlier = ([], [])
            self._forget()
        elif name.upper() in Action.__members__:
            self.arrow(Action[name.upper()])
        else:
            raise ValueError(f"the buttons are {', '.join(a.name.lower() for a in Action)} and forget, got {name!r}")

    def arrow(self, action):
        """Move the mouse."""
        before, ahead = self.cell, self.maze.cell_ahead(self.cell, action)
        self.cell, reward, terminated, _, info = self.maze.step(action)
        self.moves, self.reward = self.moves + 1, self.reward + reward
        self.seen[self.cell] = True
        felt = "nothing there but floor"
        if terminated and self.maze.grid.flat[self.cell] == Tile.GOAL:
            felt = "cheese!"
        elif info["bumped"]:
            felt = "ouch, a wall"
            self.seen[ahead] = self.seen[ahead] or not self.maze.slip  # who slips does not know where the wall is
        elif self.cell == before:
            felt = "the edge of the maze, you stay where you are"
        self.message = f"Move {self.moves}, {action.name.lower()}: {felt} ({signed(reward)})."
        self.message += f" You are in {place(self.maze, self.cell)}."
        if terminated:
            self._end()

    def choose(self, cell):
        """Move the mouse to a cell beside its own; it does not jump further. `ValueError` for what is no cell."""
        cell = whole_number("cell", cell, below=self.maze.grid.size)
        ways = [action for action in Action if self.maze.cell_ahead(self.cell, action) == cell != self.cell]
        if ways:
            self.arrow(ways[0])
        elif cell == self.cell:
            self.message = f"You are in cell {cell}. Now the arrow keys work."
        else:
            self.message = f"From cell {self.cell} there is no single move to cell {cell}."

    def view(self):
        """The map as far as it is known, and the walks so far."""
        buttons = [Button(action.name.lower(), label) for action, label in ARROWS.items()]
        buttons.append(Button("forget", "forget everything", idle=not (self.moves or self.returns)))
        return View(controls=tuple(buttons), panels=(self._map(), self._curve()), message=self.message)

    def _forget(self):
        self.returns, self.lengths = [], []
        self.seen = np.zeros(self.maze.grid.size, bool)
        self._begin(seed=0)
        self.message = "It is dark. Somewhere there is a cheese. Where do you go?"

    def _begin(self, seed=None):
        self.cell, _ = self.maze.reset(seed=seed)
        self.seen[self.cell] = True
        self.moves, self.reward = 0, 0.0

    def _end(self):
        self.returns.append(self.reward)
        self.lengths.append(self.moves)
        bumped = "" if self.maze.grid.flat[self.cell] == Tile.GOAL else " The walk is over."
        self.message += (
            f"{bumped} Walk {len(self.returns)}: {counted(self.moves, 'move')}, reward {signed(self.reward)}."
        )
        self.message += " You are back at the start."
        self._begin()
        if self.keep is not None:
            self._keep_walks()

    def _keep_walks(self):
        """Those from before this explorer was made, too: running the cell again costs nothing."""
        if self._earlier is None:
            self._earlier = [walks.tolist() for walks in kept_walks(self.keep) or (np.empty(0), np.empty(0))]
        returns, lengths = self._earlier
        try:
            keep_walks(self.keep, [*returns, *self.returns], [*lengths, *self.lengths])
        except (OSError, ValueError) as error:
            self.message += f" (Your walks could not be kept: {error})"

    @property
    def _walls(self):
        return self.maze.grid.ravel() == Tile.WALL

    def _map(self):
        walk = f"Walk {len(self.returns) + 1}: {counted(self.moves, 'move')}, reward {signed(self.reward)}"
        board = Board(self.maze, walk)
        board.tiles(self.seen)
        board.cheese([goal for goal in self.maze.goals if self.seen[goal]])
        for unknown in np.flatnonzero(~self.seen):
            board.note(unknown, "?", down=0.0, size=16)
        board.note(self.maze.start, "start")
        board.mouse(self.cell)
        words = f"The mouse is in {place(self.maze, self.cell)}."
        known = [", ".join(map(str, np.flatnonzero(self.seen & kind))) for kind in (~self._walls, self._walls)]
        words += f" Known floor: cells {known[0]}. Known walls: {known[1] or 'none yet'}."
        how = "The dark maze: walk with the arrow keys, or click the next cell."
        return Panel("map", words, board.svg(), board=how)

    def _curve(self):
        walks = max(_SHOWN_WALKS, len(self.returns))
        most = max([12, *self.lengths]) * 1.15
        chart = Chart(
            "Your learning curve", x=(0.5, walks + 0.5), y=(0, most), xlabel="walk",
            ylabel="moves; beside each: reward", height=230, legend=1,
        )  # fmt: skip
        chart.legend("one walk", 0, kind="circle")
        at = np.arange(1, len(self.returns) + 1)
        if len(at):
            chart.line(at, self.lengths, 0, stroke_opacity=0.5)
            chart.points(at, self.lengths)
            for walk, moves, reward in list(zip(at, self.lengths, self.returns, strict=True))[-_SHOWN_WALKS:]:
                chart.note(walk, moves, signed(reward))
        told = [
            f"walk {i}: {counted(n, 'move')}, reward {signed(r)}"
            for i, n, r in zip(at, self.lengths, self.returns, strict=True)
        ]
        return Panel("curve", f"Your learning curve. {'; '.join(told) or 'No walk is finished yet'}.", chart.svg())


def keep_walks(path, returns, lengths):
    """Write finished walks for lesson 3. `ValueError` where `path` is a folder or in none."""
    write_whole(path, json.dumps({"returns": list(returns), "lengths": list(lengths)}).encode())


def kept_walks(path=KEPT_IN):
    """(returns float64[N], lengths int64[N]) as `keep_walks` wrote them; None without such a file, or a foreign one."""
    try:
        kept = json.loads(Path(path).read_text(encoding="utf-8"))
        return checked_walks(kept["returns"], kept["lengths"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def checked_walks(returns, lengths):
    """(float64[N], int64[N]) of at least one walk; `ValueError` for what cannot be the returns and lengths of walks."""
    try:
        returns = np.array([number("return", value) for value in returns])
        lengths = np.array([whole_number("length", value, at_least=1) for value in lengths], np.int64)
    except TypeError:
        raise ValueError(f"walks must be lists of returns and of lengths, got {returns!r} and {lengths!r}") from None
    if not 0 < len(returns) == len(lengths):
        raise ValueError(f"walks need as many returns as lengths, got {len(returns)} and {len(lengths)}")
    return returns, lengths
