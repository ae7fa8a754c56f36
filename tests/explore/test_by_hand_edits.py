"""Bellman by hand, the maze edited: walls, rewards, γ and slip, with and without a solution at once."""

import numpy as np
import pytest

from course_lib import Action, Maze, value_iteration
from course_lib.explore import BellmanByHand

from .test_by_hand import assert_solved, panel, pressed, turned

PUDDLE = np.array([[0, 0, 0, 0], [0, -0.25, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1.5]])


def at_once():
    return turned(BellmanByHand(), "at_once", "on")


def paying(state, cell, reward):
    state.choose(cell)
    return turned(state, "reward", reward)


def test_by_hand_a_change_leaves_values_and_policy():
    state = pressed(BellmanByHand(), "solve")
    values, policy = state.values.copy(), state.policy.copy()
    for name, text in (("gamma", "0.5"), ("slip", "0.3"), ("reward", "−0.5")):
        turned(state, name, text)
        assert np.array_equal(state.values, values)
        assert np.array_equal(state.policy, policy)
        assert "Values and policy are still those of before" in state.message
    assert (state.gamma, state.world.slip, state.world.cell_rewards[3, 2]) == (0.5, 0.3, -0.5)
    assert_solved(pressed(state, "solve"))


def test_at_once_every_change_is_followed_by_a_solution():
    state = at_once()
    assert_solved(state)
    for name, text in (("gamma", "0.5"), ("slip", "0.3"), ("gamma", "0.99"), ("slip", "0"), ("gamma", "0")):
        assert_solved(turned(state, name, text))
    for cell in (2, 13, 9):
        state.choose(cell)
        assert_solved(pressed(state, "wall"))
        assert_solved(paying(state, 4, "0.7"))
    assert_solved(pressed(state, "restore"))
    assert_solved(pressed(state, "begin"))
    assert "by hand" in turned(state, "at_once", "off").message
    turned(state, "gamma", "0.9")
    assert "still those of before" in state.message


def test_a_wall_turns_the_way():
    state = at_once()
    assert state.way == [0, 4, 8, 9, 13, 14, 15]
    state.choose(13)
    assert state.view().control("wall").label == "wall in cell 13"
    pressed(state, "wall")
    assert state.world.grid[3, 1] == 1
    assert state.way == [0, 1, 2, 3, 7, 11, 15]
    assert state.message.startswith("Cell 13 is a wall now. Evaluated and improved")
    assert state.view().control("wall").label == "no wall in cell 13"
    assert "Walls: 6, 10, 12, 13." in panel(state, "map").words
    assert pressed(state, "wall").way == [0, 4, 8, 9, 13, 14, 15]
    assert state.message.startswith("Cell 13 is open now.")


def test_a_wall_in_a_cell_takes_its_value_and_its_arrow():
    state = pressed(BellmanByHand(), "solve")
    paying(state, 9, "0.3")
    pressed(state, "wall")
    assert (state.values[9], state.policy[9].tolist(), state.world.cell_rewards[2, 1]) == (0.0, [0.25] * 4, 0.0)
    assert state.view().control("reward").at == 10


@pytest.mark.parametrize(("cell", "why"), [(0, "the start"), (15, "the cheese")])
def test_start_and_cheese_stay(cell, why):
    state = BellmanByHand()
    state.choose(cell)
    pressed(state, "wall")
    assert state.message == f"In cell {cell} is {why}: there can be no wall."
    assert state.world.grid.tolist() == Maze().grid.tolist()


def test_the_cheese_cannot_be_shut_away():
    state = BellmanByHand()
    state.choose(13)
    pressed(state, "wall")
    state.choose(3)
    pressed(state, "wall")
    assert state.message == "A wall in cell 3 would shut the cheese away, so the cell stays open."
    assert state.world.grid[0, 3] == 0
    state.choose(2)
    assert "still those of before" in turned(state, "gamma", "0.5").message, "and the maze goes on"


def test_rewards_are_paid_on_entering_and_shown():
    state = paying(at_once(), 9, "0.1")
    assert state.message.startswith("Entering cell 9 now adds 0.1 to the reward.")
    assert state.world.mdp.R[8, Action.RIGHT] == pytest.approx(0.1)
    assert "Extra rewards on entering: 9: +0.1." in panel(state, "map").words
    assert ">+0.1</text>" in panel(state, "map").svg
    assert state.view().control("reward").label == "reward, cell 9"
    state.choose(8)
    assert state.view().control("reward").at == 10
    state.choose(9)
    assert state.view().control("reward").texts[state.view().control("reward").at] == "0.1"


