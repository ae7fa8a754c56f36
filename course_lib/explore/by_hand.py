"""Lesson 2, Bellman by hand: evaluate and improve as buttons, one cell's equation with its numbers, a maze to edit."""

from dataclasses import replace

import numpy as np

from course_lib.bellman import action_values, bellman_sweep, evaluate_policy
from course_lib.explore.controls import Button, Dials, Panel, View
from course_lib.explore.drawing.board import Board, acting_states, best_actions, place
from course_lib.explore.equation import STEADY, Equation, error_chart, written
from course_lib.explore.explorer import Explorer
from course_lib.explore.numerals import numeral, short
from course_lib.explore.worlds import counted, own_maze, with_rules
from course_lib.maze import Action, Tile
from course_lib.plots.picture import BLUE
from course_lib.validate import whole_number

_GAMMAS = (*(round(0.05 * i, 2) for i in range(20)), 0.99)
_ROOMY = 70  # pixels of a cell with room for the word "start"


class BellmanByHand:
    """A maze that can be edited, the values V, a policy π, and the equation of one chosen cell.

    maze      a `Maze` of at most 8 rows and columns, by default lesson 2's
    world     the maze as it is now; values: V, float[S]; policy: π(a | s), float[S, A]; cell: the chosen state

    The policy shares a cell equally among its best actions; where all four are alike, as at the start, it is the
    random one. `values` change only by an evaluation, `policy` only by an improvement, or both by a solution.
    """

    title = "Bellman by hand"

    def __init__(self, maze=None):
        self._first = maze = own_maze(maze, wall_reward=0.0, wall_ends_episode=False)
        pays = sorted({round(0.1 * i - 1, 1) for i in range(21)} | set(maze.cell_rewards.ravel().tolist()))
        slips = sorted({round(0.05 * i, 2) for i in range(13)} | {maze.slip})
        stops = {
            "gamma": ("discount γ", _GAMMAS, numeral),
            "slip": ("slip", slips, "{:.3g}".format),
            "reward": ("", pays, written),
            "at_once": ("solve at once", (False, True)),
        }
        self._pays = pays
        self.dials = Dials(stops, gamma=0.9, slip=maze.slip, reward=0.0, at_once=False)
        self._restore()
        near = [s for s in acting_states(maze) if any(maze.cell_ahead(s, a) in maze.goals for a in Action)]
        self.cell = int(near[-1])
        self._show_reward()
        self._begin()

    def turn(self, name, at):
        """Another "gamma", "slip" or "reward" of the chosen cell; "at_once": every change is followed by a solution."""
        self.dials.turn(name, at)
        if name == "reward":
            self._pay()
        elif name == "gamma":
            self._change(f"γ is now {self.gamma:g}.")
        elif name == "slip":
            self._change(f"The slip is now {self.dials.slip:.3g}.")
        elif self.dials.at_once:
            self._solve()
        else:
            self.message = "From now on you evaluate and improve by hand."

    def press(self, name):
        """Evaluate by one "sweep" or to the "end", "improve", "solve", "begin" again; "wall" or "restore" the maze."""
        buttons = {
            "sweep": self._sweep,
            "end": self._evaluate,
            "improve": self._improve,
            "solve": self._solve,
            "begin": self._begin,
            "wall": self._toggle_wall,
            "restore": self._restore_and_tell,
        }
        if name not in buttons:
            raise ValueError(f"the buttons are {', '.join(buttons)}, got {name!r}")
        buttons[name]()

    def choose(self, cell):
        """Another cell, whose equation is then shown."""
        self.cell = whole_number("cell", cell, below=self.world.grid.size)
        self._show_reward()
        self.message = self.equation.in_words()

    def arrow(self, action):
        """The next cell that way, wall or not."""
        self.choose(self.world.cell_ahead(self.cell, action))

    def view(self):
        """The maze with its values and arrows, and the equation of the chosen cell."""
        same = ((self._grid, self._first.grid), (self._paid, self._first.cell_rewards))
        edited = not all(np.array_equal(now, first) for now, first in same)
        wall = self.world.grid.flat[self.cell] == Tile.WALL
        controls = (
            Button("sweep", "evaluate: one sweep"),
            Button("end", "evaluate fully"),
            Button("improve", "improve"),
            Button("solve", "solve"),
            Button("begin", "start over"),
            self.dials.slider("gamma"),
            self.dials.slider("slip"),
            replace(self.dials.slider("reward"), label=f"reward, cell {self.cell}"),
            Button("wall", f"{'no wall' if wall else 'wall'} in cell {self.cell}"),
            Button("restore", "original maze", idle=not edited),
            self.dials.switch("at_once"),
        )
        panels = (self._map(), self.equation.panel(), error_chart(self._errors, self.gamma))
        return View(controls=controls, panels=panels, message=self.message)

    @property
    def gamma(self):
        """The discount."""
        return self.dials.gamma

    @property
    def equation(self):
        """The Bellman equation of the chosen cell, with the numbers of now."""
        return Equation(self.world, self.values, self.policy, self.gamma, self.cell)

    @property
    def way(self):
        """The states that the policy leads through from the start, as meant; of equal actions the first."""
        way = [self.world.start]
        while len(best_actions(self.policy[way[-1]])) < len(Action):
            action = int(self.policy[way[-1]].argmax())
            ahead = self.world.cell_ahead(way[-1], action)
            if ahead in way or self.world.grid.flat[ahead] == Tile.WALL:
                break
            way.append(ahead)
        return way

    # --- values and policy

    def _begin(self):
        self.values = np.zeros(self.world.grid.size)
        self.policy = np.full((self.world.grid.size, len(Action)), 1 / len(Action))
        self._errors = [self._error()]
        self.message = "All values are 0, and the mouse takes each action with probability 1/4."
        if self.dials.at_once:
            self._solve()

    def _sweep(self):
        before, self.values = self.values, bellman_sweep(self.world.mdp, self.values, self.gamma, self.policy)
        self._errors.append(self._error())
        change = np.abs(self.values - before)
        told = f"Sweep {len(self._errors) - 1} of this policy wrote {written(self.values[self.cell])}"
        told += f" into cell {self.cell} (before: {written(before[self.cell])})."
        if change.max() > STEADY:
            self.message = f"{told} The largest change was {written(change.max())}, in cell {change.argmax()}."
        else:
            self.message = f"{told} No value changed: all equations of this policy hold."

    def _evaluate(self):
        self.values = evaluate_policy(self.world.mdp, self.policy, self.gamma)
        self._errors = [0.0]
        worth = written(self.values[self.world.start])
        self.message = f"All equations of this policy hold now. The start is worth {worth}."

    def _improve(self):
        changed = self._choose_best()
        if changed:
            self._errors = [self._error()]
            self.message = f"{counted(changed, 'cell')} changed what to do. {self._where_to()}"
            return
        again = bellman_sweep(self.world.mdp, self.values, self.gamma, self.policy)
        told = "Nothing to improve: every cell does what is best by these values."
        if np.abs(again - self.values).max() <= STEADY:
            told += " And all equations hold: the values are V*, the policy is optimal."
        self.message = told

    def _choose_best(self):
        """Improve the policy; in how many cells that changed it."""
        q = action_values(self.world.mdp, self.values, self.gamma)
        policy = np.full_like(self.policy, 1 / len(Action))
        for s in acting_states(self.world):
            best = best_actions(q[s])
            policy[s] = 0.0
            policy[s, best] = 1 / len(best)
        changed = int((policy != self.policy).any(axis=1).sum())
        self.policy = policy
        return changed

    def _solve(self, first=""):
        turns, gain = 0, np.inf
        while gain > STEADY or turns < 2:
            before, self.values = self.values, evaluate_policy(self.world.mdp, self.policy, self.gamma)
            gain = (self.values - before).max()
            turns += 1
            if not self._choose_best():
                break
        self._errors = [0.0]
        worth = written(self.values[self.world.start])
        often = {1: "once", 2: "twice"}.get(turns, f"{turns} times")
        told = f"{first} Evaluated and improved {often}: the start is worth {worth}."
        self.message = f"{told} {self._where_to()}".strip()

    def _error(self):
        """How far the values are from the policy's own."""
        exact = evaluate_policy(self.world.mdp, self.policy, self.gamma)
        return float(np.abs(self.values - exact).max())

    # --- the maze

    def _change(self, what):
        """The world is another one: by hand, values and policy stay as they are until the learner changes them."""
        self._build()
        over = np.flatnonzero(np.isin(self.world.grid.ravel(), (Tile.WALL, Tile.GOAL)))
        self.values[over], self.policy[over] = 0.0, 1 / len(Action)
        if self.dials.at_once:
            self._solve(what)
        else:
            self._errors = [self._error()]
            self.message = f"{what} Values and policy are still those of before: evaluate, improve."

    def _build(self):
        self.world = with_rules(self._first, grid=self._grid, cell_rewards=self._paid, slip=self.dials.slip)

    def _restore(self):
        self._grid, self._paid = self._first.grid.copy(), self._first.cell_rewards.copy()
        self._build()

    def _restore_and_tell(self):
        self._restore()
        self._show_reward()
        self._change("Walls and rewards are again what they were at first.")

    def _toggle_wall(self):
        if self.cell == self.world.start or self.cell in self.world.goals:
            what = "the start" if self.cell == self.world.start else "the cheese"
            self.message = f"In cell {self.cell} is {what}: there can be no wall."
            return
        before = self._grid.flat[self.cell]
        self._grid.flat[self.cell] = Tile.OPEN if before == Tile.WALL else Tile.WALL
        try:
            self._build()
        except ValueError:  # no way would be left
            self._grid.flat[self.cell] = before
            self.message = f"A wall in cell {self.cell} would shut the cheese away, so the cell stays open."
            return
        self._paid.flat[self.cell] = 0.0
        self._show_reward()
        self._change(f"Cell {self.cell} is {'open' if before == Tile.WALL else 'a wall'} now.")

    def _pay(self):
        if self.world.grid.flat[self.cell] == Tile.WALL:
            self._show_reward()
            self.message = f"Cell {self.cell} is a wall: nobody enters it, so it can pay nothing."
            return
        self._paid.flat[self.cell] = self.dials.reward
        self._change(f"Entering cell {self.cell} now adds {written(self.dials.reward)} to the reward.")

    def _show_reward(self):
        self.dials.turn("reward", self._pays.index(self._paid.flat[self.cell]))

    # --- what is to be seen

    def _pushes_on(self, cell):
        """Whether the chosen actions of a cell leave the mouse where it is, as long as it does not slip."""
        return all(self.world.mdp.next_state[cell, a, 0] == cell for a in best_actions(self.policy[cell]))

    def _where_to(self):
        way, steps = self.way, len(self.way) - 1
        slips = ", if nothing slips" if self.world.slip else ""
        if way[-1] in self.world.goals:
            return f"From the start it is {counted(steps, 'step')} to the cheese{slips}."
        if steps and self.world.slip and self._pushes_on(way[-1]):
            return f"From the start the arrows lead to cell {way[-1]}. There the mouse pushes on until it slips."
        if steps:
            return f"From the start the arrows lead to cell {way[-1]}, and not to the cheese."
        best = best_actions(self.policy[self.world.start])
        if len(best) == len(Action):
            best_swept = bellman_sweep(self.world.mdp, self.values, self.gamma)
            if np.abs(best_swept - self.values).max() <= STEADY:
                return "In the start all actions are equally good."
            return "In the start all actions are alike: no way is known yet."
        return f"In the start the mouse goes {Action(best[0]).name.lower()}, and stays where it is."

    def _map(self):
        acting, way = acting_states(self.world), self.way
        board = Board(self.world, "V and the policy")
        low = min(0.0, float(self.values.min()))
        high = max(float(self.values.max()), float(self.world.mdp.reward.max()))
        board.values(np.round(self.values, 12), low, high)  # what differs by rounding alone is to look alike
        board.walls()
        for goal in self.world.goals:
            board.fill(goal, "#ececea")
            board.number(goal)
        board.cheese()
        board.frame(self.cell, BLUE)
        board.tag(self.cell)
        board.arrows(self.policy, [(s, int(self.policy[s].argmax())) for s in way[:-1]])
        roomy = board.cell >= _ROOMY
        notes = {self.world.start: "start" if roomy else "S"}
        for s in np.flatnonzero(self.world.cell_rewards.ravel()).tolist():
            notes[s] = f"{notes.get(s, '')} {numeral(self.world.cell_rewards.flat[s], '+.3g')}".strip()
        for s, note in notes.items():
            board.corner_note(s, note, top=True)
        hint = "Click a cell, or go to it with the arrow keys. Orange, filled arrows: the way from the start"
        hint += "." if roomy else " (S)."
        return Panel("map", self._map_in_words(acting), board.svg(), board=hint)

    def _map_in_words(self, acting):
        told = []
        for s in acting:
            best = best_actions(self.policy[s])
            names = "any way" if len(best) == len(Action) else " or ".join(Action(a).name.lower() for a in best)
            told.append(f"cell {s}: {short(round(self.values[s], 12))}, {names}")
        walls = ", ".join(map(str, np.flatnonzero(self.world.grid == Tile.WALL))) or "none"
        paid = self.world.cell_rewards.ravel()
        pays = [f"{s}: {numeral(paid[s], '+.3g')}" for s in np.flatnonzero(paid)]
        words = f"{place(self.world, self.cell).capitalize()} is chosen. Values and policy: {'; '.join(told)}."
        words += f" Walls: {walls}. Start: {self.world.start}. Cheese: {', '.join(map(str, self.world.goals))}."
        return words + (f" Extra rewards on entering: {', '.join(pays)}." if pays else "")


def bellman(maze=None):
    """Evaluate and improve a policy by hand, with the equation of any cell; by default in lesson 2's maze.

    Walls, rewards, γ and slip can be changed. `ValueError` for what is no `Maze`, and for one of more than 8 rows or
    columns.
    """
    return Explorer(BellmanByHand(maze))
