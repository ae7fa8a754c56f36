"""What lesson 3 says of its explorers is what they show: every number of its answers."""

from pathlib import Path

import nbformat
import numpy as np
import pytest

from course_lib import Action, Maze
from course_lib.explore.hundred_agents import QLearning
from course_lib.explore.td_update import OneUpdate
from course_lib.plots.board import acting_states


@pytest.fixture(scope="module")
def said():
    path = Path(__file__).parents[2] / "notebooks" / "03_q_table.ipynb"
    return "\n".join(cell.source for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "markdown")


def put(explored, **values):
    """Turn dials to these values, by what is written beside them."""
    for name, value in values.items():
        explored.turn(name, explored.view().control(name).texts.index(f"{value:g}"))
    return explored


def above_0(explored):
    return {(s, Action(a).name.lower()): explored.q_table[s, a] for s, a in np.argwhere(explored.q_table > 0).tolist()}


def test_good_news_travels_back_a_cell_an_episode(said):
    explored = OneUpdate()
    assert f"How many of the {4 * len(acting_states(explored.maze))} values are above 0" in said
    explored.press("episode")
    ((cell, action), value), *more = above_0(explored).items()
    assert not more
    assert (
        f"The first episode ends with the first positive reward: `Q({cell}, {action})` goes from 0 to {value:g}."
        in said
    )
    explored.press("episode")
    known = above_0(explored)
    last = known.pop((cell, action))
    ((before, step), news), *more = known.items()
    assert not more
    assert "1. One, then two." in said
    assert f"In the second the mouse comes by cell {before} and steps {step} from there" in said
    assert f"`Q({before}, {step})` becomes 0.1 · 0.9 · 0.1 = {news:g}" in said
    assert f"`Q({cell}, {action})` becomes {last:g}." in said


def test_three_bumps(said):
    explored, values = OneUpdate(), []
    for action in (Action.DOWN, Action.RIGHT, Action.RIGHT, Action.RIGHT, Action.RIGHT):
        explored.arrow(action)
        values.append(explored.last.new)
    assert values[:2] == [0, 0]
    assert explored.state == 5
    first, second, third = (f"−{-value:g}" for value in values[2:])
    assert f"Its value goes to {first}, {second}, {third}: each time a tenth of what is missing" in said
    assert explored.last.target == -1


def test_without_a_future_only_rewards_are_learned(said):
    explored = put(OneUpdate(), gamma=0)
    for _ in range(100):
        explored.press("episode")
    assert "Only those of bumps and of the last step to the cheese." in said
    rewarded = explored.maze.mdp.reward[:, :, 0] != 0
    assert explored.q_table.any()
    assert not explored.q_table[~rewarded].any()


def learned(**settings):
    """What the explorer shows then: (an episode's median moves, the number of good tables, the message)."""
    explored = put(QLearning(), **settings)
    medians = np.median(explored.trained.moves, axis=0)
    return (lambda episode: f"{medians[episode - 1]:g}"), int(explored.trained.good.sum()), explored.message


def test_the_first_picture(said):
    moves, _, _ = learned()
    assert f"At first the median mouse needs {moves(1)} moves; from episode 10 on it needs {moves(10)}, the" in said
    assert {moves(episode) for episode in range(10, 101)} == {"6"}
    assert moves(9) != "6"


def test_a_learners_own_walks(said):
    explored = QLearning(walks=([1.0] * 12, [6] * 12))
    assert "episode, up to 30 of 100" in explored.view().panels[0].svg
    assert "your own learning curve then stands beside the first 30 episodes of theirs" in said


def test_curious_mice(said):
    (moves, good, _), (sooner, still, message) = learned(epsilon=1), learned(epsilon=1, epsilon_decay=0.95)
    assert f"{moves(100)} moves in the median of episode 100. Yet {good} of 100 tables lead straight" in said
    both = f"With a decay of 0.95 you get both: {sooner(10)} moves in episode 10, {sooner(100)} in episode 100"
    assert f"{both}, and still {still} good tables." in said
    shown = f"Episode 10: {sooner(10)} moves in the median; episode 100: {sooner(100)} moves"
    assert message.startswith(shown), "the answers are about what the message says"
    assert "the lines below them tell of episodes 10 and 100" in said


def test_slow_believers(said):
    (moves, _, message), (before, _, _) = learned(alpha=0.01), learned()
    assert moves(10) == before(10)
    assert f"Not one: {moves(10)} moves in episode 10, as before." in said
    worth, truth = worths(message)
    assert f"the start is worth {worth} to the middle mouse, and {truth} in truth." in said


def test_without_discount(said):
    moves, good, _ = learned(alpha=1, gamma=1)
    assert f"No: {good} of 100 tables lead straight, and the median of episode 100 is {moves(100)} moves." in said
    assert learned(gamma=1)[1] == 100
    assert "(With γ = 1 and α = 0.1 all 100 do:" in said


def test_slips(said):
    (moves, good, message), (large_moves, large_good, large_message) = learned(slip=0.1), learned(slip=0.1, alpha=1)
    assert f"With α = 0.1, {good} of 100 tables earn at least 90 % of the best possible return" in said
    assert f"with α = 1 only {large_good} do. The large α comes down sooner" in said
    assert float(large_moves(10)) < 0.6 * float(moves(10))
    worth, truth = worths(large_message)
    assert f"believes too much: the start is worth {worth} to its middle mouse, and {truth} in truth." in said
    assert worth > truth > worths(message)[0]


def worths(message):
    worth, truth = message.split("The start is worth ")[1].rstrip(".").split(" to the middle agent, exactly ")
    return worth, truth


def test_all_sliders_go_back_to_where_they_stood():
    state = QLearning(Maze(wall_ends_episode=False, slip=0.1))
    first = state.view()
    for control in first.controls:
        if control.kind == "slider":
            state.turn(control.name, 0)
    assert state.view().panels != first.panels
    state.press("first")
    assert state.view() == first
