"""The ways of making a state of a price, each against its definition worked out slowly, bar by bar."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import ENCODERS, MARKETS, often

from course_lib.market import (
    DayGridMarket,
    GridEncoder,
    LadderMarket,
    MinMaxEncoder,
    PriceDataError,
    RandomWalkMarket,
    ReturnsEncoder,
    WindowEncoder,
    real_prices,
    split,
)

few_prices = st.lists(st.integers(1, 5).map(float), min_size=1, max_size=40)  # many ties, and stretches that are flat
many_prices = st.lists(st.floats(1, 100).map(lambda x: round(x, 3)), min_size=1, max_size=40)
series = few_prices | many_prices
TRAINING = np.array([3.0, 4, 4, 5, 2, 2, 1, 3, 3, 3, 4, 5, 1, 2, 4, 3, 5, 4, 2, 1, 3])


# --- the definitions --------------------------------------------------------------------------------------------------


def window_by_the_book(close, k, flat):
    """The digits of the last k log returns as a number of base 3, -1 = down, 0 = flat, 1 = up, oldest first."""
    states = []
    for t in range(len(close)):
        if t < k:
            states.append(-1)
            continue
        state = 0
        for i in range(t - k + 1, t + 1):
            r = np.log(close[i]) - np.log(close[i - 1])
            digit = 0 if abs(r) <= flat * (1 + 1e-9) else (1 if r > 0 else -1)
            state = 3 * state + digit + 1
        states.append(state)
    return states


def level_by_the_book(price, low, high, levels):
    return levels // 2 if high == low else min(levels - 1, int(levels * (price - low) / (high - low)))


def turn_by_the_book(close, n):
    """Row: level of the newest of n closes between their low and high; column: bars since the opposite extreme."""
    states = []
    for t in range(len(close)):
        if t < n - 1:
            states.append(-1)
            continue
        window = list(close[t - n + 1 : t + 1])
        row = level_by_the_book(window[-1], min(window), max(window), n)
        extreme = min(window) if row >= n / 2 else max(window)
        states.append(row * n + next(ago for ago in range(n) if window[-1 - ago] == extreme))
    return states


def min_max_by_the_book(close, m, levels):
    states = []
    for t in range(len(close)):
        window = close[max(t - m + 1, 0) : t + 1]
        states.append(level_by_the_book(close[t], min(window), max(window), levels) if len(window) == m else -1)
    return states


@often
@given(close=series, k=st.integers(1, 5), flat=st.sampled_from([0, 0.1, 0.5, "third"]))
def test_a_window_is_a_number_of_base_three(close, k, flat):
    encoder = WindowEncoder(k, flat=flat).fit(TRAINING)
    sizes = sorted(abs(np.diff(np.log(TRAINING))))
    flat = np.quantile(sizes, 1 / 3) if flat == "third" else flat
    assert encoder.threshold == pytest.approx(flat)
    assert encoder.transform(close).tolist() == window_by_the_book(close, k, flat)


@often
@given(close=series, n=st.integers(2, 9))
def test_a_turn_is_a_level_and_the_bars_since_the_opposite_extreme(close, n):
    assert GridEncoder(n).fit(TRAINING).transform(close).tolist() == turn_by_the_book(close, n)


@often
@given(close=series, m=st.integers(2, 9), levels=st.integers(2, 12))
def test_min_max_is_a_level_between_the_low_and_the_high_of_so_many_bars(close, m, levels):
    encoder = MinMaxEncoder(m, levels=levels).fit(TRAINING)
    assert encoder.transform(close).tolist() == min_max_by_the_book(close, m, levels)


@often
@given(close=series, levels=st.integers(2, 12))
def test_min_max_of_training_is_a_level_between_its_low_and_its_high(close, levels):
    encoder = MinMaxEncoder(None, levels=levels).fit(TRAINING)
    by_the_book = [level_by_the_book(min(max(price, 1), 5), 1, 5, levels) for price in close]
    assert encoder.transform(close).tolist() == by_the_book


@often
@given(close=series, k=st.integers(1, 5), clip=st.sampled_from([0.5, 1.0, 5.0]))
def test_returns_are_the_last_k_over_the_spread_of_training(close, k, clip):
    training = TRAINING * 1.1 ** np.arange(len(TRAINING))  # it drifts, and the spread is that about the mean
    seen = ReturnsEncoder(k, clip=clip).fit(training).transform(close)
    sigma = np.std([np.log(b / a) for a, b in itertools.pairwise(training)])
    assert seen.shape == (len(close), k)
    assert seen.dtype == np.float32
    for t in range(len(close)):
        if t < k:
            assert np.isnan(seen[t]).all()
            continue
        wanted = [np.log(close[i] / close[i - 1]) / sigma for i in range(t - k + 1, t + 1)]
        assert seen[t] == pytest.approx(np.clip(wanted, -clip, clip), abs=1e-6)


def test_a_constant_price_is_flat_and_in_the_middle():
    flat = np.full(30, 7.0)
    assert set(WindowEncoder(3).fit(flat).transform(flat)) == {-1, 1 * 9 + 1 * 3 + 1}
    assert set(GridEncoder(4).fit(flat).transform(flat)) == {-1, 2 * 4}
    assert set(GridEncoder(5).fit(flat).transform(flat)) == {-1, 2 * 5}
    assert set(MinMaxEncoder(5, levels=10).fit(flat).transform(flat)) == {-1, 5}
    assert set(MinMaxEncoder(None, levels=10).fit(flat).transform(flat)) == {5}


def test_worked_out_by_hand():
    close = [10, 11, 11, 9, 12, 8]
    assert WindowEncoder(2, flat=0).fit(close).transform(close).tolist() == [
        -1,
        -1,
        2 * 3 + 1,
        1 * 3 + 0,
        0 * 3 + 2,
        2 * 3,
    ]
    # Windows of three: 10 11 11 is at the top, two bars after the low; 11 11 9 at the bottom, one bar after the high.
    assert GridEncoder(3).fit(close).transform(close).tolist() == [-1, -1, 2 * 3 + 2, 0 * 3 + 1, 2 * 3 + 1, 0 * 3 + 1]
    assert MinMaxEncoder(3, levels=4).fit(close).transform(close).tolist() == [-1, -1, 3, 0, 3, 0]


# --- days on a grid ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("warmup", [0, 1, 4, 60])
def test_a_day_on_the_grid_is_the_days_own_bar_and_row(warmup):
    """Also where training begins in the middle of a day, whose own first close is not known."""
    market = DayGridMarket()
    prices = market.prices(4000, seed=3)
    encoder = GridEncoder(9, mode="day").fit(split(prices, warmup=warmup).training.close)
    assert encoder.step == pytest.approx(0.005)
    log_price = np.log(prices["close"].to_numpy())
    for t, state in enumerate(encoder.transform(prices["close"])):
        row = 4 + round((log_price[t] - log_price[t - t % 9]) / 0.005)
        assert state == row * 9 + t % 9
    assert np.array_equal(encoder.transform(prices["close"]), market.knowledge(prices))


def test_days_without_dates_have_n_bars_each():
    prices = DayGridMarket().prices(4000, seed=3)["close"]
    encoder = GridEncoder(9, mode="day").fit(prices)
    assert np.array_equal(encoder.transform(prices.to_numpy()), encoder.transform(prices))
    assert np.array_equal(
        GridEncoder(9, mode="day").fit(prices.to_numpy()).transform(prices), encoder.transform(prices)
    )


def test_days_may_be_shorter_than_the_grid_and_deviations_larger_than_in_training():
    encoder = GridEncoder(5, mode="day").fit(np.exp([0, 0.01, -0.02, 0, 0.01, 0, 0, 0, 0, 0]))
    assert encoder.step == pytest.approx(0.01)
    days = DayGridMarket().prices(36)["close"]  # nine bars a day
    days = days.iloc[[t for t in range(36) if t % 9 < (3, 5, 4, 2)[t // 9]]]
    days[:] = np.exp([0, 0.011, -0.018, 5, 5.04, 4.9, 5.004, 5.006, 0, 0.02, 0.021, 0.024, 1, 1])
    rows = [2, 3, 0, 2, 4, 0, 2, 3, 2, 4, 4, 4, 2, 2]
    own_bars = [0, 1, 2, *range(5), *range(4), 0, 1]
    assert encoder.transform(days).tolist() == [row * 5 + bar for row, bar in zip(rows, own_bars, strict=True)]


def test_a_first_day_that_is_cut_off_teaches_nothing():
    """Its own first close is not known, and what it seems to deviate is more than any day does."""
    days = DayGridMarket().prices(27)["close"].iloc[6:]  # three bars of the first day
    days[:] = np.exp([0, 0.01, 0.08] + [0, 0.01, 0.02, 0.03, 0.04, 0.03, 0.02, 0.01, 0.0] * 2)
    encoder = GridEncoder(9, mode="day").fit(days)
    assert encoder.step == pytest.approx(0.01)
    assert (encoder.transform(days)[3:12] // 9).tolist() == [4, 5, 6, 7, 8, 7, 6, 5, 4]
    whole = GridEncoder(9, mode="day").fit(days[3:])
    assert whole.step == pytest.approx(0.01)
    only = GridEncoder(9, mode="day").fit(days[:3])
    assert only.step == pytest.approx(0.02), "where there is no other day it has to do"


def test_days_that_do_not_fit_or_are_one_bar_long_are_refused():
    prices = DayGridMarket().prices(90)["close"]
    with pytest.raises(PriceDataError, match="a day has 9 bars, more than 8: use n=9"):
        GridEncoder(8, mode="day").fit(prices)
    with pytest.raises(PriceDataError, match="no price moves within a day: is each bar a day"):
        GridEncoder(8, mode="day").fit(np.repeat([3.0, 4, 5], 8))


# --- what all have in common ------------------------------------------------------------------------------------------

each_encoder = pytest.mark.parametrize("kind", ENCODERS)


@each_encoder
def test_the_warmup_is_what_nothing_is_seen_in(kind):
    encoder, prices = ENCODERS[kind](), RandomWalkMarket().prices(300)["close"]
    assert encoder.fit(prices) is encoder
    seen = encoder.transform(prices)
    assert len(seen) == 300
    if encoder.num_states is None:
        assert np.isnan(seen[: encoder.warmup]).all()
        assert np.isfinite(seen[encoder.warmup :]).all()
    else:
        assert seen.dtype == np.int64
        assert (seen[: encoder.warmup] == -1).all()
        assert seen[encoder.warmup :].min() >= 0
        assert seen.max() < encoder.num_states


@each_encoder
def test_fewer_closes_than_the_warmup_are_nothing_to_be_seen(kind):
    encoder, prices = ENCODERS[kind]().fit(TRAINING), np.linspace(1, 5, 20)
    for length in range(1, encoder.warmup + 2):
        seen = encoder.transform(prices[:length])
        assert len(seen) == length
        assert (np.isnan(seen) | (seen == -1))[: encoder.warmup].all()
        if length > encoder.warmup:
            assert (seen[-1] == encoder.transform(prices)[encoder.warmup]).all()


@each_encoder
def test_series_arrays_and_lists_are_the_same(kind):
    prices = RandomWalkMarket().prices(90)["close"]
    wanted = ENCODERS[kind]().fit(prices).transform(prices)
    for form in (np.asarray, list, lambda s: s.reset_index(drop=True)):
        assert np.array_equal(ENCODERS[kind]().fit(form(prices)).transform(form(prices)), wanted, equal_nan=True)


SIZES = [
    (WindowEncoder, {}, 6561, 8),
    (WindowEncoder, {"k": 3}, 27, 3),
    (GridEncoder, {}, 64, 7),
    (GridEncoder, {"n": 9, "mode": "day"}, 81, 0),
    (MinMaxEncoder, {}, 10, 59),
    (MinMaxEncoder, {"m": None, "levels": 11}, 11, 0),
    (ReturnsEncoder, {}, None, 8),
]


@pytest.mark.parametrize(("kind", "given", "num_states", "warmup"), SIZES)
def test_sizes(kind, given, num_states, warmup):
    encoder = kind(**given)
    assert (encoder.num_states, encoder.warmup) == (num_states, warmup)


def test_every_state_can_be_put_into_words():
    for make in ENCODERS.values():
        encoder = make().fit(TRAINING)
        if encoder.num_states is not None:
            words = [encoder.describe(state) for state in range(encoder.num_states)]
            assert len(set(words)) == encoder.num_states
            with pytest.raises(ValueError, match="state must be from 0 to"):
                encoder.describe(encoder.num_states)


def test_words():
    window = WindowEncoder(3)
    assert window.describe(2 * 9 + 0 * 3 + 1) == "up, down, flat (the newest last)"
    assert window.digits(2 * 9 + 0 * 3 + 1).tolist() == [1, -1, 0]
    turn = GridEncoder(8)
    assert turn.describe(7 * 8 + 3) == "the price in row 7 of 8, counted from the lowest; 3 bars since the low"
    assert turn.describe(4 * 8).endswith("0 bars since the low")
    assert turn.describe(3 * 8 + 7).endswith("row 3 of 8, counted from the lowest; 7 bars since the high")
    day = GridEncoder(9, mode="day").describe(2 * 9 + 5)
    assert day == "bar 6 of the day, the price in row 2 of 9, counted from the lowest"
    level = "level 0 of 10 between the low and the high of "
    assert MinMaxEncoder().describe(0) == level + "the last 60 closes, counted from the low"
    assert MinMaxEncoder(None).describe(0) == level + "training, counted from the low"
    words = ReturnsEncoder(2).describe([0.51, -5.0, 1.0])
    assert words == "+0.5, -5.0 standard deviations (the newest last)", "the position is no return"


@pytest.mark.filterwarnings("ignore:split or crash")
@pytest.mark.parametrize("name", ["rubber band", "trend", "cycle", "random walk", "AAPL", "IBM", "MSFT", "GOOG"])
def test_a_third_of_the_moves_in_training_is_flat_and_the_others_are_up_as_often_as_down(name):
    prices = MARKETS[name].prices(5000, seed=2) if name in MARKETS else real_prices(name)
    close = split(prices).training.close
    states = WindowEncoder(1).fit(close).transform(close)[1:]
    shares = np.bincount(states, minlength=3) / len(states)
    assert shares[1] == pytest.approx(1 / 3, abs=1 / len(states))
    assert shares == pytest.approx([1 / 3] * 3, abs=0.03)


def test_moves_that_are_all_of_one_size_are_all_flat_whatever_rounding_says():
    """Otherwise their last digits would tell the rung: a state that knows what nobody can see."""
    prices = LadderMarket().prices(3000)["close"]
    assert set(WindowEncoder(3).fit(prices).transform(prices)[3:]) == {1 * 9 + 1 * 3 + 1}
    assert len(set(WindowEncoder(3, flat=0).fit(prices).transform(prices)[3:])) == 8
