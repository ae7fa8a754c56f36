"""Lesson 3, the Q-learning explorer: a hundred agents learn from scratch at every move of a slider."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from course_lib.explore.controls import Button, Dials, Panel, View
from course_lib.explore.drawing.board import Board
from course_lib.explore.drawing.chart import Chart
from course_lib.explore.explorer import Explorer
from course_lib.explore.how_good import best_reward, fewest_moves, greedy_way, leads_straight, returns_of, solution
from course_lib.explore.mouse import KEPT_IN, checked_walks, kept_walks
from course_lib.explore.numerals import numeral, short, signed
from course_lib.explore.worlds import counted, own_maze, table_in_words, value_span, with_rules
from course_lib.maze import Action
from course_lib.plots.board import acting_states
from course_lib.q_table import train_side_by_side

NUM_AGENTS, NUM_EPISODES = 100, 100
MAX_STEPS = 200  # of an episode: nothing more is to be seen in longer ones, and they would keep one waiting
_SLIDERS = ("alpha", "gamma", "epsilon", "epsilon_decay", "slip")
_MOVES, _REWARD = "moves of an episode", "reward of an episode"
_YOU = "you, in lesson 0"
_EARLY = 10  # an episode of which the message tells as well: by then most of the learning is done
_ROOM_FOR_WALKS = 30  # episodes: beside somebody's own walks the curve is shown up to here, or a little beyond them
_NEARLY = 0.9  # of the best possible return: what a table that has learned its lesson earns


@dataclass(frozen=True)
class Trained:
    """What came of one training. N agents, M episodes.

    world     the maze in which they learned; moves, rewards: of every episode, float64[N, M]
    tables    float64[N, S, A]; middle: the number of the agent whose value of the start is the middle one
    exact_q   float64[S, A], Q* of the world's cells that can be reached; None where it is not defined
    good      bool[N]: whether a table's best actions lead straight to the cheese, or, where moves slip, earn nearly
              the best possible return
    """

    world: object
    moves: np.ndarray
    rewards: np.ndarray
    tables: np.ndarray
    middle: int
    exact_q: np.ndarray | None
    good: np.ndarray


class QLearning:
    """A hundred `QAgent`s with seeds 0 to 99, trained anew for a hundred episodes at every move of a slider.

    maze     a `Maze` of at most 8 x 8 cells, by default the course's, in which a bump costs 1 and the walk goes on, as
             in lesson 0
    walks    (returns, lengths) of walks to be drawn beside the agents'; by default those kept from lesson 0 in the
             current folder, which are read when the learner asks for them
    trained  what came of the last training, a `Trained`
    """

    title = "The Q-learning explorer"

    def __init__(self, maze=None, walks=None):
        self._given = None if walks is None else _given(walks)
        self.maze, self.walks = own_maze(maze, wall_ends_episode=False), self._given
        self.dials = Dials(
            {
                "alpha": ("learning rate α", (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0), numeral),
                "gamma": ("discount γ", (0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0), numeral),
                "epsilon": ("exploring ε", (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0), numeral),
                "epsilon_decay": ("ε decay", (0.8, 0.9, 0.95, 0.98, 0.99, 1.0), numeral),
                "slip": ("slip", tuple(sorted({0.0, 0.05, 0.1, 0.2, 0.3, 0.5, self.maze.slip})), numeral),
                "curve": ("curve", (_MOVES, _REWARD)),
            },
            alpha=0.1, gamma=0.9, epsilon=0.1, epsilon_decay=1.0, slip=self.maze.slip, curve=_MOVES,
        )  # fmt: skip
        self._retrain()

    def turn(self, name, at):
        """Put a slider to its stop number `at`, and train anew; or choose another curve."""
        self.dials.turn(name, at)
        if name != "curve":
            self._retrain()
        else:
            self.message = f"The curve shows the {self.dials.curve}. {self._last_episode()}"

    def press(self, name):
        """Show or hide the learner's own "walks", or put the sliders back to where they stood at "first"."""
        if name not in ("walks", "first"):
            raise ValueError(f"the buttons are walks and first, got {name!r}")
        if name == "first":
            self.dials.start_over(*_SLIDERS)
            self._retrain()
            return
        if self.walks is not None:
            self.walks = None
            self._tell()
            return
        self.walks = kept_walks() if self._given is None else self._given
        if self.walks is None:
            self.message = "There are no walks of yours yet: play lesson 0, and your curve appears here."
            if Path(KEPT_IN).exists():
                self.message = f"{KEPT_IN} cannot be read as walks: play lesson 0 again, and it is written anew."
            return
        (*_, reward), (*_, moves) = self.walks
        self.message = f"Your walks in lesson 0 are drawn as squares, {len(self.walks[0])} of them. The last one took"
        self.message += f" {counted(moves, 'move')} and had a reward of {signed(reward)}."
        self.message += f" While they are shown, the curve ends at episode {self._last_shown}."

    def view(self):
        """The learning curve of all agents, and the table of one."""
        sliders = [self.dials.slider(name) for name in _SLIDERS]
        label = "show my walks from lesson 0" if self.walks is None else "hide my walks"
        controls = (*sliders, self.dials.choice("curve"), Button("walks", label), Button("first", "as at first"))
        return View(controls, (self._curve(), self._table()), self.message)

    def _retrain(self):
        rates = {name: getattr(self.dials, name) for name in _SLIDERS if name != "slip"}
        self.trained = _train(with_rules(self.maze, slip=self.dials.slip), NUM_AGENTS, **rates)
        self._best = {_MOVES: fewest_moves(self.trained.world), _REWARD: best_reward(self.trained.world)}
        self._tell()

    def _tell(self):
        """The message: how the walks end, how good the tables are, and what the middle agent believes."""
        trained = self.trained
        does = "lead straight to the cheese"
        if trained.world.slip and trained.exact_q is not None:
            does = f"earn at least {_NEARLY:.0%} of the best possible return"
            if trained.exact_q[trained.world.start].max() <= 0:
                does = f"come within {1 - _NEARLY:.0%} of the best possible return"
        self.message = f"{self._last_episode()} Without exploring, {trained.good.sum()} of {NUM_AGENTS} tables"
        self.message += f" {does}.".replace("%", "\u00a0%")
        worth = numeral(self._middle_table[trained.world.start].max(), "z.3f")
        self.message += f" The start is worth {worth} to the middle agent"
        if trained.exact_q is not None:
            self.message += f", exactly {numeral(trained.exact_q[trained.world.start].max(), 'z.3f')}"
        self.message += "."

    def _last_episode(self):
        """An early number of the curve and its last ones, in words."""
        runs = self.trained.moves if self.dials.curve == _MOVES else self.trained.rewards
        low, middle, high = map(short, np.percentile(runs[:, -1], (5, 50, 95)))
        early = short(np.median(runs[:, _EARLY - 1]))
        early, last = (
            counted(much, "move") if self.dials.curve == _MOVES else f"a reward of {much}" for much in (early, middle)
        )
        told = f"Episode {_EARLY}: {early} in the median; episode {NUM_EPISODES}: {last}"
        return f"{told} (5 to 95\u00a0%: {low} to {high})."

    @property
    def _last_shown(self):
        """The last episode of the curve: one's own few walks would have no room beside a hundred."""
        if self.walks is None:
            return NUM_EPISODES
        walks = len(self.walks[0])
        return max(_ROOM_FOR_WALKS, min(walks + 5, NUM_EPISODES), walks)

    @property
    def _middle_table(self):
        return self.trained.tables[self.trained.middle]

    def _curve(self):
        name, (yours_reward, yours_moves) = self.dials.curve, ((), ()) if self.walks is None else self.walks
        runs, yours = (self.trained.moves, yours_moves) if name == _MOVES else (self.trained.rewards, yours_reward)
        best, last = self._best[name], self._last_shown
        low, middle, high = np.percentile(runs[:, :last], (5, 50, 95), axis=0)
        episodes = np.arange(1, len(middle) + 1)
        xlabel = "episode" if last >= NUM_EPISODES else f"episode, up to {last} of {NUM_EPISODES}"
        look = {"x": (0, 1.03 * last), "xlabel": xlabel, "height": 230, "legend": 2}
        if name == _MOVES:
            known = yours if best is None else [best, *yours]
            span = (0.72 * min([low.min(), *known]), 1.15 * max([MAX_STEPS, *known]))
            unit = f"moves, on a log scale; walks are cut off at {MAX_STEPS}"
            chart = Chart("Learning curve: moves", y=span, ylabel=unit, log=True, **look)
        else:
            floor = min([low.min(), best or 0.0, -1.0, *yours])
            floor = next(f for f in (-5, -10, -20, -50, -100, -200, -500, -1000, floor) if f <= floor)
            top = max([high.max(), best or 0.0, *yours])
            unit = f"reward; walks are cut off at {MAX_STEPS} moves"
            chart = Chart("Learning curve: reward", y=(floor, top + 0.15 * (top - floor)), ylabel=unit, **look)
        chart.band(episodes, low, high)
        chart.line(episodes, middle)
        chart.legend(f"median of {NUM_AGENTS} agents, band: 5 to 95 %", 0, kind="band")
        words = f"{name.capitalize()}, median of {NUM_AGENTS} agents and 5 to 95 % band. "
        told = [f"episode {i}: {_three(middle, low, high, i)}" for i in (1, 5, 10, 25, 50, 100) if i <= last]
        words += "; ".join(told) + "."
        if best is not None:
            kind = "fewest possible" if name == _MOVES else "best possible"
            if name == _MOVES and self.maze.wall_ends_episode:
                kind = "fewest to the cheese"  # a bump may end a walk sooner
            kind += ", on average" * (self.dials.slip > 0)
            chart.rule(best, f"{kind}: {short(best)}", above=name != _MOVES)
            words += f" Dotted line, {kind}: {short(best)}."
        if len(yours):
            chart.line(np.arange(1, len(yours) + 1), yours, 1)
            chart.points(np.arange(1, len(yours) + 1), yours, 1, shape="square")
            chart.legend(_YOU, 1, kind="square")
            words += f" {_YOU.capitalize()}: {', '.join(short(value) for value in yours)}."
        return Panel("curve", words, chart.svg())

    def _table(self):
        trained, table = self.trained, self._middle_table
        board = Board(trained.world, f"Q of agent {trained.middle}, the middle one")
        board.tiles()
        board.wedges(table, *value_span(trained.world))
        board.cheese()
        for s in acting_states(trained.world):
            board.tag(s)
        actions, end = greedy_way(trained.world, table)
        for s, a in actions:
            board.arrow(s, a, start=-0.1, length=0.2)
        way = ", ".join(Action(a).name.lower() for _, a in actions)
        words = f"Agent {trained.middle} has the middle value of the start among {NUM_AGENTS}. Its best actions, the"
        words += f" white arrows, lead from the start {way or 'nowhere'}: {end}."
        if actions and trained.exact_q is not None:
            off = max(abs(table[s, a] - trained.exact_q[s, a]) for s, a in actions)
            words += f" The largest error of Q on this way is {off:.3f}."
        words += f" {table_in_words(trained.world, table)}"
        return Panel("table", words, board.svg())


