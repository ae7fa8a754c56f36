"""Numbers are written alike everywhere, with a true minus sign: in pictures, in words, in tables, in messages."""

import re

import pytest

from course_lib import Maze, market
from course_lib.explore import BellmanByHand, BlindMaze, InsideTheNetwork, OneUpdate, QLearning, Transitions
from course_lib.explore.drawing.chart import Chart
from course_lib.explore.floor import _percent, amount
from course_lib.explore.market import TradingFloor
from course_lib.explore.numerals import numeral, power_of_ten, scientific, short, signed, two_places

COSTLY = Maze(wall_reward=-2.0, step_reward=-0.5, goal_reward=3.0, wall_ends_episode=False)


def pressed(state, *names):
    for name in names:
        state.press(name)
    return state


def a_floor():
    part = market.split(market.RandomWalkMarket().prices(900, seed=0)).test
    return TradingFloor(part, {"turns": [1, -1] * (len(part) // 2)}, cost=0.01)


def a_landing():
    state = Transitions(COSTLY)
    state.press("100 moves")
    return state


WALK = ("down", "right", "right", "up", "right", "right", "down", "down", "down", "right")  # with a bump, to the cheese
STATES = {
    "mouse": lambda: pressed(BlindMaze(COSTLY), *WALK),
    "transitions": a_landing,
    "by hand": lambda: pressed(BellmanByHand(COSTLY), "sweep", "sweep"),
    "one update": lambda: pressed(OneUpdate(COSTLY), "episode", "step"),
    "hundred agents": lambda: QLearning(COSTLY, ([-9.0, -2.5], [20, 9])),
    "network": lambda: InsideTheNetwork(COSTLY),
    "floor": a_floor,
}


@pytest.mark.parametrize("name", STATES)
def test_every_negative_number_has_a_true_minus_sign(name):
    state = STATES[name]()
    if name == "hundred agents":
        state.turn("curve", 1)
    view = state.view()
    written = [view.message]
    for panel in view.panels:
        written += [panel.words, *re.findall(r">([^<]+)<", panel.svg + panel.html)]
    assert not [text for text in written if re.search(r"(?<![\w-])-[\d.]", text)]
    assert any(re.search(r"−\d", text) for text in written), "some are negative"


def test_numbers_are_written_as_asked_for():
    assert (numeral(-0.5), numeral(-1234.5, ",.1f"), numeral(0.1), numeral(1.0)) == ("−0.5", "−1,234.5", "0.1", "1")
    assert (signed(-3), signed(1.0), two_places(-0.25), two_places(-0.001)) == ("−3", "+1", "−0.25", "0.00")
    assert (short(-0.12345), short(-1234.5), short(-0.0004)) == ("−0.123", "−1,234", "0")


def test_very_large_and_small_numbers_have_a_power_of_ten():
    assert (power_of_ten(-12), scientific(7.23e10), scientific(-4e9, "+.0e")) == ("10⁻¹²", "7.2×10¹⁰", "−4×10⁹")
    money = {0.998: "0.998", 6.4217: "6.42", 1570.2: "1,570", 38_712_345: "38,700,000", 7.23e10: "7.2×10¹⁰"}
    money |= {0.0: "0", 0.00123: "0.00123", 2.5e-7: "2.5×10⁻⁷"}
    assert {number: amount(number) for number in money} == money
    shares = {
        0.0371: "+3.7 %",
        -0.29: "−29 %",
        1570.2: "+157,000 %",
        4.1e7: "+4×10⁹ %",
        -0.9999: "−100 %",
        0.0: "+0.0 %",
    }
    assert {share: _percent(share, "+") for share in shares} == shares


def test_axes_have_a_true_minus_sign_as_well():
    drawn = Chart("", x=(-2, 2), y=(-2000, 2000), xlabel="", ylabel="").svg()
    assert {"−2", "−2,000"} <= set(re.findall(r">([^<]*)</text>", drawn))
