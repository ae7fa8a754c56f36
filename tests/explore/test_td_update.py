"""One update at a time: the agent of lesson 3 to the last bit, and every number of an update as it was."""

import re
from html import unescape

import numpy as np
import pytest

from course_lib import Action, Maze, QAgent, explore
from course_lib.explore.td_update import MAX_STEPS, OneUpdate
from course_lib.explore.worlds import counted

from . import minus

FREE = {"wall_ends_episode": False}
ALPHA, GAMMA, EPSILON = (
    (0.01, 0.05, 0.1, 0.2, 0.5, 1.0),
    (0.0, 0.5, 0.8, 0.9, 0.95, 1.0),
    (0.0, 0.05, 0.1, 0.2, 0.5, 1.0),
)
STOPS = {"alpha": ALPHA, "gamma": GAMMA, "epsilon": EPSILON}


def with_dials(maze=None, **values):
    explored = OneUpdate(maze)
    for name, value in values.items():
        explored.turn(name, STOPS[name].index(value))
    return explored


def board(explored):
    return explored.view().panels[0]


def numbers(explored):
    return explored.view().panels[1]


def lines(explored):
    """The lines of the panel, by their names."""
    rows = re.findall(r"<tr><th[^>]*>(.*?)</th><td>(.*?)</td></tr>", numbers(explored).html)
    return {unescape(name): unescape(text) for name, text in rows}


@pytest.mark.parametrize(
    ("maze", "settings"),
    [
        (None, {}),
        (None, {"alpha": 0.5, "gamma": 0.8, "epsilon": 0.5}),
        (Maze(), {"epsilon": 0.2}),
        (Maze.random(5, 3, seed=4, slip=0.2, step_reward=-0.25, **FREE), {"alpha": 1.0}),
    ],
    ids=["the course's", "other dials", "strict", "slippery"],
)
def test_it_is_lesson_3s_agent_to_the_last_bit(maze, settings):
    explored, agent = with_dials(maze, **settings), QAgent(maze or Maze(**FREE), seed=0, **settings)
    history = agent.train(60)
    for length, reward in zip(history.episode_length, history.episode_return, strict=True):
        before = explored.updates
        explored.press("episode")
        assert explored.updates - before == length
        assert f"after {counted(length, 'move')}, reward {reward:g}".replace("-", "−") in explored.message
    assert np.array_equal(explored.q_table, agent.q_table)


def test_every_update_is_the_lessons():
    explored, rng = with_dials(alpha=0.2, epsilon=0.5), np.random.default_rng(0)
    for i in range(400):
        if i == 150:
            explored.turn("gamma", GAMMA.index(0.5))
        before, state = explored.q_table.copy(), explored.state
        explored.arrow(Action(int(rng.integers(4)))) if i % 3 == 0 else explored.press("step")
        last = explored.last
        assert last.state == state
        gamma = 0.9 if i < 150 else 0.5
        target = last.reward + (0 if last.terminated else gamma * before[last.next_state].max())
        before[state, last.action] += 0.2 * (target - before[state, last.action])
        assert np.array_equal(explored.q_table, before)
        assert (last.target, last.new, last.gamma) == (target, before[state, last.action], gamma)


def test_it_says_truly_how_the_action_was_chosen():
    explored = with_dials(epsilon=0.2)
    seen = set()
    for i in range(600):
        row, rng = explored.q_table[explored.state].copy(), np.random.default_rng()
        rng.bit_generator.state = explored._agent.rng.bit_generator.state
        explored.press("step")
        ties = int((row == row.max()).sum())
        if rng.random() < 0.2:
            expected = "explored: drawn from all 4 actions"
        elif ties > 1:
            expected = f"exploited: {ties} actions have the largest Q(s, ·), one of them was drawn"
        else:
            expected = "exploited: the largest of Q(s, ·)"
        seen.add(expected.split(":")[0] + str(ties > 1))
        assert explored.last.how == expected
        assert i % 20 or expected in lines(explored)["a"]
    assert len(seen) == 4


def test_two_that_are_alike_are_a_tie():
    explored = with_dials(epsilon=0.0)
    explored.q_table[0] = (0, 0.5, 0, 0.5)
    explored.press("step")
    assert explored.last.how == "exploited: 2 actions have the largest Q(s, ·), one of them was drawn"


