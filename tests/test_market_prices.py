"""Prices that are good come through unchanged, real ones adjusted, a learner's own by their names."""

import warnings

import numpy as np
import pandas as pd
import pytest
from market_worlds import FILLS, MARKETS, bars, closes, random_bars

from course_lib.market import (
    PriceDataError,
    SideEnv,
    WindowEncoder,
    account,
    buy_and_hold,
    check_prices,
    oracle,
    real_prices,
    split,
)

SHARES = {"AAPL": (3270, 2000), "GOOG": (2148, 2004), "IBM": (3270, 2000), "MSFT": (3270, 2000)}
each_share = pytest.mark.parametrize("symbol", SHARES)


def warned_of(call):
    """What comes of a call, and what it warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = call()
    return result, [str(warning.message) for warning in caught]


@pytest.fixture(scope="module")
def shares():
    """The four frames, each with what was warned of."""
    return {symbol: warned_of(lambda symbol=symbol: real_prices(symbol)) for symbol in SHARES}


# --- real shares ------------------------------------------------------------------------------------------------------


@each_share
def test_real_prices_can_be_traded(shares, symbol):
    prices, _ = shares[symbol]
    rows, year = SHARES[symbol]
    assert len(prices) == rows
    assert (prices.index[0].year, prices.index[-1].strftime("%Y-%m-%d")) == (year, "2013-03-01")
    assert prices.columns.tolist() == ["open", "high", "low", "close", "volume"]
    assert prices.index.name == "date"
    assert warned_of(lambda: check_prices(prices))[0] is prices


@each_share
def test_real_prices_are_adjusted_by_one_factor_a_day(shares, symbol):
    from bokeh_sampledata import stocks

    prices, raw = shares[symbol][0], pd.DataFrame(getattr(stocks, symbol))
    assert prices["close"].to_numpy() == pytest.approx(raw["adj_close"].to_numpy(), rel=1e-12)
    assert prices["volume"].tolist() == raw["volume"].tolist()
    for column in ("open", "high", "low"):
        assert (prices[column] / prices["close"]).to_numpy() == pytest.approx(
            (raw[column] / raw["close"]).to_numpy(), rel=1e-12
        ), column


SPLITS = [("AAPL", "2000-06-21"), ("AAPL", "2005-02-28"), ("MSFT", "2003-02-18")]


@pytest.mark.parametrize(("symbol", "date"), SPLITS)
def test_a_split_moves_nothing(shares, symbol, date):
    from bokeh_sampledata import stocks

    raw = pd.DataFrame(getattr(stocks, symbol)).set_index("date")["close"].to_numpy()
    prices = shares[symbol][0]["close"]
    place = prices.index.get_loc(pd.Timestamp(date))
    assert 0.4 < raw[place] / raw[place - 1] < 0.6, "where two shares are made of one, each is worth half"
    assert 0.9 < prices.iloc[place] / prices.iloc[place - 1] < 1.1


def test_the_crash_that_was_one_is_kept_and_warned_of(shares):
    prices, told = shares["AAPL"]
    assert told == ["split or crash? On 2000-09-29 the close went to 48% of the one before"]
    assert prices["close"].pct_change()[pd.Timestamp("2000-09-29")] == pytest.approx(-0.52, abs=0.005)
    assert [symbol for symbol in SHARES if shares[symbol][1]] == ["AAPL"]


@pytest.mark.filterwarnings("ignore:split or crash")
@each_share
def test_the_accounts_of_real_shares_add_up(shares, symbol):
    """What can be said of them. Profit is nothing to be asserted."""
    parts = split(shares[symbol][0])
    for part in parts:
        for fill in FILLS:
            best = account(part, oracle(part, fill=fill), fill=fill)
            hold = account(part, buy_and_hold(part), fill=fill)
            assert best.log_equity[-1] > max(hold.log_equity[-1], 0)
            assert best.rewards.sum() == pytest.approx(best.log_equity[-1], abs=1e-12)
            entry = {"close": part.close.iloc[0], "next_close": part.close.iloc[1]}.get(fill)
            entry = part.prices["open"].iloc[part.first + 1] if entry is None else entry
            grown = np.log(part.close.iloc[-1] / entry) + np.log(0.9995)
            assert hold.log_equity[-1] == pytest.approx(grown, abs=1e-9)


# --- any prices -------------------------------------------------------------------------------------------------------


def untouched(prices):
    """What a frame is, to be compared with what it is later."""
    return prices.copy(deep=True), [*prices.columns], prices.index.name, [*map(str, prices.dtypes)]


GOOD = {
    **{name: lambda market=market: market.prices(300, seed=1) for name, market in MARKETS.items()},
    "all columns": lambda: random_bars(50),
    "columns in another order, and more of them": lambda: random_bars(50)[
        ["volume", "close", "low", "high", "open"]
    ].assign(sector="steel"),
    "whole numbers": lambda: bars([100] * 5, [100] * 5).round().astype(int).assign(high=101, low=99),
    "32 bits": lambda: random_bars(50).astype(np.float32),
    "numbers that could be missing": lambda: random_bars(50).convert_dtypes(),
    "close and volume": lambda: random_bars(50)[["close", "volume"]],
    "a day without trade": lambda: random_bars(50).assign(volume=0),
    "two rows": lambda: closes([1, 1]),
    "hours": lambda: closes([1, 2, 3]).set_axis(pd.date_range("2024-03-15 09:00", periods=3, freq="h")),
    "a time zone": lambda: closes([1, 1]).tz_localize("Europe/Vienna"),
    "high and low that rounding has moved": lambda: random_bars(50).assign(
        high=lambda f: f[["open", "close"]].max(axis=1) * (1 - 1e-15), low=lambda f: f[["open", "close"]].min(axis=1)
    ),
    "a fall just under the limit": lambda: closes([100, 100 * np.exp(-0.3999), 100 * np.exp(-0.0001)]),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", [kind for kind in GOOD if kind != "hours"])
def test_good_prices_pass_as_they_are(kind):
    prices = GOOD[kind]()
    before, *names = untouched(prices)
    assert check_prices(prices) is prices
    pd.testing.assert_frame_equal(prices, before)
    assert untouched(prices)[1:] == tuple(names)


@pytest.mark.parametrize("kind", [kind for kind in GOOD if len(GOOD[kind]()) >= 50])
def test_good_prices_can_be_traded(kind):
    prices = GOOD[kind]()
    before, *_ = untouched(prices)
    encoder = WindowEncoder(2).fit(prices["close"])
    env = SideEnv(prices, encoder, side=1)
    env.reset(seed=0)
    rewards = [env.step(1 if bar == 0 else 0)[1] for bar in range(len(prices) - 3)]
    positions = np.ones(len(prices) - 2, int)
    assert np.isfinite(rewards).all()
    assert sum(rewards) == pytest.approx(account(prices.iloc[2:], positions).log_equity[-1], abs=1e-12)
    pd.testing.assert_frame_equal(prices, before)


MOVES = [  # closes, and what is said of them
    ([100, 67.1, 100], None),
    ([100, 67.0, 67], "On 2020-01-02 the close went to 67% of the one before"),
    ([100, 100, 149], None),
    ([100, 100, 150], "On 2020-01-03 the close went to 150% of the one before"),
    ([100, 50, 50, 100, 30], "On 2020-01-02 the close went to 50% of the one before (and 2 more)"),
]


@pytest.mark.parametrize(("values", "words"), MOVES)
def test_a_large_move_is_warned_of_and_kept(values, words):
    prices, told = warned_of(lambda: check_prices(closes(values)))
    assert prices["close"].tolist() == values
    assert told == ([f"split or crash? {words}"] if words else [])


def test_a_learner_is_warned_once_and_not_at_every_call():
    prices = closes([100, 50, 50, 50, 50])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for _ in range(3):
            check_prices(prices)
            account(prices, [0, 0, 0, 0, 0])
    assert len(caught) == 1


def test_rows_that_are_needed():
    assert len(check_prices(closes([1, 1, 1]), at_least=3)) == 3
    with pytest.raises(PriceDataError, match="4 rows of prices are needed, 3 are given"):
        check_prices(closes([1, 1, 1]), at_least=4)
