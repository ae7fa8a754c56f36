"""Mazes of an explorer's own: the same rules, and another maze all the same."""

import numpy as np
import pytest

from course_lib import Maze
from course_lib.explore import BellmanByHand, BlindMaze, InsideTheNetwork, OneUpdate, QLearning, Transitions
from course_lib.explore.worlds import counted, own_maze, table_in_words, value_span, with_rules

FREE = {"wall_ends_episode": False}


def test_a_maze_of_ones_own_keeps_its_rules():
    rules = {"slip": 0.3, "step_reward": -0.2, "wall_reward": -3.0, "goal_reward": 7.0}
    maze = Maze.random(3, 5, seed=1, cell_rewards=np.arange(15.0).reshape(3, 5), **rules)
    copy, changed = own_maze(maze), with_rules(maze, slip=0.0)
    assert copy is not maze
    for name in ("next_state", "probability", "reward", "terminal"):
        assert np.array_equal(getattr(copy.mdp, name), getattr(maze.mdp, name))
    assert (changed.slip, changed.goal_reward) == (0.0, 7.0)
    assert not own_maze(None, wall_ends_episode=False).wall_ends_episode
    assert own_maze(maze, wall_ends_episode=False).wall_ends_episode, "its own rules"


def test_what_is_no_maze_is_refused():
    for wrong in ("maze", 0, [[3, 4]]):
        with pytest.raises(ValueError, match="a Maze is needed"):
            own_maze(wrong)


@pytest.mark.parametrize("explored", [BlindMaze, Transitions, BellmanByHand, OneUpdate, QLearning, InsideTheNetwork])
def test_every_explorer_takes_a_maze_of_ones_own_and_checks_it(explored):
    maze = Maze.random(2, 3, seed=1, slip=0.25, goal_reward=7.0)
    world = getattr(explored(maze), "world", None) or explored(maze).maze
    assert world is not maze
    assert world.spec.kwargs.keys() == maze.spec.kwargs.keys()
    assert (world.slip, world.goal_reward, world.wall_ends_episode) == (0.25, 7.0, True)
    with pytest.raises(ValueError, match="a Maze is needed, got a str"):
        explored("maze")
    most = {BlindMaze: 20, InsideTheNetwork: 5}.get(explored, 8)
    explored(Maze.random(2, most, walls=0))
    with pytest.raises(ValueError, match=f"at most {most} rows and columns have room"):
        explored(Maze.random(2, most + 1, walls=0))


def test_the_colours_of_a_table_begin_or_end_at_0():
    costs = {"step_reward": -2.0, "wall_reward": -3.0, "goal_reward": -1.0}
    assert value_span(Maze()) == (-1.0, 1.0)
    assert value_span(Maze(**costs)) == (-3.0, 0.0)
    assert value_span(Maze(step_reward=0.5, wall_reward=0.0, goal_reward=4.0)) == (0.0, 4.0)


def test_a_table_in_words_leaves_out_what_is_0():
    q = np.zeros((16, 4))
    assert table_in_words(Maze(), q) == "All of Q is 0."
    q[0, 3], q[11, 0], q[11, 1], q[6, 2] = 0.125, -0.5, 1.0, 9.0
    assert table_in_words(Maze(), q) == "Q, where it is not 0: cell 0: right 0.12; cell 11: up −0.50, down 1.00."


def test_things_are_counted_in_english():
    assert [counted(number, "move") for number in (0, 1, 2)] == ["0 moves", "1 move", "2 moves"]
    assert [counted(number, "move") for number in (*np.arange(1, 3), "1", "1.5")] == [
        "1 move",
        "2 moves",
        "1 move",
        "1.5 moves",
    ]