@pytest.mark.parametrize(("epsilon", "how"), [(0.0, "exploited"), (1.0, "explored")])
def test_epsilon_says_how_often_it_explores(epsilon, how):
    explored = with_dials(epsilon=epsilon)
    for _ in range(50):
        explored.press("step")
        assert explored.last.how.startswith(how)


def test_the_buttons_make_so_many_steps():
    explored = OneUpdate()
    assert [control.idle for control in explored.view().controls if control.name == "over"] == [True]
    explored.press("step")
    assert explored.updates == 1
    explored.press("ten")
    assert (explored.updates, explored.moves, explored.episode) == (11, 11, 1)
    assert explored.message.startswith("10 steps. The last one: Step 11 of episode 1")
    explored.press("episode")
    assert (explored.moves, explored.episode, explored.state) == (0, 2, 0)
    assert explored.last.terminated
    explored.turn("alpha", 5)
    explored.press("over")
    assert (explored.updates, explored.episode, explored.q_table.any(), explored.last) == (0, 1, False, None)
    assert explored.dials.alpha == 1.0, "the sliders stay"
    again = with_dials(alpha=1.0)
    for each in (explored, again):
        each.press("episode")
    assert np.array_equal(explored.q_table, again.q_table), "the same draws again"


def test_ones_own_choice_is_learned_from_and_draws_nothing():
    explored = OneUpdate()
    before = explored._agent.rng.bit_generator.state
    for action in (Action.DOWN, Action.RIGHT, Action.RIGHT):
        explored.arrow(action)
    assert explored._agent.rng.bit_generator.state == before
    assert (explored.state, explored.last.how, explored.last.bumped) == (5, "you chose it", True)
    assert explored.q_table[5, Action.RIGHT] == pytest.approx(-0.1)
    assert "right from cell 5 bumps into a wall (r = −1), the mouse stays in cell 5" in explored.message
    explored.press("over")
    explored.arrow(Action.UP)
    assert "leads nowhere, it is the edge (r = 0)" in explored.message


def test_what_is_learned_from_a_bump_depends_on_whether_the_walk_goes_on():
    for maze, target in ((None, -1 + 0.9 * 0.5), (Maze(), -1.0)):
        explored = OneUpdate(maze)
        explored.q_table[5] = (0, 0.5, 0, 0)
        for action in (Action.DOWN, Action.RIGHT, Action.RIGHT):
            explored.arrow(action)
        assert explored.last.target == pytest.approx(target)
        assert ("terminated, nothing follows" in lines(explored)["s'"]) == (maze is not None)
        assert ("Q(s', ·)" in lines(explored)) == (maze is None)
        assert explored.state == (5 if maze is None else 0)


def test_a_click_beside_the_mouse_is_an_action_too():
    explored = OneUpdate()
    explored.choose(0)
    assert explored.updates == 0
    explored.choose(4)
    assert (explored.state, explored.last.action, explored.last.how) == (4, Action.DOWN, "you chose it")
    explored.choose(5)
    explored.choose(6)
    assert (explored.state, explored.last.bumped) == (5, True)
    for far in (5, 0, 15):
        explored.choose(far)
        assert explored.updates == 3
        assert "Choose a cell beside the mouse, which is in cell 5" in explored.message


def test_a_walk_is_cut_off_as_in_training_and_that_is_no_end():
    explored = OneUpdate()
    for _ in range(MAX_STEPS - 1):
        explored.arrow(Action.UP)
    assert explored.episode == 1
    explored.q_table[0, 1] = 1.0
    explored.arrow(Action.UP)
    assert (explored.episode, explored.moves) == (2, 0)
    assert explored.last.target == pytest.approx(0.9), "cut off, not terminated"
    assert "Episode 1 was cut off after 1000 moves" in explored.message
    assert "cut off after 1000 moves, not terminated" in lines(explored)["s'"]


