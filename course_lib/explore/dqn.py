"""Lesson 6, inside the network: what every node of a deep Q-network says, and how it came to say it."""

import numpy as np

from course_lib.bellman import value_iteration
from course_lib.explore.controls import Button, Dials, Panel, View
from course_lib.explore.drawing import nodes
from course_lib.explore.drawing.board import Board, place
from course_lib.explore.drawing.chart import Chart
from course_lib.explore.drawing.sketch import shade
from course_lib.explore.explorer import Explorer
from course_lib.explore.numerals import two_places
from course_lib.explore.training import BETWEEN, EPISODES, GAMMA, PARTS, Training
from course_lib.explore.worlds import counted, own_maze
from course_lib.maze import MOVES, Action, Tile
from course_lib.plots.board import acting_states, best_actions
from course_lib.plots.picture import INK
from course_lib.validate import whole_number

_MOST_ROWS = 5  # and columns: each cell is an input in the picture
_NAMES = ("↑ UP", "↓ DOWN", "← LEFT", "→ RIGHT")


def network(maze=None):
    """The agent of lesson 6, to be trained with and without its parts, and looked into at any moment, node by node.

    maze   a `Maze` of at most 5 x 5 cells; by default the lesson's, in which a bump into a wall pays 0
    """
    return Explorer(InsideTheNetwork(maze))