def q_learning(maze=None, walks=None):
    """A hundred agents that learn anew at every move of a slider, by default in lesson 0's maze.

    walks   (returns, lengths) of walks to draw beside their curve; by default lesson 0's, once the learner asks for
            them. `ValueError` for what is no `Maze`, for one of more than 8 rows or columns, and for walks that do
            not fit together.
    """
    return Explorer(QLearning(maze, walks))


def _train(world, num_agents, *, gamma, **settings):
    """A `Trained` of agents with seeds from 0 on."""
    seeds = range(num_agents)
    tables, history = train_side_by_side(world, seeds, NUM_EPISODES, max_steps=MAX_STEPS, gamma=gamma, **settings)
    moves, rewards = history.episode_length.astype(float), history.episode_return
    middle = int(np.argsort(tables[:, world.start].max(axis=1), kind="stable")[(num_agents - 1) // 2])
    exact = solution(world, gamma)
    if world.slip and exact is not None:
        best = exact.values[world.start]
        good = returns_of(world, tables, gamma) >= best - (1 - _NEARLY) * abs(best) - 1e-9
    else:
        good = leads_straight(world, tables)
    return Trained(world, moves, rewards, tables, middle, None if exact is None else exact.q, good)


def _three(middle, low, high, episode):
    return f"{short(middle[episode - 1])} ({short(low[episode - 1])} to {short(high[episode - 1])})"


def _given(walks):
    try:
        returns, lengths = walks
    except (TypeError, ValueError):
        raise ValueError(f"walks must be (returns, lengths), got {walks!r}") from None
    return checked_walks(returns, lengths)
