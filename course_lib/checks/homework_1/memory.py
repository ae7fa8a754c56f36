"""Which cells a mouse had visited when it chose its way, and what its choices say of its memory."""

from dataclasses import dataclass

from course_lib.checks.check import NotYet
from course_lib.checks.homework_1.mazes import ahead, is_wall, map_of, place
from course_lib.maze import Action

_OFTEN = 0.2  # of the choices: more than the random steps of an epsilon-greedy mouse can account for


def open_fresh_actions(maze, episode, t):
    """The actions that, after t steps of the episode, lead to a cell that is no wall and was not visited."""
    return _open_fresh(maze, episode.states[t], set(episode.states[: t + 1]))


def _open_fresh(maze, here, visited):
    cells = {action: ahead(maze, here, action) for action in Action}
    return [a for a, cell in cells.items() if cell is not None and cell not in visited and not is_wall(maze, cell)]


def needless_returns(maze, episode):
    """Steps that stayed among visited cells with a fresh one at hand; all steps with one at hand; the first without.

    Lists of t, and a t or None. A bump is no return: the mouse has tried a cell that it did not know to be a wall.
    """
    returns, choices, first_dead_end = [], [], None
    visited = set()
    for t, here, _, _, there, bumped in episode.steps():
        visited.add(here)
        if _open_fresh(maze, here, visited):
            choices.append(t)
            if not bumped and there in visited:
                returns.append(t)
        elif first_dead_end is None:
            first_dead_end = t
    return returns, choices, first_dead_end


@dataclass(frozen=True)
class NeedlessReturn:
    """A needless return: step t of an episode led from `here` to `there`, a cell that was visited before."""

    maze: object
    t: int
    here: int
    there: int
    before: int | None  # the cell it had come from
    start: int
    action: Action


class Choices:
    """What was chosen in one or several episodes where a fresh cell was at hand, and which choices were needless.

    only_before_dead_ends  leave out all that came after the first dead end of an episode
    """

    def __init__(self, maze, episodes, *, only_before_dead_ends=False):
        self.number, self.returns = 0, []
        for episode in episodes:
            returns, choices, dead_end = needless_returns(maze, episode)
            end = dead_end if only_before_dead_ends and dead_end is not None else len(episode)
            self.number += sum(t < end for t in choices)
            self.returns += [_returned(maze, episode, t) for t in returns if t < end]

    def add(self, other):
        self.number += other.number
        self.returns += other.returns

    @property
    def share(self):
        """Of all these choices, how many were needless returns."""
        return len(self.returns) / max(1, self.number)

    @property
    def often(self):
        return len(self.returns) > 2 and self.share >= _OFTEN

    def say(self, likely=""):
        """Raise `NotYet` on the first needless return, if there is one."""
        if not self.returns:
            return
        first = self.returns[0]
        from_here = f"step {first.t + 1}: {first.action.name} from {place(first.maze, first.here)}"
        came = f"{from_here} to {place(first.maze, first.there)}, a visited cell, though a fresh one was at hand"
        if first.here == first.there:
            came = f"{from_here}, against the edge, though a fresh cell was at hand"
        raise NotYet(came, likely or self._likely(), map_of(first.maze, first.here))

    def _likely(self):
        several = len(self.returns) > 2  # fewer may be so by chance
        if several and all(step.here == step.there for step in self.returns):
            return (
                "your mouse counts what lies beyond the edge as a fresh cell. A move against the edge leaves it in "
                "the cell where it is, and that one it has visited."
            )
        if several and all(step.there == step.start for step in self.returns):
            return "the start is missing from your mouse's memory: it is a visited cell from the beginning."
        if all(step.there == step.start for step in self.returns):
            return (
                "the start is missing from your mouse's memory, or the random step, with probability epsilon, does "
                "not look at the memory."
            )
        if len(self.returns) > 5 and all(step.there not in (step.before, step.here) for step in self.returns):
            return "your mouse remembers the last cells only: the memory has to keep all cells of the episode."
        if not self.often:
            return (
                "only a few steps ignore the memory. Does the random step, with probability epsilon, also choose "
                "among the fresh cells only?"
            )
        return (
            "your mouse has no memory of the cells it came through: is the set made anew at every step, or never "
            "filled, or not used when the best action is chosen?"
        )


def _returned(maze, episode, t):
    before = next((state for state in reversed(episode.states[:t]) if state != episode.states[t]), None)
    return NeedlessReturn(
        maze, t, episode.states[t], episode.states[t + 1], before, episode.states[0], Action(episode.actions[t])
    )
