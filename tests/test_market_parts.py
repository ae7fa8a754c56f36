"""Parts of a history follow one another in time, and what is to be unseen stays unseen."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import ENCODERS, closes, often, random_bars

from course_lib.market import (
    MinMaxEncoder,
    Part,
    PriceDataError,
    ReturnsEncoder,
    SideEnv,
    SideVectorEnv,
    WindowEncoder,
    account,
    action_values,
    split,
    walk_forward,
)


def numbered(num_bars):
    """Closes that are the numbers of their bars, from 100 on."""
    return closes(np.arange(num_bars) + 100.0)


def own(part):
    """The numbers of a part's own bars."""
    return (part.close - 100).astype(int).tolist()


def test_a_split_is_sixty_twenty_twenty_by_time():
    parts = split(numbered(1000))
    assert own(parts.training) == list(range(60, 600))
    assert own(parts.validation) == list(range(600, 800))
    assert own(parts.test) == list(range(800, 1000))
    assert [part.name for part in parts] == ["training", "validation", "test"]
    assert list(parts) == [parts.training, parts.validation, parts.test]


@often
@given(
    num_bars=st.integers(40, 400),
    shares=st.tuples(st.integers(2, 9), st.integers(2, 9), st.integers(2, 9)).map(lambda s: [x / sum(s) for x in s]),
    warmup=st.integers(0, 3),
)
def test_parts_share_no_bar_and_leave_none_out(num_bars, shares, warmup):
    prices = numbered(num_bars)
    parts = split(prices, shares, warmup=warmup)
    assert [bar for part in parts for bar in own(part)] == list(range(warmup, num_bars))
    ends = [part.dates[-1] for part in parts]
    for share, part, end in zip(np.cumsum(shares), parts, ends, strict=True):
        assert abs(prices.index.get_loc(end) + 1 - share * num_bars) <= 0.5 + 1e-9
        assert len(part) == len(part.close) == len(part.dates)
        assert part.prices.index[0] == prices.index[0], "earlier bars may be looked at"
        assert part.prices.index[-1] == end, "later ones not"


def test_a_part_says_what_it_is():
    assert repr(split(numbered(1000)).test) == "<test: 200 bars, 2023-01-25 to 2023-10-31>"


def test_earlier_bars_are_looked_at_and_not_traded():
    prices = random_bars(300, seed=1)
    parts = split(prices, warmup=20)
    encoder = MinMaxEncoder(20).fit(parts.training.close)
    whole = encoder.transform(prices["close"])
    for part in parts:
        values = np.arange(60.0).reshape(20, 3)
        seen = action_values(values, part, encoder)[:, 0, 0] // 3
        assert seen.tolist() == whole[part.first : part.first + len(part)].tolist()
        env = SideEnv(part, encoder, side=1)
        dates = [env.reset(seed=0)[1]["date"]]
        while len(dates) < len(part):
            dates.append(env.step(0)[4]["date"])
        assert dates == list(part.dates)
        assert len(account(part, np.zeros(len(part), int)).rewards) == len(part) - 1


def test_the_first_bar_of_the_test_part_sees_the_end_of_validation():
    parts = split(random_bars(300, seed=1), warmup=3)
    encoder = WindowEncoder(3).fit(parts.training.close)
    env = SideEnv(parts.test, encoder, side=1)
    assert env.reset(seed=0)[0] == encoder.transform(parts.test.prices["close"].iloc[236:241])[-1] >= 0


def test_walking_forward_tests_on_the_bars_that_follow():
    prices = numbered(100)
    walks = walk_forward(prices, 30, 20, warmup=7)
    assert [own(training) for training, _ in walks] == [list(range(a, a + 30)) for a in (7, 27, 47)]
    assert [own(test) for _, test in walks] == [list(range(a, a + 20)) for a in (37, 57, 77)]
    for training, test in walks:
        assert (training.name, test.name) == ("training", "test")
        assert training.prices.index[0] == test.prices.index[0] == prices.index[0]
        assert training.prices.index[-1] == training.dates[-1] < test.dates[0]
        assert test.prices.index[-1] == test.dates[-1]
    assert [len(walk_forward(numbered(n), 30, 20, warmup=7)) for n in (57, 76, 77, 97)] == [1, 1, 2, 3]
    assert own(walk_forward(prices, 30, 10)[0][0]) == list(range(60, 90)), "60 bars are looked at first"


def test_walking_forward_needs_one_round():
    with pytest.raises(PriceDataError, match="57 rows of prices are needed, 56 are given"):
        walk_forward(numbered(56), 30, 20, warmup=7)


ALL_ENCODERS = pytest.mark.parametrize("kind", ENCODERS)


@ALL_ENCODERS
def test_an_encoder_that_knows_unseen_days_is_found_out(kind):
    """At every door: environment, vector of them, action values."""
    prices = random_bars(400, seed=2)
    parts, make = split(prices, warmup=10), ENCODERS[kind]
    close = prices["close"]
    fair, clever, all_knowing = (make().fit(known) for known in (parts.training.close, close[:241], close))
    for part in parts:
        part.check_fitted(fair)
        part.check_fitted(make())  # not fitted at all is another fault
    for encoder, part, words in (
        (clever, parts.training, "the training part ends on 2020-12-01"),
        (clever, parts.validation, "the validation part begins on 2020-12-02"),
        (all_knowing, parts.test, f"the test part begins on {parts.test.dates[0]:%Y-%m-%d}"),
        (all_knowing, parts.training, "fit it on the training part alone, fit(parts.training.close)"),
    ):
        for door in (
            lambda part, encoder: part.check_fitted(encoder),
            lambda part, encoder: SideEnv(part, encoder, side=1),
            lambda part, encoder: SideVectorEnv(part, encoder, side=1, num_envs=2),
            lambda part, encoder: action_values(np.zeros((2, 3)), part, encoder),
        ):
            with pytest.raises(PriceDataError) as error:
                door(part, encoder)
            assert words in str(error.value)
            assert type(encoder).__name__ in str(error.value)
    parts.validation.check_fitted(make().fit(close[:240]))  # the day before it begins


def test_who_was_fitted_on_numbers_without_dates_cannot_be_found_out():
    parts = split(random_bars(400, seed=2), warmup=10)
    encoder = ReturnsEncoder().fit(parts.test.prices["close"].to_numpy())
    assert encoder.fitted_until is None
    parts.test.check_fitted(encoder)


def test_an_encoder_fitted_again_is_judged_by_the_last_time():
    prices = random_bars(400, seed=2)
    parts = split(prices, warmup=10)
    encoder = WindowEncoder(3).fit(prices["close"])
    assert encoder.fitted_until == prices.index[-1]
    encoder.fit(parts.training.close)
    assert encoder.fitted_until == parts.training.dates[-1]
    parts.validation.check_fitted(encoder)


def test_a_part_of_ones_own_begins_where_one_says():
    part = Part("validation", numbered(20), 15)
    assert own(part) == [15, 16, 17, 18, 19]
    assert isinstance(part.close, pd.Series)
