"""The maze between judge and learner: the judge's side plays it and keeps the record, the learner's side asks."""

from dataclasses import dataclass, field
from itertools import count

import gymnasium

from course_lib.checks.plain import described, plain
from course_lib.maze import Action, Maze
from course_lib.validate import whole_number

_MOST_REFUSALS = 1_000  # to a learner's loop that lets every error pass


class EnoughSteps(BaseException):
    """A walk that does not stop by itself is stopped, or calls without end. `str`: what the code did, if no steps.

    No `Exception`, so that `except Exception` lets it pass.
    """


@dataclass
class Episode:
    """What was done in one episode: T steps, T + 1 states."""

    began: int  # the judge's clock, which counts all resets and steps in all its worlds
    states: list = field(default_factory=list)
    actions: list = field(default_factory=list)
    rewards: list = field(default_factory=list)
    bumps: list = field(default_factory=list)
    terminated: bool = False
    truncated: bool = False

    def __len__(self):
        return len(self.actions)

    def steps(self):
        """(t, state, action, reward, next_state, bumped) of each step."""
        return zip(range(len(self)), self.states, self.actions, self.rewards, self.states[1:], self.bumps, strict=False)

    @property
    def over(self):
        return self.terminated or self.truncated

    @property
    def reached_the_cheese(self):
        return self.terminated and not self.bumps[-1]


class Watched:
    """The judge's side of a maze: plays it, and remembers every reset, step and bump.

    time_limit  steps after which an episode is truncated
    max_steps   steps in all, and resets in all, after which `EnoughSteps` is raised
    clock       an `itertools.count`, shared by worlds whose order of events matters
    """

    def __init__(self, maze, *, time_limit=1000, max_steps=50_000, clock=None):
        self.maze, self.time_limit, self.max_steps = maze, time_limit, max_steps
        self.clock = clock or count()
        self.rows, self.columns = maze.rows, maze.columns
        self.episodes, self.steps, self._refusals = [], 0, 0
        self.stepped_after = ""  # "terminated" or "truncated", once a step came after the end of an episode

    def reset(self):
        if len(self.episodes) == self.max_steps:
            raise EnoughSteps
        state, info = self.maze.reset()
        self.episodes.append(Episode(next(self.clock), [state]))
        return state, info

    def step(self, action):
        action = plain(action)
        if not isinstance(action, int) or not 0 <= action < len(Action):
            self._refuse(f"an action is 0, 1, 2 or 3, got {described(action)}")
        if not self.episodes:
            self._refuse("the mouse is not in the maze yet: call maze.reset() first")
        episode = self.episodes[-1]
        if episode.over:
            self.stepped_after = self.stepped_after or ("terminated" if episode.terminated else "truncated")
            self._refuse(f"this episode is over ({self.stepped_after}): no step can follow but a reset")
        if self.steps == self.max_steps:
            raise EnoughSteps
        self.steps += 1
        next(self.clock)
        state, reward, terminated, _, info = self.maze.step(action)
        episode.actions.append(int(action))
        episode.states.append(state)
        episode.rewards.append(reward)
        episode.bumps.append(info["bumped"])
        episode.terminated = terminated
        episode.truncated = not terminated and len(episode) >= self.time_limit
        return state, reward, terminated, episode.truncated, info

    def _refuse(self, words):
        self._refusals += 1
        if self._refusals > _MOST_REFUSALS:
            raise EnoughSteps
        raise ValueError(words)

    @property
    def played(self):
        """The episodes in which a step was taken: a reset that nothing follows does no harm."""
        return [episode for episode in self.episodes if len(episode)]

    @property
    def exhausted(self):
        return self.steps >= self.max_steps or len(self.episodes) >= self.max_steps

    def answer(self, name, *arguments):
        """What the learner's `World` asks for."""
        if name not in ("reset", "step"):
            raise ValueError(f"a maze has no {name!r}")
        return getattr(self, name)(*arguments)


class World(gymnasium.Env):
    """The learner's side of a maze: as `Maze`, but without the map, which a mouse does not have.

    ask  answers "reset" and ("step", action): the judge's `Watched.answer`, or a pipe that leads to it
    """

    def __init__(self, rows, columns, ask):
        self.rows, self.columns, self._ask = rows, columns, ask
        self.observation_space = gymnasium.spaces.Discrete(rows * columns)
        self.action_space = gymnasium.spaces.Discrete(len(Action))

    def reset(self, *, seed=None, options=None):  # noqa: ARG002 (Gymnasium's signature)
        super().reset(seed=seed)
        return self._ask("reset")

    def step(self, action):
        return self._ask("step", action)

    def state(self, row, column):
        """The number of the cell in `row` and `column`, both from 0."""
        row = whole_number("row", row, below=self.rows)
        return row * self.columns + whole_number("column", column, below=self.columns)

    def cell(self, state):
        """The (row, column) of a state."""
        return divmod(whole_number("state", state, below=self.rows * self.columns), self.columns)

    def __getattr__(self, name):
        if hasattr(Maze, name) or name in ("grid", "start", "goals"):
            raise AttributeError(f"this maze shows no {name!r}: a mouse has no map, only rows, columns, reset and step")
        raise AttributeError(f"a maze has no {name!r}")

    def __reduce_ex__(self, protocol):
        """What `copy` and `pickle` ask for; a copy would let the mouse try a step before it takes it."""
        raise TypeError("this maze cannot be copied: there is one mouse, in one place")
