"""Lesson 3, one update at a time: Q-learning slowed down until each of its numbers can be followed."""

from dataclasses import dataclass
from html import escape

import numpy as np

from course_lib.explore.controls import Button, Dials, Panel, View
from course_lib.explore.drawing.board import ARROWS, SIGNS, Board, place
from course_lib.explore.explorer import Explorer
from course_lib.explore.numerals import numeral
from course_lib.explore.worlds import counted, own_maze, table_in_words, value_span
from course_lib.maze import Action
from course_lib.plots.board import acting_states
from course_lib.q_table import QAgent
from course_lib.validate import whole_number

MAX_STEPS = 1000  # of an episode, as in QAgent's train
_BUTTONS = {"step": "one step", "ten": "10 steps", "episode": "to the end of the episode", "over": "start over"}
_EMPTY = (
    "<p><b>The last update</b></p><p>Nothing has been learned yet: every number of the table is 0. Press “one step”,"
    " or click the board and press an arrow key.</p>"
)


@dataclass(frozen=True)
class Update:
    """One update of the table with all its numbers.

    how         how the action was chosen, in words; bumped: into a wall
    following   Q(s', ·) as it was before the update, float64[A]
    old, new    Q(s, a) before and after
    terminated, truncated   whether the world or the clock ended the episode
    """

    state: int
    action: Action
    how: str
    reward: float
    next_state: int
    bumped: bool
    terminated: bool
    truncated: bool
    following: np.ndarray
    alpha: float
    gamma: float
    target: float
    old: float
    new: float


