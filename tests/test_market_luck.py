"""Traders that toss a coin: the compiled walk pays what stepping the environment pays."""

import numpy as np
import pandas as pd
import pytest

from course_lib.market import RandomWalkMarket, SideEnv, WindowEncoder, coin_tossers, oracle, split
from course_lib.market.accounting import RUIN
from course_lib.market.luck import _walk


def side_of(prices, side=1, **settings):
    parts = split(prices)
    return SideEnv(parts.test, WindowEncoder(3).fit(parts.training.close), side=side, **settings)


def stepped(env, number, seed):
    """The same coins tossed by stepping the environment, whose episodes all begin on its first bar."""
    rng, made = np.random.default_rng(seed), []
    for _ in range(number):
        rng.random()  # the start, of which there is one
        _, info = env.reset()
        over = False
        while not over:
            action = np.flatnonzero(info["action_mask"])[int(rng.random() * 2)]
            _, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
        made.append(info["log_equity"])
    return made


@pytest.mark.parametrize("side", [1, -1])
def test_it_is_the_environment_stepped_to_the_last_bit(side):
    env = side_of(RandomWalkMarket().prices(600), side, cost=0.001)
    assert coin_tossers(env, 20, seed=3).tolist() == stepped(env, 20, 3)


def test_compiled_it_is_the_same_loop_wherever_it_begins():
    tape = side_of(RandomWalkMarket().prices(2000), episode_length=40).tape
    plain, env = np.empty(300), side_of(RandomWalkMarket().prices(2000), episode_length=40)
    rng = np.random.default_rng(5)
    _walk(tape.gains.reshape(-1), tape.starts, tape.length, np.log(RUIN), rng, plain)
    made = coin_tossers(env, 300, seed=5)
    assert made.tolist() == plain.tolist()
    assert len(set(made)) > 290


@pytest.mark.filterwarnings("ignore:split or crash")
def test_ruin_ends_it():
    close = np.tile([100.0, 101.0], 300)
    close[540::2] = 250.0  # a short loses more than all
    prices = pd.DataFrame({"close": close}, index=pd.bdate_range("2000-01-03", periods=600))
    made = coin_tossers(side_of(prices, -1, cost=0), 200)
    ruined = made < np.log(RUIN) / 2
    assert 100 < ruined.sum() <= 200
    assert made.min() > 2 * np.log(RUIN)


def test_nobody_beats_the_oracle_and_costs_are_what_separates_them_from_zero():
    prices = RandomWalkMarket().prices(5000)
    part = split(prices).test
    env, free = side_of(prices, cost=0.001), side_of(prices, cost=0)
    made = coin_tossers(env, 5000)
    best = oracle(part, cost=0.001, sides=(1,))
    assert (
        made.max()
        < np.log1p(-0.001) * np.abs(np.diff(best, prepend=0)).sum() + np.abs(np.diff(np.log(part.close))).sum()
    )
    legs = len(part) / 2
    assert np.mean(coin_tossers(free, 5000) - made) == pytest.approx(-legs * np.log1p(-0.001), rel=0.01)


def test_bad_numbers():
    env = side_of(RandomWalkMarket().prices(600))
    for bad in (0, -1, 1.5, "many", None):
        with pytest.raises(ValueError, match="number must be"):
            coin_tossers(env, bad)
    with pytest.raises(ValueError, match="seed must be"):
        coin_tossers(env, 5, seed=-1)