def test_the_panel_puts_the_numbers_into_the_formulas():
    explored = OneUpdate()
    explored.q_table[0], explored.q_table[4] = (0, 0.3, 0, 0), (0.1, 0.2, -0.4, 0.7)
    explored.arrow(Action.DOWN)
    told = lines(explored)
    assert told["s"] == "cell 0 (row 0, column 0)"
    assert told["a"] == "↓ down; you chose it"
    assert told["r"] == "0"
    assert told["s'"] == "cell 4 (row 1, column 0); the episode goes on"
    assert told["Q(s', ·)"] == "↑ 0.1, ↓ 0.2, ← −0.4, → 0.7; max = 0.7"
    assert told["target"] == "r + γ max Q(s', ·) = 0 + 0.9 · 0.7 = 0.63"
    assert told["error"] == "target − Q(s, a) = 0.63 − 0.3 = 0.33"
    assert told["Q(s, a)"] == "new: Q(s, a) + α · error = 0.3 + 0.1 · 0.33 = 0.333"
    assert "Q(0, down): 0.3 → 0.333" in explored.message
    words = numbers(explored).words
    assert all(text in words for text in told.values())
    explored.q_table[5, Action.RIGHT] = -0.5
    explored.choose(5)
    explored.arrow(Action.RIGHT)
    assert lines(explored)["r"] == "−1, a bump"
    assert lines(explored)["Q(s', ·)"].endswith("→ −0.5; max = 0"), "as it was before the update"
    assert lines(explored)["error"] == "target − Q(s, a) = −1 − (−0.5) = −0.5"
    assert lines(explored)["Q(s, a)"] == "new: Q(s, a) + α · error = −0.5 + 0.1 · (−0.5) = −0.55"


def test_the_board_shows_the_table_and_what_changed():
    explored = OneUpdate()
    assert "All of Q is 0" in board(explored).words
    assert "stroke-dasharray" not in board(explored).svg
    for _ in range(40):
        explored.press("episode")
    explored.choose(4)
    drawn, q = board(explored), explored.q_table
    acting = [s for s in range(16) if s not in (6, 10, 12, 15)]
    written = re.findall(r">(−?\d\.\d\d)<", drawn.svg)
    assert written == [minus(f"{q[s, a]:z.2f}") for s in acting for a in Action]
    framed = re.findall(r'<polygon points="([^"]*)"[^>]*stroke-dasharray="6 3"', drawn.svg)
    wedge = re.findall(r'<polygon points="([^"]*)"[^>]*data-cell="0"', drawn.svg)[Action.DOWN]
    assert framed == [wedge]
    assert "The dashed frame is around down in cell 0 (row 0, column 0)" in drawn.words
    assert "The mouse is in cell 4 (row 1, column 0)" in drawn.words
    told = drawn.words.split("not 0: ")[1]
    assert sum(len(part.split(",")) for part in told.split(";")) == (q != 0).sum()
    assert f"down {q[11, 1]:.2f}" in told


@pytest.mark.parametrize(("rows", "legible"), [(5, True), (6, False), (8, False)])
def test_numbers_too_small_to_read_are_left_out_of_the_picture(rows, legible):
    explored = OneUpdate(Maze.random(rows, rows, walls=0, **FREE))
    explored.arrow(Action.RIGHT)
    written = re.findall(r'font-size="([\d.]+)"[^>]*>−?\d\.\d\d<', board(explored).svg)
    assert len(written) == (4 * (rows * rows - 1) if legible else 0)
    assert all(float(size) >= 9 for size in written)


def test_the_first_picture_is_the_same_every_time_and_the_learners_maze_is_left_alone():
    maze = Maze(**FREE)
    maze.reset(seed=3)
    maze.step(Action.RIGHT)
    stills = {explore.one_update(each).still() for each in (None, None, maze)}
    assert len(stills) == 1
    explore.one_update(maze).do("press", "episode")
    assert maze.step(Action.RIGHT)[0] == 2


def test_what_there_is_not_is_refused_before_anything_changes():
    explored = OneUpdate()
    explored.press("ten")
    before = explored.view()
    for wrong in (
        lambda: explored.press("twenty"),
        lambda: explored.turn("slip", 0),
        lambda: explored.turn("alpha", 6),
        lambda: explored.turn("alpha", -1),
        lambda: explored.choose(16),
        lambda: explored.choose(-1),
        lambda: explored.arrow(4),
        lambda: OneUpdate("maze"),
        lambda: OneUpdate(seed=-1),
        lambda: OneUpdate(Maze.random(9, 2)),
    ):
        with pytest.raises(
            ValueError, match=r"there is no|at most 8 rows|must be|the buttons are|Maze is needed|not a valid"
        ):
            wrong()
    assert explored.view() == before
