"""What lessons 1, 2 and 6 say of their explorers is what these show: every number of their answers."""

from math import comb

import numpy as np
import pytest

from course_lib import Action, DQNAgent, value_iteration
from course_lib.explore import BellmanByHand, Transitions
from course_lib.explore.dqn import InsideTheNetwork

from . import prose
from .test_by_hand import panel, pressed, turned

HOW_OFTEN = {8: "Eight", 3: "three", 1: "first", 2: "second", 6: "sixth"}


# --- lesson 1


def test_lesson_1_tells_of_ten_moves():
    said, state = prose("01_mdp.ipynb"), Transitions()
    for _ in range(10):
        state.press("1 move")
    chances = [comb(10, k) * state.chances[1] ** k * (1 - state.chances[1]) ** (10 - k) for k in range(11)]
    likeliest = int(np.argmax(chances))
    often = HOW_OFTEN[round(10 * chances[likeliest])]
    assert f"1. {HOW_OFTEN[likeliest]} is the likeliest, and comes in {often} of ten experiments; here it is" in said
    assert f"here it is {HOW_OFTEN[int(state.counts[1])].lower()}." in said
    assert chances[7] + chances[9] > 0.4, "seven or nine would be no surprise"


def test_lesson_1_tells_where_moves_lead():
    said, state = prose("01_mdp.ipynb"), Transitions()
    state.choose(5)
    evenly = next(slip for slip in state.view().control("slip").texts if turned(state, "slip", slip).chances[5] == 0.5)
    assert f"2. With slip {evenly}." in said
    turned(state, "slip", "0.2").choose(14)
    assert f"3. To cell 15 with {state.chances[15]:g}, and with {state.chances[14]:g} it stays" in said
    assert f"R(s, a) = {state.chances[15]:g} · 1 = {state.reward:g}" in said
    assert f"With slip 1 it would be {turned(state, 'slip', '1').reward:g}." in said


def test_lesson_1_tells_how_near_the_shares_come():
    said, state, roots = prose("01_mdp.ipynb"), Transitions(), []
    for moves in ("100 moves", "10,000 moves"):
        state.press(moves)
        roots.append(f"{state.tries**-0.5:.1g} after {state.tries:,}")
    assert f"1/√n, where n is the number of moves: {roots[0]} moves, {roots[1]}. Now and then" in said
    assert state.tries**-0.5 < state.gap < 1.05 * state.tries**-0.5
    assert f"at most {state.gap:.4f} away from T; 1/√n is {state.tries**-0.5:.4f}" in state.message
    below = 0
    for seed in range(20):
        state = Transitions(seed=seed)
        state.press("100 moves")
        below += state.gap < 0.1
    assert below > 17, "mostly"


# --- lesson 2


def test_lesson_2_tells_what_two_sweeps_write():
    said, state = prose("02_bellman.ipynb"), BellmanByHand()
    assert state.cell == 14
    first = state.equation.sum(), float(pressed(state, "sweep").values[14])
    second = state.equation.sum(), float(pressed(state, "sweep").values[14])
    told = [f"{how} = {value:.4g}" for how, value in (first, second)]
    assert "1. First {}. Then {}, since".format(*(each.replace("·(", " · (") for each in told)) in said
    assert f"which is worth {first[1]:g} by then" in said


def test_lesson_2_tells_of_improvements():
    said, state = prose("02_bellman.ipynb"), pressed(BellmanByHand(), "begin", "end")
    random = state.values[0]
    better = pressed(state, "improve", "end").values[0]
    assert f"worth {random:.4f} under the random policy, and {better:.4f} after one improvement." in said
    before = state.values
    pressed(state, "improve", "end")
    assert state.values == pytest.approx(before, abs=1e-12), "the second adds what is just as good"
    assert pressed(state, "improve").message.startswith("Nothing to improve"), "the third"
    state, sweeps = pressed(BellmanByHand(), "begin"), 0
    while not state.values[0]:
        pressed(state, "improve", "sweep")
        sweeps += 1
    assert f"3. In the {HOW_OFTEN[sweeps]} sweep." in said


def test_lesson_2_tells_what_a_mouse_does_that_is_paid_for_nonsense():
    said, state = prose("02_bellman.ipynb"), turned(BellmanByHand(), "at_once", "on")
    state.choose(9)
    assert "if entering cell 9 pays 0.1, each time? And if it pays 0.2?" in said
    way = turned(state, "reward", "0.1").way
    assert 9 in way
    assert way[-1] in state.world.goals
    assert turned(state, "reward", "0.2").way[-1] not in state.world.goals
    worth = state.values[state.world.cell_ahead(9, Action.LEFT)]
    assert f"0.2 / (1 − {state.gamma**2:g}) = {worth:.2f}, more than any way" in said


# --- lesson 6: what holds of its trained networks stands in test_training.py


def test_lesson_6_tells_what_the_untrained_network_says():
    said, state = prose("06_dqn.ipynb"), InsideTheNetwork()
    exact = value_iteration(state.maze.mdp, 0.95).values[0]
    before = f"it says {state.moment.q[0].max():.2f} of the start, which is worth {exact:.2f}"
    assert f"{before}, and its arrows earn nothing" in said
    assert state.moment.earned == 0
    assert DQNAgent(state.maze, seed=0).q_values([0]).max() == pytest.approx(state.moment.q[0].max(), abs=1e-6)
    assert "Put in a wall (6, 10 or 12) and the cheese (15)." in said
    for cell in (6, 10, 12, 15):
        state.choose(cell)
        assert "nobody ever acts" in state.message
        assert "silent in every cell" in panel(state, "network").words
