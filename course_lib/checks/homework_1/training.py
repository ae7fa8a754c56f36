"""A watched training with its test walks, and the table that it should have led to at each of them."""

from dataclasses import dataclass
from itertools import count

import numpy as np

from course_lib.checks.check import NotYet
from course_lib.checks.homework_1.learning import learn, same
from course_lib.checks.homework_1.mazes import blank
from course_lib.checks.homework_1.walks import explain_fault
from course_lib.checks.learner import Fault, Seed
from course_lib.checks.plain import described
from course_lib.checks.worlds import Watched
from course_lib.maze import Maze

_LONGEST_EPISODE, _LONGEST_WALK = 300, 100


@dataclass(frozen=True)
class Training:
    """One call of the learner's train(maze, eval_maze, rng, max_episodes)."""

    world: Watched
    exam: Watched
    value: object  # what was returned
    max_episodes: int

    @property
    def maze(self):
        return self.world.maze

    @property
    def episodes(self):
        return self.world.played

    @property
    def walks(self):
        return self.exam.played

    def returned(self):
        """(table, number of episodes) as returned; `NotYet` if it is something else."""
        return _table_and_number(self.value)

    @property
    def number(self):
        """The number of episodes as returned, or None."""
        try:
            return self.returned()[1]
        except NotYet:
            return None

    def tables(self, learns_on_walks=False):
        """The table at each test walk, and the one after all, for a mouse that learned by lesson 3's rule from zero."""
        table, at_walks = blank(self.maze), []
        events = [(episode.began, episode, True) for episode in self.episodes]
        events += [(walk.began, walk, False) for walk in self.walks]
        for _, episode, is_training in sorted(events, key=lambda event: event[0]):
            if not is_training:
                at_walks.append(table.copy())
            if is_training or learns_on_walks:
                learn(table, self.maze, episode)
        return at_walks, table

    def learned_as_taught(self, learns_on_walks=False):
        """Whether the returned table is the one that the rule of lesson 3 leads to."""
        return same(self.returned()[0], self.tables(learns_on_walks)[1])


def train(call, grid, seed, max_episodes):
    """A `Training` in the maze of that grid."""
    clock = count()
    most = max_episodes * _LONGEST_EPISODE  # a loop that heeds both limits cannot take more steps
    world = Watched(
        Maze(grid, wall_ends_episode=False), time_limit=_LONGEST_EPISODE, max_steps=max(most, 50_000) + 1, clock=clock
    )
    exam = Watched(Maze(grid), time_limit=_LONGEST_WALK, clock=clock)
    try:
        returned = call(world, exam, Seed(seed), max_episodes)
    except Fault as fault:
        if exam.stepped_after:
            raise NotYet(
                str(fault),
                "the test walk goes on after its end. It ends at the cheese, at a bump, and when the clock stops it: "
                "`terminated or truncated`.",
            ) from None
        if (world.exhausted or exam.exhausted) and len(world.played) > max_episodes:
            raise NotYet(
                f"still training after {len(world.played)} episodes with max_episodes = {max_episodes}",
                "your loop runs until the mouse can walk, however long that takes: it is to give up after "
                "`max_episodes`.",
            ) from None
        explain_fault(fault, world)
        raise
    return Training(world, exam, returned.value, max_episodes)


def _table_and_number(value):
    parts = value if isinstance(value, tuple) else (value,)
    if len(parts) == 2:
        table, number = _as_table(parts[0]), parts[1]
        if table is not None and _is_number(number):
            return table, number
        if table is not None and isinstance(number, tuple):
            raise NotYet(
                f"a table and {len(number)} values",
                "the second one is a list: what is wanted is the number of episodes.",
            )
        if _as_table(number) is not None and _is_number(parts[0]):
            raise NotYet(
                f"a number and a table: {described(value)}", "the order is the other way round: `q_table, episodes`."
            )
    likely = "your function returns something else than two things, the table and the number of episodes."
    if value is None:
        likely = "your function ends without `return`, at least when the mouse can walk."
    elif len(parts) == 1 and _is_number(value):
        likely = "the table is missing: `return q_table, episodes`."
    elif _as_table(value) is not None:
        likely = "the number of episodes is missing: `return q_table, episodes`."
    raise NotYet(described(value), likely)


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _as_table(value):
    """An array of two dimensions, or a list of lists as one, as floats; else None."""
    try:
        table = np.array(value, float) if isinstance(value, (np.ndarray, tuple)) else None
    except (TypeError, ValueError):
        return None
    return table if table is not None and table.ndim == 2 and table.size else None
