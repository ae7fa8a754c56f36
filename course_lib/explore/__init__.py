"""Pictures that answer: each function gives an `Explorer`, which shows itself as the last value of a cell.

An explorer is one state without any widget in it (`BlindMaze`, …), which draws itself with `drawing` and is shown by
the one widget there is, in `explorer`. It can be worked by mouse and by keyboard, and says in words what it shows. By
lesson: 0 `mouse`, 1 `mdp`, 2 `by_hand`, 3 `td_update` and `hundred_agents`, 6 `dqn`, 5 and 7 `market`.
"""

from course_lib.explore.by_hand import BellmanByHand, bellman
from course_lib.explore.dqn import InsideTheNetwork, network
from course_lib.explore.explorer import Explorer
from course_lib.explore.hundred_agents import QLearning, q_learning
from course_lib.explore.mdp import Transitions, transitions
from course_lib.explore.mouse import KEPT_IN, BlindMaze
from course_lib.explore.td_update import OneUpdate, one_update

__all__ = [
    "BellmanByHand",
    "BlindMaze",
    "Explorer",
    "InsideTheNetwork",
    "OneUpdate",
    "QLearning",
    "Transitions",
    "be_the_mouse",
    "bellman",
    "network",
    "one_update",
    "q_learning",
    "trading_floor",
    "transitions",
]


def be_the_mouse(maze=None):
    """A maze in the dark, to be walked with buttons or arrow keys; by default the course's.

    In the course's maze finished walks are kept in my_mouse.json in the current folder, for lesson 3.
    """
    return Explorer(BlindMaze(maze, keep=KEPT_IN if maze is None else None))


def trading_floor(part=None, positions=None, *, cost=0.0005):
    """A market: without arguments, with Q-tables that learn at every move; else with your traders, on a part of it.

    part       a `market.Part`
    positions  {name: int[N] or int[E, N]}, -1, 0 or 1 at each of its bars: one to three traders, or kinds of traders
    cost       of a leg at first, one of 0, 0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005 and 0.01
    """
    from course_lib.explore import market  # it brings pandas, which lessons on mazes do without

    return market.trading_floor(part, positions, cost=cost)