class OneUpdate:
    """A mouse that learns while one watches: QAgent's draws and arithmetic, a step at a time.

    maze      a `Maze` of at most 8 x 8 cells, by default the course's, in which a bump costs 1 and the walk goes on;
              seed: the agent's
    q_table   float64[S, A]; state: where the mouse is; episode and moves: which one it plays, and its moves so far
    last      the last `Update`, or None; updates: how many there were
    """

    title = "One update at a time"

    def __init__(self, maze=None, *, seed=0):
        self.maze = own_maze(maze, wall_ends_episode=False)
        self.seed = whole_number("seed", seed)
        self.dials = Dials(
            {
                "alpha": ("learning rate α", (0.01, 0.05, 0.1, 0.2, 0.5, 1.0), numeral),
                "gamma": ("discount γ", (0.0, 0.5, 0.8, 0.9, 0.95, 1.0), numeral),
                "epsilon": ("exploring ε", (0.0, 0.05, 0.1, 0.2, 0.5, 1.0), numeral),
            },
            alpha=0.1, gamma=0.9, epsilon=0.1,
        )  # fmt: skip
        self._start_over()

    @property
    def q_table(self):
        """What the mouse believes, float64[S, A]."""
        return self._agent.q_table

    def turn(self, name, at):
        """Put a slider to its stop number `at`; it counts from the next step on."""
        self.dials.turn(name, at)
        self.message = f"From the next step on: α = {self.dials.alpha:g}, γ = {self.dials.gamma:g}"
        self.message += f", ε = {self.dials.epsilon:g}."

    def press(self, name):
        """Make one "step", "ten" of them, those to the end of the "episode", or start "over"."""
        if name not in _BUTTONS:
            raise ValueError(f"the buttons are {', '.join(_BUTTONS)}, got {name!r}")
        if name == "over":
            self._start_over()
        elif name == "episode":
            episode = self.episode
            while self.episode == episode:
                self._step()
        else:
            for _ in range({"step": 1, "ten": 10}[name]):
                self._step()
            if name == "ten":
                self.message = f"10 steps. The last one: {self.message}"

    def arrow(self, action):
        """Take this action instead of the agent's, and learn from it."""
        self._act(Action(action), "you chose it")

    def choose(self, cell):
        """Take the action that leads to `cell`, where it lies beside the mouse."""
        self.maze.cell(cell)
        for action in Action:
            if self.maze.cell_ahead(self.state, action) == cell != self.state:
                return self.arrow(action)
        self.message = f"Choose a cell beside the mouse, which is in {place(self.maze, self.state)}."
        return None

    def view(self):
        """The board with the table on it, and the last update."""
        sliders = [self.dials.slider(name) for name in ("alpha", "gamma", "epsilon")]
        buttons = [Button(name, label, name == "over" and not self.updates) for name, label in _BUTTONS.items()]
        return View((*sliders, *buttons), (self._board(), self._numbers()), self.message)

    def _start_over(self):
        self._agent = QAgent(self.maze, seed=self.seed)
        self.state, _ = self.maze.reset()
        self.episode, self.moves, self.reward, self.updates, self.last = 1, 0, 0.0, 0, None
        self.message = f"The mouse is in {place(self.maze, self.state)} and knows nothing: all of Q is 0."

    def _step(self):
        """The agent's own next step."""
        self._agent.epsilon = self.dials.epsilon
        row, rng = self.q_table[self.state], self._agent.rng
        before = rng.bit_generator.state
        explores = rng.random() < self.dials.epsilon  # a look at the draw that the agent is about to make
        rng.bit_generator.state = before
        alike = int((row == row.max()).sum())
        how = "exploited: the largest of Q(s, ·)"
        if alike > 1:
            how = f"exploited: {alike} actions have the largest Q(s, ·), one of them was drawn"
        if explores:
            how = f"explored: drawn from all {len(row)} actions"
        self._act(Action(self._agent.act(self.state)), how)

    def _act(self, action, how):
        """Act, and learn from it: the lesson's update, with every number kept."""
        state, alpha, gamma = self.state, self.dials.alpha, self.dials.gamma
        self.state, reward, terminated, _, info = self.maze.step(action)
        self.moves, self.reward, self.updates = self.moves + 1, self.reward + reward, self.updates + 1
        following, old = self.q_table[self.state].copy(), float(self.q_table[state, action])
        target = float(reward if terminated else reward + gamma * following.max())
        self.q_table[state, action] += alpha * (target - old)
        self.last = Update(
            state, action, how, reward, self.state, info["bumped"], terminated, self.moves >= MAX_STEPS, following,
            alpha, gamma, target, old, float(self.q_table[state, action]),
        )  # fmt: skip
        self.message = f"Step {self.moves} of episode {self.episode}: {_name(action)} from cell {state} {self._felt()}."
        self.message += f" Q({state}, {_name(action)}): {_text(old)} → {_text(self.last.new)}."
        if terminated or self.last.truncated:
            end = "is over" if terminated else "was cut off"
            self.message += f" Episode {self.episode} {end} after {counted(self.moves, 'move')}, reward"
            self.message += f" {_text(self.reward)}. The mouse is back at the start."
            self.state, _ = self.maze.reset()
            self.episode, self.moves, self.reward = self.episode + 1, 0, 0.0

    def _felt(self):
        last = self.last
        if last.bumped:
            return f"bumps into a wall (r = {_text(last.reward)}), the mouse stays in cell {last.next_state}"
        if last.next_state == last.state:
            return f"leads nowhere, it is the edge (r = {_text(last.reward)})"
        cheese = ", to the cheese" if last.next_state in self.maze.goals else ""
        return f"to cell {last.next_state}{cheese} (r = {_text(last.reward)})"

    def _board(self):
        board = Board(self.maze, f"Q in episode {self.episode}, after {counted(self.moves, 'move')}")
        board.tiles()
        board.wedges(self.q_table, *value_span(self.maze))
        board.cheese()
        changed = ""
        if self.last is not None:
            board.frame_wedge(self.last.state, self.last.action)
            changed = f" The dashed frame is around {_name(self.last.action)} in {place(self.maze, self.last.state)}."
        for s in acting_states(self.maze):
            board.tag(s)
        board.mouse(self.state, size=0.09)
        words = f"The mouse is in {place(self.maze, self.state)}.{changed} {table_in_words(self.maze, self.q_table)}"
        hint = "Choose actions yourself: click a cell beside the mouse, or use the arrow keys."
        return Panel("board", words, board.svg(), board=hint)

    def _numbers(self):
        last = self.last
        if last is None:
            return Panel("update", "Nothing has been learned yet.", html=_EMPTY)
        lines = [(name, text) for name, text in self._lines(last)]
        rows = "".join(
            f"<tr><th scope='row' style='white-space:nowrap'>{escape(name)}</th><td>{escape(text)}</td></tr>"
            for name, text in lines
        )
        head = f"<p><b>The last update</b>, number {self.updates}; numbers rounded to 5 places</p>"
        words = f"Update {self.updates}. " + "; ".join(f"{name}: {text}" for name, text in lines) + "."
        return Panel("update", words, html=f"{head}<table>{rows}</table>")

    def _lines(self, last):
        """The update, line by line, all numbers put in."""
        end = "the episode goes on"
        if last.terminated:
            end = "terminated, nothing follows"
        elif last.truncated:
            end = f"cut off after {MAX_STEPS} moves, not terminated"
        yield "s", place(self.maze, last.state)
        yield "a", f"{ARROWS[last.action]}; {last.how}"
        yield "r", _text(last.reward) + (", a bump" if last.bumped else "")
        yield "s'", f"{place(self.maze, last.next_state)}; {end}"
        if last.terminated:
            yield "target", f"r = {_text(last.target)}"
        else:
            best = _text(last.following.max())
            known = ", ".join(f"{SIGNS[a]} {_text(last.following[a])}" for a in Action)
            yield "Q(s', ·)", f"{known}; max = {best}"
            sum_ = f"{_text(last.reward)} + {_text(last.gamma)} · {_factor(last.following.max())}"
            yield "target", f"r + γ max Q(s', ·) = {sum_} = {_text(last.target)}"
        error = last.target - last.old
        yield "error", f"target − Q(s, a) = {_text(last.target)} − {_factor(last.old)} = {_text(error)}"
        sum_ = f"{_text(last.old)} + {_text(last.alpha)} · {_factor(error)}"
        yield "Q(s, a)", f"new: Q(s, a) + α · error = {sum_} = {_text(last.new)}"


def one_update(maze=None):
    """Q-learning a step at a time, every number of the update put in; by default in lesson 0's maze.

    The steps are those of `QAgent(maze, seed=0)`, or the learner's own by the arrow keys. `ValueError` for what is no
    `Maze`, and for one of more than 8 rows or columns.
    """
    return Explorer(OneUpdate(maze))


def _name(action):
    return Action(action).name.lower()


def _text(value):
    """At most 5 places behind the point, as the lesson prints them."""
    return numeral(value, "z.5f").rstrip("0").rstrip(".")


def _factor(value):
    text = _text(value)
    return f"({text})" if text.startswith("−") else text