def test_a_little_makes_a_detour_and_more_a_mouse_that_never_arrives():
    """The question of the lesson on cell 9."""
    state = paying(at_once(), 9, "0.1")
    assert 9 in state.way
    assert state.way[-1] == 15
    paying(state, 9, "0.2")
    assert state.way[-1] != 15
    assert "and not to the cheese" in state.message
    assert panel(state, "map").svg.count('fill="#d55e00" stroke="#22262b" stroke-width="0.9"') == len(state.way) - 1
    assert state.values[8] == pytest.approx(0.2 / (1 - 0.9**2))
    assert round(0.2 / (1 - 0.81), 2) == 1.05
    assert value_iteration(Maze(wall_reward=0.0, wall_ends_episode=False).mdp, 0.9).values.max() < 1.05


def test_a_wall_pays_nothing():
    state = paying(BellmanByHand(), 6, "1")
    assert state.message == "Cell 6 is a wall: nobody enters it, so it can pay nothing."
    assert state.view().control("reward").at == 10
    assert not state.world.cell_rewards.any()


def test_a_mouse_that_had_better_stay_is_said_to_stay():
    state = BellmanByHand(Maze([[3, 0, 4]], slip=0.5, cell_rewards=[[0, -1, 0]]))
    pressed(state, "solve")
    assert state.way == [0]
    assert "In the start the mouse goes " in state.message
    assert "and stays where it is." in state.message
    beside_a_wall = BellmanByHand(Maze([[1, 3, 0, 4]], slip=0.5, cell_rewards=[[0, 0, -1, 0]], wall_reward=0.0))
    assert pressed(beside_a_wall, "solve").way == [1]
    assert "In the start the mouse goes left, and stays" in beside_a_wall.message


def test_the_first_maze_comes_back():
    state = BellmanByHand(Maze(cell_rewards=PUDDLE))
    assert state.view().control("restore").idle
    paying(state, 5, "0.5")
    state.choose(13)
    pressed(state, "wall")
    assert not state.view().control("restore").idle
    state.choose(5)
    pressed(state, "restore")
    assert state.view().control("restore").idle
    assert state.world.cell_rewards.tolist() == PUDDLE.tolist()
    assert state.world.grid.tolist() == Maze().grid.tolist()
    assert state.view().control("reward").texts[state.view().control("reward").at] == "−0.25"


def test_the_given_maze_is_not_touched():
    maze = Maze(cell_rewards=PUDDLE)
    state = paying(BellmanByHand(maze), 5, "0.5")
    state.choose(13)
    pressed(state, "wall")
    assert maze.grid.tolist() == Maze().grid.tolist()
    assert maze.cell_rewards.tolist() == PUDDLE.tolist()


def test_arrow_keys_go_to_any_cell():
    state = BellmanByHand()
    for action, cell in ((Action.UP, 10), (Action.RIGHT, 11), (Action.RIGHT, 11), (Action.DOWN, 15), (Action.DOWN, 15)):
        state.arrow(action)
        assert state.cell == cell
    assert f"Cell {cell} (row 3, column 3) is chosen" in panel(state, "map").words


@pytest.mark.parametrize(
    ("method", "bad"),
    [
        ("turn", ("alpha", 0)), ("turn", ("gamma", 21)), ("turn", ("slip", -1)), ("turn", ("reward", 21)),
        ("turn", ("at_once", 2)), ("turn", ("gamma", 0.5)), ("press", ("up",)), ("choose", (16,)), ("choose", (None,)),
    ],
)  # fmt: skip
def test_bad_input_changes_nothing(method, bad):
    state = pressed(BellmanByHand(), "sweep", "improve")
    before = state.view()
    with pytest.raises(ValueError, match=r"control|gamma|slip|reward|at_once|buttons|cell"):
        getattr(state, method)(*bad)
    assert state.view() == before


@pytest.mark.parametrize("bad", ["maze", Maze().mdp, Maze.random(3, 9)])
def test_only_small_mazes_are_shown(bad):
    with pytest.raises(ValueError, match=r"a Maze is needed|at most 8 rows"):
        BellmanByHand(bad)
