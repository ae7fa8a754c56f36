"""What happens to money: one accounting, the same as counting it in cash, shares and fees."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import FILLS, bars, closes, money_by_hand, often, positions_for, random_bars, ruinous_bars

from course_lib.market import PriceDataError, account, log_growth, split

pytestmark = pytest.mark.filterwarnings("ignore:split or crash")
each_fill = pytest.mark.parametrize("fill", FILLS)
costs = st.sampled_from([0.0, 0.0005, 0.01, 0.2])


@each_fill
@often
@given(data=st.data(), prices=ruinous_bars(), cost=costs)
def test_an_account_is_what_cash_shares_and_fees_come_to(fill, data, prices, cost):
    positions = data.draw(positions_for(len(prices)))
    result = account(prices, positions, cost=cost, fill=fill)
    money, legs, ruined = money_by_hand(prices, positions, cost, fill)
    assert np.exp(result.log_equity) == pytest.approx(money, rel=1e-9)
    assert (result.trades, result.ruined) == (legs, ruined)


@each_fill
@often
@given(data=st.data(), prices=ruinous_bars(), cost=costs)
def test_rewards_add_up_to_the_log_of_the_money(fill, data, prices, cost):
    result = account(prices, data.draw(positions_for(len(prices))), cost=cost, fill=fill)
    assert result.log_equity[0] == 0
    assert np.diff(result.log_equity) == pytest.approx(result.rewards, abs=1e-12)
    assert result.rewards.sum() == pytest.approx(result.log_equity[-1], abs=1e-12)


@each_fill
@often
@given(data=st.data(), prices=ruinous_bars(), cost=st.floats(0, 0.2), more=st.floats(0, 0.2))
def test_more_cost_never_makes_anybody_richer(fill, data, prices, cost, more):
    positions = data.draw(positions_for(len(prices)))
    cheap, dear = (account(prices, positions, cost=c, fill=fill).log_equity for c in sorted((cost, more)))
    assert (dear <= cheap + 1e-12).all()


@each_fill
def test_more_cost_makes_a_trader_poorer_by_so_many_legs(fill):
    prices, positions = random_bars(40, seed=3), np.random.default_rng(0).integers(-1, 2, 40)
    free, dear = (account(prices, positions, cost=cost, fill=fill) for cost in (0, 0.01))
    legs = np.abs(np.diff(np.concatenate([[0], positions[:-1]]))).sum()
    assert free.trades == dear.trades == legs > 10
    assert dear.log_equity[-1] - free.log_equity[-1] == pytest.approx(legs * np.log(0.99), abs=1e-12)


# Worked by hand. Closes 100, 110, 99; opens 100, 104, 108.
BY_HAND = [
    # A long of one bar and a short of the next.
    ("close", [1, -1, 0], [110 / 100 * 0.9, 0.9**2 * (2 - 99 / 110)], 3),
    ("next_open", [1, -1, 0], [0.9 * 110 / 104, 108 / 110 * 0.9**2 * (2 - 99 / 108)], 3),
    ("next_close", [1, -1, 0], [0.9, 99 / 110 * 0.9**2], 3),
    # Held for both bars: the short is rebalanced at the close between them, the long need not be.
    ("close", [1, 1, 1], [0.9 * 110 / 100, 99 / 110], 1),
    ("close", [-1, -1, -1], [0.9 * (2 - 110 / 100), 2 - 99 / 110], 1),
    ("next_open", [-1, -1, -1], [0.9 * (2 - 110 / 104), 2 - 99 / 110], 1),
    ("next_close", [-1, -1, -1], [0.9, 2 - 99 / 110], 1),
    # Out at once, and in on the last bar, where there is nothing left to earn.
    ("close", [1, 0, 1], [0.9 * 110 / 100, 0.9], 2),
    ("next_open", [1, 0, 1], [0.9 * 110 / 104, 108 / 110 * 0.9], 2),
    ("next_close", [1, 0, 1], [0.9, 99 / 110 * 0.9], 2),
    ("close", [0, 0, 1], [1, 1], 0),
]


@pytest.mark.parametrize(("fill", "positions", "factors", "trades"), BY_HAND)
def test_money_worked_out_by_hand(fill, positions, factors, trades):
    result = account(bars([100, 104, 108], [100, 110, 99]), positions, cost=0.1, fill=fill)
    assert np.exp(result.rewards) == pytest.approx(factors, rel=1e-12)
    assert np.exp(result.log_equity) == pytest.approx([1, factors[0], factors[0] * factors[1]], rel=1e-12)
    assert result.trades == trades
    assert not result.ruined
    assert result.positions.tolist() == [positions[0], positions[1], positions[1]], "the last one never begins"


@pytest.mark.parametrize("factor", [2.0, 2.5, 10.0])
def test_a_short_is_ruined_when_the_price_doubles_in_one_bar(factor):
    prices = closes([100, 100, 100 * factor, 50 * factor, 100])
    result = account(prices, [0, -1, 1, 1, 1], cost=0.0)
    assert result.ruined
    assert np.exp(result.log_equity) == pytest.approx([1, 1, 1e-6, 1e-6, 1e-6], rel=1e-12)
    assert result.positions.tolist() == [0, -1, 0, 0, 0], "trading ends"
    assert result.trades == 1
    assert result.rewards.tolist() == [0, np.log(1e-6), 0, 0]


def test_a_short_that_loses_nearly_all_lives_on_and_the_long_of_a_worthless_share_does_not():
    nearly = account(closes([100, 199.9, 100]), [-1, -1, 0], cost=0.0)
    assert not nearly.ruined
    assert nearly.log_equity[-1] == pytest.approx(np.log(1e-3) + np.log(2 - 100 / 199.9), rel=1e-9)
    worthless = account(closes([100, 1e-5, 100]), [1, 1, 0], cost=0.0)
    assert worthless.ruined
    assert worthless.log_equity.tolist() == [0, np.log(1e-6), np.log(1e-6)]


def test_ruin_before_or_after_the_open_is_ruin_whatever_the_other_half_of_the_bar_brings():
    prices = bars([100, 250, 100], [100, 100, 100])
    for then in (0, 1):
        result = account(prices, [-1, then, then], cost=0.0, fill="next_open")
        assert not result.ruined, "entered at 250, closed at 100"
    prices = bars([100, 100, 250, 30], [100, 100, 600, 20])
    for then in (0, 1):
        result = account(prices, [-1, then, then, then], cost=0.0, fill="next_open")
        assert result.ruined
        assert result.log_equity[-1] == np.log(1e-6)
    assert account(prices, [-1, -1, 0, 0], cost=0.0, fill="next_open").ruined
    held = account(bars([100, 100, 250], [100, 100, 120]), [-1, -1, 0], cost=0.0, fill="next_open")
    assert np.exp(held.log_equity[-1]) == pytest.approx(0.8), "who does not trade at the open is not asked there"
    prices = bars([1, 1, 1e9], [1, 1, 1e9 * (2 - 1e-7)])  # a long gains a billionfold, the short after it loses all
    assert account(prices, [1, -1, 0], cost=0.0, fill="next_open").log_equity[-1] == np.log(1e-6)


@each_fill
def test_agents_side_by_side_are_each_accounted_for_alone(fill):
    rng, close = np.random.default_rng(2), random_bars(30)["close"].to_numpy().copy()
    close[15:] *= 2.5  # who is short then is ruined
    prices, positions = bars(close, close), rng.integers(-1, 2, (2, 5, 30))
    together = account(prices, positions, fill=fill)
    assert together.ruined.any()
    assert not together.ruined.all()
    for i, j in np.ndindex(2, 5):
        alone = account(prices, positions[i, j], fill=fill)
        for name, array in vars(alone).items():
            assert np.array_equal(getattr(together, name)[i, j], array), name
    assert together.positions.dtype == np.int8
    assert together.log_equity.shape == (2, 5, 30)


@each_fill
def test_growth_looked_up_is_the_account(fill):
    prices, positions = random_bars(50, seed=5), np.random.default_rng(3).integers(-1, 2, 50)
    growth = log_growth(prices, 0.003, fill)
    assert growth.shape == (49, 3, 3)
    before = np.concatenate([[0], positions[:-2]])
    looked_up = [growth[t, before[t] + 1, positions[t] + 1] for t in range(49)]
    assert account(prices, positions, cost=0.003, fill=fill).rewards.tolist() == looked_up
    assert account(prices, positions, growth=growth).rewards.tolist() == looked_up


def test_of_a_part_only_its_own_bars_count():
    prices = random_bars(200, seed=6)
    part = split(prices, warmup=10).validation
    assert np.array_equal(log_growth(part), log_growth(prices.iloc[120:160]))
    positions = np.random.default_rng(4).integers(-1, 2, 40)
    assert np.array_equal(account(part, positions).rewards, account(prices.iloc[120:160], positions).rewards)


def test_decisions_are_filled_at_the_next_open_where_there_is_one_at_five_basis_points():
    prices = random_bars(30, seed=7)
    for frame, fill in ((prices, "next_open"), (prices[["close"]], "close"), (prices[["close", "volume"]], "close")):
        assert np.array_equal(log_growth(frame), log_growth(frame, 0.0005, fill))
        held = np.ones(30, int)
        assert np.array_equal(account(frame, held).rewards, account(frame, held, cost=0.0005, fill=fill).rewards)
    assert not np.array_equal(log_growth(prices), log_growth(prices, 0.0005, "close"))


def test_growth_of_other_bars_is_refused():
    prices = random_bars(30)
    with pytest.raises(PriceDataError, match=r"\[29, 3, 3\], got \[28, 3, 3\]"):
        account(prices, np.zeros(30, int), growth=log_growth(prices.iloc[1:]))
