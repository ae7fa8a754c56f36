"""Lesson 0, be the mouse: a maze in the dark, what was felt in it, and a learning curve of one's own."""

import json
from pathlib import Path

import numpy as np

from course_lib.explore.controls import Button, Panel, View
from course_lib.explore.drawing.board import ARROWS, Board, place, small_maze
from course_lib.explore.drawing.chart import Chart
from course_lib.files import write_whole
from course_lib.maze import Action, Maze, Tile
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
        self.maze = Maze(wall_ends_episode=False) if maze is None else small_maze(maze, most=20)
        self.keep = keep
        self._forget()

    def press(self, name):
        """Move the mouse by the name of an action in small letters, or "forget" everything."""
        if name == "forget":
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
        self.message = f"{action.name.capitalize()}: {felt} ({reward:+g}). You are in {place(self.maze, self.cell)}."
        if terminated:
            self._end()

    def choose(self, cell):
        """Move the mouse to a cell beside its own; it does not jump further."""
        ways = [action for action in Action if self.maze.cell_ahead(self.cell, action) == cell != self.cell]
        if ways:
            self.arrow(ways[0])
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
        self.message += f"{bumped} Walk {len(self.returns)}: {_moves(self.moves)}, reward {self.reward:+g}."
        self.message += " Back to the start: can you do better?"
        self._begin()
        if self.keep is not None:
            try:
                keep_walks(self.keep, self.returns, self.lengths)
            except (OSError, ValueError) as error:
                self.message += f" (Your walks could not be kept: {error})"

    def _map(self):
        board = Board(self.maze, f"Walk {len(self.returns) + 1}: {_moves(self.moves)}, reward {self.reward:+g}")
        board.tiles(self.seen)
        board.cheese([goal for goal in self.maze.goals if self.seen[goal]])
        for unknown in np.flatnonzero(~self.seen):
            board.note(unknown, "?", down=0.0, size=16)
        board.note(self.maze.start, "start")
        board.mouse(self.cell)
        walls = np.flatnonzero(self.seen & (self.maze.grid.ravel() == Tile.WALL))
        words = f"The mouse is in {place(self.maze, self.cell)}."
        words += f" {self.seen.sum()} of {self.maze.grid.size} cells are known."
        words += f" Walls: {', '.join(map(str, walls)) or 'none found yet'}."
        how = "The dark maze: walk with the arrow keys, or click the next cell."
        return Panel("map", words, board.svg(), board=how)

    def _curve(self):
        walks = max(_SHOWN_WALKS, len(self.returns))
        most = max([12, *self.lengths]) * 1.15
        chart = Chart(
            "Your learning curve", x=(0.5, walks + 0.5), y=(0, most), xlabel="walk",
            ylabel="moves; beside each: reward", height=230, legend=1,
        )  # fmt: skip
        chart.legend("one walk to the cheese", 0, kind="circle")
        at = np.arange(1, len(self.returns) + 1)
        if len(at):
            chart.line(at, self.lengths, 0, stroke_opacity=0.5)
            chart.points(at, self.lengths)
            for walk, moves, reward in list(zip(at, self.lengths, self.returns, strict=True))[-_SHOWN_WALKS:]:
                chart.note(walk, moves, f"{reward:+g}")
        told = [f"walk {i}: {_moves(n)}, reward {r:+g}" for i, n, r in zip(at, self.lengths, self.returns, strict=True)]
        return Panel("curve", f"Your learning curve. {'; '.join(told) or 'No walk is finished yet'}.", chart.svg())


def _moves(number):
    return f"{number} move" + "s" * (number != 1)


def keep_walks(path, returns, lengths):
    """Write finished walks for lesson 3. `ValueError` where `path` is a folder or in none."""
    write_whole(path, json.dumps({"returns": list(returns), "lengths": list(lengths)}).encode())


def kept_walks(path=KEPT_IN):
    """(returns float64[N], lengths int64[N]) as `keep_walks` wrote them; None without such a file, or a foreign one."""
    try:
        kept = json.loads(Path(path).read_text(encoding="utf-8"))
        returns = np.array([number("return", value) for value in kept["returns"]])
        lengths = np.array([whole_number("length", value, at_least=1) for value in kept["lengths"]], np.int64)
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return (returns, lengths) if 0 < len(returns) == len(lengths) else None
