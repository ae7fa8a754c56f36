"""What a trader is measured by, against numbers worked out by hand."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import FILLS, closes, often, positions_for, random_bars

from course_lib.market import (
    RubberBandMarket,
    account,
    buy_and_hold,
    flat,
    metrics,
    percentile,
    random_shifts,
    scoreboard,
    split,
)

pytestmark = pytest.mark.filterwarnings("ignore:split or crash")


def legs(positions):
    """Trades of positions read as a circle: the first follows on the last."""
    return np.abs(positions - np.roll(positions, 1, axis=-1)).sum(axis=-1)


def test_metrics_worked_out_by_hand():
    """Held from 100 to 110, 99 and 99: +10 %, -10 %, 0 %, after a fee of nothing; then flat."""
    result = metrics(account(closes([100, 110, 99, 99, 300]), [1, 1, 1, 0, 0], cost=0.0))
    assert result.total_return == pytest.approx(-0.01)
    assert result.sharpe == pytest.approx(0.0, abs=1e-12)
    assert result.max_drawdown == pytest.approx(0.1)
    assert (result.trades, result.exposure) == (2, 3 / 4)
    result = metrics(account(closes([100, 110, 121, 60.5, 121, 90.75]), [1, 1, -1, 1, 0, 0], cost=0.01))
    returns = np.array([1.1 * 0.99, 1.1, 1.5 * 0.99**2, 2.0 * 0.99**2, 0.99]) - 1
    assert result.total_return == pytest.approx(np.prod(1 + returns) - 1)
    spread = np.sqrt(np.mean((returns - returns.mean()) ** 2))
    assert result.sharpe == pytest.approx(np.sqrt(252) * returns.mean() / spread)
    assert result.max_drawdown == pytest.approx(0.01)
    assert (result.trades, result.exposure) == (6, 4 / 5)


def test_a_drawdown_is_measured_from_the_peak_before_it():
    money = [100, 50, 200, 120, 150, 80, 90]  # from 200 to 80; the fall from 100 to 50 is less of its peak
    result = metrics(account(closes(money), [1] * 7, cost=0.0))
    assert result.max_drawdown == pytest.approx(1 - 80 / 200)
    falling = metrics(account(closes([100, 90, 80]), [1, 1, 1], cost=0.0))
    assert falling.max_drawdown == pytest.approx(0.2), "the money one begins with is a peak"


def test_who_does_nothing_scores_nothing():
    result = metrics(account(random_bars(50), flat(random_bars(50))))
    assert [float(value) for value in vars(result).values()] == [0, 0, 0, 0, 0]


def test_a_steady_gain_has_no_spread_and_so_no_sharpe():
    assert metrics(account(closes(100 * 1.5 ** np.arange(5)), [1] * 5, cost=0.0)).sharpe == 0


def test_metrics_of_many_are_those_of_each():
    prices, positions = random_bars(80, seed=2), np.random.default_rng(0).integers(-1, 2, (4, 3, 80))
    together = metrics(account(prices, positions))
    for i, j in np.ndindex(4, 3):
        alone = vars(metrics(account(prices, positions[i, j])))
        assert {name: value[i, j] for name, value in vars(together).items()} == alone


def test_flat_and_buy_and_hold():
    part = split(random_bars(200)).test
    assert flat(part).tolist() == [0] * 40
    assert buy_and_hold(part).tolist() == [1] * 40
    assert flat(part).dtype == buy_and_hold(part).dtype == np.int8
    money = account(part, buy_and_hold(part), cost=0.0, fill="close").log_equity[-1]
    assert money == pytest.approx(np.log(part.close.iloc[-1] / part.close.iloc[0]))


@often
@given(positions=positions_for(30), seed=st.integers(0, 2**32))
def test_shifted_trades_are_as_many_and_as_long(positions, seed):
    shifted = random_shifts(positions, 20, seed=seed)
    assert shifted.shape == (20, 30)
    assert shifted.dtype == np.int8
    assert (np.sort(shifted) == np.sort(positions)).all(), "the exposure stays"
    assert (legs(shifted) == legs(positions)).all(), "so do the trades, read as a circle"
    circles = {np.roll(positions, k).tobytes() for k in range(1, 30)}
    assert {row.astype(positions.dtype).tobytes() for row in shifted} <= circles


def test_shifts_are_of_every_length_but_none_and_the_seeds_own():
    positions = np.zeros(10, int)
    positions[0] = 1
    shifts = random_shifts(positions, 2000, seed=3).argmax(axis=1)
    assert sorted(set(shifts)) == list(range(1, 10))
    assert np.bincount(shifts)[1:].min() > 150
    assert np.array_equal(random_shifts(positions, 50, seed=3), random_shifts(positions, 50, seed=3))
    assert not np.array_equal(random_shifts(positions, 50, seed=3), random_shifts(positions, 50, seed=4))
    assert np.array_equal(random_shifts(positions), random_shifts(positions, 200, seed=0))


def test_the_percentile_is_the_share_of_shifts_that_end_with_less():
    prices, positions = random_bars(120, seed=4), np.random.default_rng(5).integers(-1, 2, 120)
    for fill in FILLS:
        own = account(prices, positions, cost=0.002, fill=fill).log_equity[-1]
        others = account(prices, random_shifts(positions, 300, seed=7), cost=0.002, fill=fill).log_equity[:, -1]
        wanted = 100 * np.mean(others < own)
        assert 0 < wanted < 100
        assert percentile(prices, positions, number=300, seed=7, cost=0.002, fill=fill) == pytest.approx(wanted)


def test_the_percentile_of_perfect_bad_and_no_timing():
    prices = closes([100, 100, 110, 110, 110, 100, 100, 100, 100, 100])
    assert percentile(prices, [0, 1, 0, 0, 0, 0, 0, 0, 0, 0], cost=0.0) == 100
    assert percentile(prices, [0, 0, 0, 0, 1, 0, 0, 0, 0, 0], cost=0.0) == 0
    assert percentile(prices, flat(prices)) == 50, "equal ones count half"


def test_a_scoreboard_is_a_row_a_trader_and_the_median_of_its_agents():
    part = split(random_bars(300, seed=8)).test
    many = np.random.default_rng(1).integers(-1, 2, (5, 60))
    table = scoreboard(part, {"ours": many, "zero": flat(part), "hold": buy_and_hold(part)}, cost=0.001, fill="close")
    assert table.index.tolist() == ["ours", "zero", "hold"], "in the order given"
    assert table.columns.tolist() == ["return", "Sharpe", "drawdown", "legs", "exposure"]
    own = vars(metrics(account(part, many, cost=0.001, fill="close")))
    assert table.loc["ours"].tolist() == [np.median(value) for value in own.values()]
    hold = vars(metrics(account(part, buy_and_hold(part), cost=0.001, fill="close")))
    assert table.loc["hold"].tolist() == [float(value) for value in hold.values()]
    assert (table.loc["zero"] == 0).all()
    default = scoreboard(part, {"hold": buy_and_hold(part)})
    pd.testing.assert_frame_equal(default, scoreboard(part, {"hold": buy_and_hold(part)}, cost=0.0005, fill=None))


def test_a_scoreboard_charges_for_trades():
    part = split(RubberBandMarket().prices(500)).test
    busy = np.arange(len(part)) % 2
    free, dear = (scoreboard(part, {"busy": busy}, cost=cost).loc["busy", "return"] for cost in (0, 0.01))
    assert (1 + dear) / (1 + free) == pytest.approx(0.99 ** (len(part) - 2))


@pytest.mark.parametrize("fill", FILLS)
def test_the_yardsticks_of_a_part_know_nothing_of_the_bars_before_it(fill):
    prices = random_bars(200, seed=9)
    part, positions = split(prices).test, np.random.default_rng(2).integers(-1, 2, 40)
    alone = prices.iloc[160:]
    assert percentile(part, positions, fill=fill) == percentile(alone, positions, fill=fill)
    pd.testing.assert_frame_equal(
        scoreboard(part, {"one": positions}, fill=fill), scoreboard(alone, {"one": positions}, fill=fill)
    )
