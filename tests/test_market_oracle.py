"""Nobody beats the oracle, which is the best of all paths that there are."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import ENCODERS, FILLS, bars, closes, learned, often, random_bars, ruinous_bars, seldom, traded

from course_lib.market import RubberBandMarket, account, buy_and_hold, oracle, split

pytestmark = pytest.mark.filterwarnings("ignore:split or crash")
each_fill = pytest.mark.parametrize("fill", FILLS)
any_cost = st.sampled_from([0.0, 0.0005, 0.01, 0.2])
SIDES = [(-1, 1), (1, -1), (1,), (-1,)]


def wealth(prices, positions, cost, fill):
    return account(prices, positions, cost=cost, fill=fill).log_equity[..., -1]


@each_fill
@often
@given(prices=ruinous_bars(max_bars=8), cost=any_cost, sides=st.sampled_from(SIDES))
def test_it_is_the_best_of_all_paths(fill, prices, cost, sides):
    paths = np.array(list(itertools.product((0, *sides), repeat=len(prices) - 1)))
    paths = np.pad(paths, [(0, 0), (0, 1)])  # the last one counts for nothing
    positions = oracle(prices, cost=cost, fill=fill, sides=sides)
    assert set(positions) <= {0, *sides}
    assert wealth(prices, positions, cost, fill) == pytest.approx(wealth(prices, paths, cost, fill).max(), abs=1e-12)


def test_it_ends_in_ruin_where_that_pays_and_counts_nothing_after_it():
    """A share goes up a billionfold on a day, opens at a billionth, and is a fine one ever after: 1e9 * 1e-6 is 1000.

    The long that was held to that close is held to that open as well, and ruined there. What comes after would be more
    still, but not for who is ruined.
    """
    prices = bars([1, 1, 1, 1.5, 2.25], [1, 1e9, 1, 1.5, 2.25])
    assert wealth(prices, oracle(prices, cost=0.0, fill="next_open"), 0.0, "next_open") == pytest.approx(np.log(1e3))
    prices = bars([1, 1, 1, 50, 2500], [1, 1e9, 1, 50, 2500])
    assert wealth(prices, oracle(prices, cost=0.0, fill="next_open"), 0.0, "next_open") == pytest.approx(np.log(2500))


@each_fill
@often
@given(prices=ruinous_bars(min_bars=9, max_bars=40), cost=any_cost, seed=st.integers(0, 2**32))
def test_no_random_path_beats_it(fill, prices, cost, seed):
    paths = np.random.default_rng(seed).integers(-1, 2, (50, len(prices)))
    for sides in SIDES:
        best = wealth(prices, oracle(prices, cost=cost, fill=fill, sides=sides), cost, fill)
        allowed = np.where(np.isin(paths, sides), paths, 0)
        assert (wealth(prices, allowed, cost, fill) <= best + 1e-12).all()
        assert best >= 0, "there is always the way of doing nothing"
        if 1 in sides:
            assert wealth(prices, buy_and_hold(prices), cost, fill) <= best + 1e-12


@each_fill
@seldom
@given(seed=st.integers(0, 2**32), encoder=st.sampled_from(sorted(set(ENCODERS) - {"returns"})), cost=any_cost)
def test_no_learned_tables_beat_it(fill, seed, encoder, cost):
    """Not even on the very days from which they have learned by heart."""
    prices = random_bars(140, seed=seed)
    parts = split(prices, warmup=8)
    encoder = ENCODERS[encoder]().fit(parts.training.close)
    agents = learned(parts.training, encoder, cost=cost, fill=fill, passes=100)
    for part in parts:
        best = wealth(part, oracle(part, cost=cost, fill=fill), cost, fill)
        assert wealth(part, traded(agents, part, encoder), cost, fill) <= best + 1e-12


def test_what_is_learned_by_heart_comes_close_to_it():
    """So that the test above is one that could fail."""
    parts = split(random_bars(140, seed=1), warmup=8)
    encoder = ENCODERS["window"]().fit(parts.training.close)
    agents = learned(parts.training, encoder, passes=300)
    own, best = (
        wealth(parts.training, p, 0.0005, None)
        for p in (traded(agents, parts.training, encoder), oracle(parts.training))
    )
    assert 0.5 * best < own < best


@often
@given(prices=ruinous_bars(max_bars=30))
def test_without_cost_it_earns_every_move(prices):
    """A rise of r pays log(1 + r) to a long, a fall of r log(1 + r) to a short: log(after / before), or log(2 - it).

    A short that is rebalanced to -100 % gains the fall as a fraction of the price *before*: from 100 to 80, 20 %, where
    the way back up is 25 %. Since (2 - x) x <= 1, its log(2 - x) is at most |log x|, and so is the sum.
    """
    close = prices["close"].to_numpy()
    moves = close[1:] / close[:-1]
    earned = np.array([np.log(x) if x >= 1 else np.log(2 - x) for x in moves])
    best = wealth(prices, oracle(prices, cost=0.0, fill="close"), 0.0, "close")
    assert best == pytest.approx(earned.sum(), abs=1e-12)
    assert best <= np.abs(np.log(moves)).sum() + 1e-12


@each_fill
def test_where_moves_are_small_that_is_nearly_the_sum_of_their_sizes(fill):
    close = 100 * np.exp(np.cumsum(1e-4 * np.random.default_rng(0).standard_normal(500)))
    prices = bars(close, close)
    best = wealth(prices, oracle(prices, cost=0.0, fill=fill), 0.0, fill)
    moves = np.abs(np.diff(np.log(close)))
    assert best == pytest.approx(moves[1:].sum() if fill == "next_close" else moves.sum(), rel=1e-3)


def test_cost_makes_it_pass_over_small_moves():
    prices = closes([100, 100.5, 100.2, 100.7, 90, 110, 109.9, 110.3])
    assert oracle(prices, cost=0.01).tolist() == [0, 0, 0, -1, 1, 1, 1, 1]
    assert oracle(prices, cost=0.2).tolist() == [0] * 8
    assert oracle(prices, cost=0.0).tolist() == [1, -1, 1, -1, 1, -1, 1, 1]
    assert oracle(prices, cost=0.001, sides=(1,)).tolist() == [1, 0, 1, 0, 1, 1, 1, 1]
    assert oracle(prices, cost=0.001, sides=(-1,)).tolist() == [0, -1, 0, -1, 0, 0, 0, 0]


def test_of_a_part_it_knows_that_part_alone():
    prices = RubberBandMarket().prices(300, seed=4)
    part = split(prices).test
    assert np.array_equal(oracle(part, cost=0.001), oracle(prices.iloc[240:], cost=0.001))
    assert oracle(part).dtype == np.int8


def test_its_default_cost_and_fill_are_those_of_the_account():
    prices = random_bars(100, seed=3)
    best = account(prices, oracle(prices)).log_equity[-1]
    assert best == account(prices, oracle(prices, cost=0.0005, fill="next_open")).log_equity[-1]
    assert best > account(prices, oracle(prices, fill="close")).log_equity[-1]