class InsideTheNetwork:
    """The first agent of lesson 6, to be trained and looked into at any moment of its training.

    maze   a `Maze` of at most 5 x 5 cells; by default the lesson's, in which a bump into a wall pays 0. `ValueError`
           for a larger one
    run    the `Training` that is shown; what was trained with other switches and seeds is kept as well
    cell   the chosen one
    """

    title = "Inside the network"

    def __init__(self, maze=None):
        self.maze = own_maze(maze, most=_MOST_ROWS, wall_reward=0.0)
        self.exact = value_iteration(self.maze.mdp, GAMMA)
        self._acting = acting_states(self.maze).tolist()
        known = self.exact.q[self._acting]
        self._colours = min(0.0, known.min()), max(0.1, known.max())  # lowest and highest, the same for every network
        off_on = (False, True)
        self._dials = Dials(
            {
                "episode": ("episode", tuple(range(0, EPISODES + 1, BETWEEN))),
                "mask": ("terminal mask", off_on),
                "replay": ("replay buffer", off_on),
                "target": ("target network", off_on),
                "double": ("double", off_on),
                "seed": ("seed", tuple(range(10))),
            },
            episode=0, mask=True, replay=False, target=False, double=False, seed=0,
        )  # fmt: skip
        self.cell = self.maze.start
        self._runs, self._before, self._training, self._wanted = {}, None, None, 0
        self.run = self._chosen_run()
        self._say("Untrained: press train.")

    def turn(self, name, at):
        """Look at another episode, or at a network of another kind or seed."""
        self._dials.turn(name, at)
        if name == "episode":
            self._wanted = self._dials.episode
            self._show(self._wanted)
            late = self._wanted > self._episode
            self._say(f"It has been trained for {self._episode} episodes only." if late else "")
            return
        why = ""
        if name == "double" and self._dials.double and not self._dials.target:
            self._dials.turn("target", 1)
            why = "Double asks a second network, so the target network is on as well. "
        elif name == "target" and self._dials.double and not self._dials.target:
            self._dials.turn("double", 0)
            why = "Without a target network there is nobody to ask, so double is off as well. "
        if (chosen := self._chosen_run()) is not self.run:
            self._before = self.run if self.run.episodes else self._before
            self.run, self._training = chosen, None
            self._show(self._wanted)
        self._say(f"{why}The network with {self.run.name} is {self._state_of_training()}.")

    def press(self, name):
        """Press "train", which goes on up to 500 episodes, step by step, or "stop"."""
        if name not in ("train", "stop"):
            raise ValueError(f"the buttons are train and stop, got {name!r}")
        if name == "stop":
            if self._training is not None:
                self._training = None
                self._say("Stopped; train goes on from here.")
            return None
        if self._training is self.run or self.run.episodes == EPISODES:
            return None
        self._training = self.run
        self._wanted = self.run.episodes
        self._show(self._wanted)
        self._say(f"The network with {self.run.name} plays up to {EPISODES} episodes and learns from every step.")
        return self._work(self.run)

    def choose(self, cell):
        """Put another cell in: its input becomes 1, the others 0."""
        self.cell = whole_number("cell", cell, below=self.maze.grid.size)
        self._say()

    def arrow(self, action):
        """Choose the neighbour of the chosen cell; walls can be chosen as well."""
        row, column = np.add(divmod(self.cell, self.maze.columns), MOVES[action])
        if 0 <= row < self.maze.rows and 0 <= column < self.maze.columns:
            self.cell = int(row * self.maze.columns + column)
        self._say()

    def view(self):
        """The map of what the network says, the network itself, its answers, and the way there."""
        training = self._training is not None
        controls = (
            Button("train", "train", idle=training or self.run.episodes == EPISODES),
            Button("stop", "stop", idle=not training),
            *(self._dials.switch(part) for part in ("mask", *PARTS)),
            self._dials.choice("seed"),
            self._dials.slider("episode"),
        )
        panels = (self._map(), self._network(), self._answers(), self._curve())
        return View(controls, panels, self.message, self.run.episodes / EPISODES if training else None)

    def _state_of_training(self):
        if self.run.episodes == 0:
            return "untrained: press train"
        return f"trained for {self.run.episodes} episodes" + ("; train goes on" * (self.run.episodes < EPISODES))

    @property
    def moment(self):
        """The `Moment` that is shown."""
        return self.run.moments[self._episode // BETWEEN]

    @property
    def _episode(self):
        return self._dials.episode

    def _chosen_run(self):
        parts = {name: getattr(self._dials, name) for name in ("mask", *PARTS)}
        key = (*parts.values(), self._dials.seed)
        if key not in self._runs:
            self._runs[key] = Training(self.maze, parts, self._dials.seed)
        return self._runs[key]

    def _work(self, run):
        """Train and look, train and look. Whoever looks at the latest moment goes along with it."""
        while self._training is run and run.episodes < EPISODES:
            goes_along = self._episode == run.episodes
            try:
                run.go_on()
            except Exception:  # train can be pressed again
                self._training = None if self._training is run else self._training
                raise
            if goes_along:
                self._wanted = run.episodes
                self._show(self._wanted)
            if run.episodes == EPISODES:
                self._training = None
                best = self._finds_the_way()
                self._say(f"Trained: {run.name}. It finds the best way at {best.sum()} of {len(best)} moments.")
            yield

    def _show(self, episode):
        self._dials.turn("episode", min(episode, self.run.episodes) // BETWEEN)

    def _say(self, first=""):
        if self._training is not None and self._episode == self.run.episodes:  # the numbers change all the time
            self.message = f"{first or 'Training goes on.'} You look at {place(self.maze, self.cell)}."
            return
        q, start = self.moment.q, self.maze.start
        best = int(q[self.cell].argmax())
        said = f"{place(self.maze, self.cell).capitalize()} after {self._episode} episodes:"
        said += f" the best is {Action(best).name}, {two_places(q[self.cell, best])} ({self._truth()})."
        said += f" From the start its arrows bring a discounted return of {two_places(self.moment.earned)};"
        said += f" the best possible is {two_places(self.exact.values[start])}."
        self.message = f"{first} {said}".strip()

    def _truth(self):
        if self.cell in self._acting:
            return f"exact: {two_places(self.exact.values[self.cell])}"
        where = "inside a wall" if self.maze.grid.flat[self.cell] == Tile.WALL else "at the cheese"
        return f"nobody ever acts {where}; a table would hold 0"

    def _finds_the_way(self):
        """bool[moments]: whether the arrows lead the best way from the start then."""
        return np.array([moment.earned for moment in self.run.moments]) > self.exact.values[self.maze.start] - 1e-6

    def _map(self):
        board = Board(self.maze, f"max Q after {self._episode} episodes")
        board.tiles()
        for s in self._acting:
            board.fill(s, shade(self.moment.q[s].max(), *self._colours)[0])
        board.cheese()
        board.frame(self.cell, inset=0)
        board.key(*self._colours)
        told = [self._write_into(board, s) for s in range(self.maze.grid.size)]
        words = f"What the network says of every cell after {self._episode} episodes of training: {'; '.join(told)}."
        hint = "Click a cell, or walk with the arrow keys. In each: its number, how many actions were taken in it (×),"
        return Panel("map", words, board.svg(), board=f"{hint} what the network says of it, and what is exact.")

    def _write_into(self, board, s):
        """All that is known about a cell, into it; the same in words."""
        q, visits, exact = self.moment.q[s], int(self.moment.tries[s].sum()), self.exact.values[s]
        (x, y), corner, acts = board.middle(s), board.cell / 2 - 4, s in self._acting
        wall = self.maze.grid.flat[s] == Tile.WALL
        ink = shade(q.max(), *self._colours)[1] if acts else "#ffffff" if wall else INK
        if acts:
            board.number(s, ink)
        board.sketch.text(x + corner, y - corner + 6, f"{visits:,}×", size=11, anchor="end", colour=ink)
        if acts:
            look = {"size": 15, "colour": ink, "font_weight": "600"}
            board.sketch.text(x - 0.2 * board.cell, y, two_places(q.max()), **look)
            for a in best_actions(q):
                board.arrow(s, Action(a), aside=0.25, start=-0.14)
            board.note(s, f"exact {two_places(exact)}", colour=ink)
        else:
            board.note(s, two_places(q.max()), colour=ink, down=0.0 if wall else 0.36, size=13)
        truth = f"exact {two_places(exact)}" if acts else "nobody acts here"
        return f"cell {s}: {two_places(q.max())} by {Action(int(q.argmax())).name}, {truth}, {visits} actions taken"

    def _network(self):
        layers = self.moment.layers
        arriving, q = nodes.forward(layers, np.eye(self.maze.grid.size)[self.cell])
        dead = nodes.dead_nodes(layers)
        speak = [f"{i + 1}: {two_places(v)}" for i, v in enumerate(arriving) if v > 0]
        words = f"Input {self.cell} is 1, all others are 0. {len(speak)} of {len(arriving)} hidden nodes speak:"
        words += f" {', '.join(speak) or 'none'}. {len(arriving) - len(speak)} are silent,"
        words += f" and of these {dead.sum()} dead: silent in every cell."
        words += f" Outputs: {_listed(q)}. The best is {Action(int(q.argmax())).name}."
        title = f"The network, cell {self.cell} put in"
        return Panel("network", words, nodes.network(layers, self.cell, _NAMES, title))

    def _answers(self):
        q, tries = self.moment.q[self.cell], self.moment.tries[self.cell]
        exact = self.exact.q[self.cell] if self.cell in self._acting else None
        words = f"Q-values in cell {self.cell}. The network: {_listed(q)}. "
        words += "Nobody ever acts here. " if exact is None else f"Exact: {_listed(exact)}. "
        words += f"Tried: {', '.join(f'{a.name} {tries[a]} times' for a in Action)}."
        return Panel("answers", words, nodes.answers(q, exact, tries, _NAMES, f"Q(s, a) in cell {self.cell}"))

    def _curve(self):
        shown = [("now", self.run)]
        if self._before is not None and self._before is not self.run:
            shown.append(("before", self._before))
        lines = [run.worth(self.cell) for _, run in shown]
        exact = self.exact.values[self.cell] if self.cell in self._acting else None
        ends = np.concatenate([*lines, [0.0, 1.0] if exact is None else [0.0, 1.0, exact]])
        low, high = ends.min(), ends.max()
        span = np.floor(low * 2) / 2, np.ceil(high * 2 + 0.2) / 2 + 0.1  # seldom another one, and no number at its top
        chart = Chart(
            f"Cell {self.cell} through training", x=(0, 1.03 * EPISODES), y=span, xlabel="episodes of training",
            ylabel="max Q", height=170, legend=3,
        )  # fmt: skip
        words = f"max Q of cell {self.cell} through training."
        if exact is not None:
            chart.rule(exact, f"exact {two_places(exact)}", above=False)
            words += f" Exact is {two_places(exact)}."
        for which, ((time, run), values) in reversed(list(enumerate(zip(shown, lines, strict=True)))):
            at = np.arange(len(values)) * BETWEEN
            chart.line(at, values, which)
            if run.episodes == 0:
                chart.points(at, values, which)
            told = ", ".join(f"{two_places(values[i])} after {at[i]}" for i in range(0, len(at), 10))
            words += f" {time.capitalize()} ({run.name}): {told} episodes."
        for which, (time, run) in enumerate(shown):
            chart.legend(f"{time}: {run.name}", which)
        best = self._finds_the_way()
        chart.points(np.flatnonzero(best) * BETWEEN, np.full(best.sum(), span[1]), 2, size=2.5, shape="square")
        chart.legend(f"at the top: best way, “now” at {best.sum()} of {counted(len(best), 'moment')}", 2, kind="square")
        words += f" Its arrows lead the best way from the start at {best.sum()} of {len(best)} moments"
        words += f" and lose it again {(best[:-1] & ~best[1:]).sum()} times."
        now = lines[0][self._episode // BETWEEN]
        chart.line([self._episode] * 2, span, stroke=INK, stroke_width=1, stroke_dasharray="4 3")
        chart.points([self._episode], [now], size=5)
        near = (self._episode < 0.06 * EPISODES) - (self._episode > 0.97 * EPISODES)  # an end of the axis
        chart.note(self._episode, now, two_places(now), shift=16 * near)
        words += f" Looked at: after {self._episode} episodes, {two_places(now)}."
        return Panel("curve", words, chart.svg())


def _listed(q):
    return ", ".join(f"{a.name} {two_places(q[a])}" for a in Action)
