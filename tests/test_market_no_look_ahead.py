"""Whatever comes after a bar, nothing at that bar or before it is any different."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import ENCODERS, FILLS, MARKETS, random_bars, seldom, traded

from course_lib import DQNAgent
from course_lib.market import (
    Part,
    PriceDataError,
    SideEnv,
    SideVectorEnv,
    account,
    action_values,
    optimum,
    split,
    trade,
)

pytestmark = pytest.mark.filterwarnings("ignore:split or crash")
each_encoder = pytest.mark.parametrize("kind", ENCODERS)
seeds = st.integers(0, 2**32)


def with_another_future(prices, t, seed):
    """The same prices up to bar t, and anything at all after it: opens, highs and lows included."""
    rng, changed = np.random.default_rng(seed), prices.copy()
    after = prices.index > prices.index[t]
    factor = np.exp(rng.normal(0, rng.choice([0.001, 0.1, 2.0]), size=(after.sum(), 1)))
    columns = [column for column in prices if column != "volume"]
    changed.loc[after, columns] = changed.loc[after, columns] * factor
    if "volume" in prices:
        changed.loc[after, "volume"] = rng.integers(1, 1000, after.sum()).astype(float)
    return changed


def dated_like_days(prices):
    """Nine bars a day, for the grid of a day."""
    days = MARKETS["day grid"].prices(len(prices)).index
    return prices.set_axis(days)


@each_encoder
@seldom
@given(seed=seeds, t=st.integers(0, 79), ties=st.booleans())
def test_a_state_depends_on_no_later_close(kind, seed, t, ties):
    training = random_bars(80, seed=1)["close"]
    prices = random_bars(80, seed=seed % 1000)[["close"]]
    if ties:
        prices["close"] = prices["close"].round()
    if kind == "grid, day":
        prices = dated_like_days(prices)
    encoder = ENCODERS[kind]().fit(training)
    seen = encoder.transform(prices["close"])
    other = encoder.transform(with_another_future(prices, t, seed)["close"])
    cut = encoder.transform(prices["close"].iloc[: t + 1])
    assert np.array_equal(seen[: t + 1], other[: t + 1], equal_nan=True)
    assert np.array_equal(seen[: t + 1], cut, equal_nan=True)


@each_encoder
def test_that_another_future_is_seen_when_it_has_come(kind):
    """So that the test above is one that could fail."""
    prices = random_bars(80, seed=2)
    encoder = ENCODERS[kind]().fit(random_bars(80, seed=1)["close"])
    differs = [
        not np.array_equal(
            encoder.transform(prices["close"])[41:], encoder.transform(with_another_future(prices, 40, s)["close"])[41:]
        )
        for s in range(10)
    ]
    assert sum(differs) > 5


def test_what_is_fitted_depends_on_the_training_part_alone():
    prices = random_bars(300, seed=3)
    first, second = (split(p, warmup=10) for p in (prices, with_another_future(prices, 179, 5)))
    for make in ENCODERS.values():
        one, two = make().fit(first.training.close), make().fit(second.training.close)
        assert vars(one) == vars(two)
        assert one.fitted_until == prices.index[179]


def walks(part, encoder, side, fill, agent):
    """What happens to a fixed table or network that acts greedily, bar by bar, from the part's first bar on."""
    env = SideEnv(part, encoder, side=side, fill=fill, cost=0.002)
    seen, info = env.reset(seed=0)
    record = [(seen, 0.0, info["date"], info["position"], info["log_equity"])]
    over = False
    while not over:
        seen, reward, terminated, truncated, info = env.step(agent(seen, info["action_mask"]))
        record.append((seen, reward, info["date"], info["position"], info["log_equity"]))
        over = terminated or truncated
    return record


def a_fixed_agent(encoder, seed):
    """A table, or a network of one layer, with random weights; it leaves out what is impossible."""
    rng = np.random.default_rng(seed)
    if encoder.num_states is None:
        weights = rng.normal(size=(encoder.k + 1, 3))
        return lambda seen, mask: int(np.where(mask, seen @ weights, -np.inf).argmax())
    table = rng.normal(size=(2 * encoder.num_states, 3))
    return lambda seen, mask: int(np.where(mask, table[seen], -np.inf).argmax())


@each_encoder
@pytest.mark.parametrize("fill", FILLS)
@seldom
@given(seed=seeds, t=st.integers(181, 238), side=st.sampled_from([1, -1]))
def test_observations_actions_and_rewards_depend_on_no_later_price(kind, fill, seed, t, side):
    """A reward is that of the bar to which it leads: the one at bar t is known at t, also where it was filled later."""
    prices = dated_like_days(random_bars(300, seed=4))
    records = []
    for frame in (prices, with_another_future(prices, t, seed)):
        parts = split(frame, warmup=10)
        encoder = ENCODERS[kind]().fit(parts.training.close)
        records.append(walks(parts.validation, encoder, side, fill, a_fixed_agent(encoder, seed)))
    one, two = (record[: t - 180 + 1] for record in records)
    for mine, other in zip(one, two, strict=True):
        assert np.array_equal(mine[0], other[0])
        assert mine[1:] == other[1:]
    assert str(one[-1][2]) == str(prices.index[t])


@pytest.mark.parametrize("fill", FILLS)
@seldom
@given(seed=seeds, t=st.integers(241, 298))
def test_positions_and_accounts_depend_on_no_later_price(fill, seed, t):
    """Of tables, whose values at a bar are those of its state, and of an account of the positions that they take."""
    prices, rng = random_bars(300, seed=6), np.random.default_rng(seed)
    tables = rng.normal(size=(2, 2 * 81, 3))
    outcomes = []
    for frame in (prices, with_another_future(prices, t, seed)):
        parts = split(frame, warmup=10)
        encoder = ENCODERS["window"]().fit(parts.training.close)
        positions = traded(tables, parts.test, encoder)
        outcomes.append((positions, account(parts.test, positions, fill=fill)))
    (one, money), (two, other) = outcomes
    bar = t - 240
    assert np.array_equal(one[: bar + 1], two[: bar + 1])
    assert np.array_equal(money.log_equity[: bar + 1], other.log_equity[: bar + 1])
    assert np.array_equal(money.rewards[:bar], other.rewards[:bar])


def test_networks_and_lanes_know_no_later_price_either():
    prices = random_bars(300, seed=7)
    values, lanes = [], []
    for frame in (prices, with_another_future(prices, 270, 3)):
        parts = split(frame, warmup=10)
        encoder = ENCODERS["returns"]().fit(parts.training.close)
        env = SideVectorEnv(parts.training, encoder, side=1, num_envs=2, episode_length=40)
        agents = DQNAgent(env, hidden=(6,), replay=50, batch_size=4, seed=2)
        agents.train(num_steps=30)
        values.append(action_values(agents, parts.test, encoder))
        walk = SideVectorEnv(parts.test, encoder, side=-1, num_envs=2)
        seen = [walk.reset(seed=0)[0]]
        seen += [np.column_stack(walk.step(np.array([step % 3, 1]))[:2]) for step in range(30)]
        lanes.append(seen)
    assert np.array_equal(values[0][:, :31], values[1][:, :31])
    assert not np.array_equal(values[0][:, 31:], values[1][:, 31:])
    assert np.array_equal(trade(values[0])[:, :31], trade(values[1])[:, :31])
    assert all(np.array_equal(one, two) for one, two in zip(*lanes, strict=True))


@pytest.mark.parametrize("name", MARKETS)
@seldom
@given(seed=seeds, t=st.integers(60, 298))
def test_who_knows_the_law_of_a_market_does_not_know_its_future(name, seed, t):
    market = MARKETS[name]
    prices = market.prices(300, seed=seed % 50)
    other = with_another_future(prices, t, seed)
    assert np.array_equal(market.knowledge(prices)[: t + 1], market.knowledge(other)[: t + 1])
    assert np.array_equal(market.knowledge(prices)[: t + 1], market.knowledge(prices.iloc[: t + 1]))


@pytest.mark.parametrize("name", MARKETS)
def test_the_optimum_does_not_look_ahead(name):
    market = MARKETS[name]
    prices = market.prices(400, seed=1)
    for t in (61, 200, 398):
        other = with_another_future(prices, t, t)
        for first in (0, 60):
            own, changed = (optimum(market, Part("test", frame, first)) for frame in (prices, other))
            assert np.array_equal(own[: t + 1 - first], changed[: t + 1 - first])


# --- and a leak is found by these means -------------------------------------------------------------------------------


class Leaks:
    """An encoder that tells tomorrow's direction: the exercise "find the leak"."""

    num_states, warmup = 2, 0

    def fit(self, close):  # noqa: ARG002 (nothing to learn)
        return self

    def transform(self, close):
        close = np.asarray(close)
        return np.append(close[1:] > close[:-1], False).astype(int)


def test_a_leak_is_found_and_pays_too_well():
    prices = random_bars(300, seed=8)
    close, other = (frame["close"] for frame in (prices, with_another_future(prices, 200, 1)))
    states = [Leaks().transform(series)[:201] for series in (close, other)]
    assert not np.array_equal(Leaks().transform(close.iloc[:201]), states[0]) or not np.array_equal(*states)
    knows = np.array([[0, -1, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1]])
    positions = trade(action_values(knows, prices, Leaks()))
    assert account(prices, positions, fill="close").log_equity[-1] > 1


def test_a_part_ends_where_its_own_prices_end():
    """What is not in the frame cannot be looked at."""
    parts = split(random_bars(300, seed=9))
    for part, later in zip(list(parts)[:2], list(parts)[1:], strict=True):
        assert part.prices.index[-1] < later.dates[0]
    with pytest.raises(PriceDataError, match="positions must be whole numbers, one for each of 60 bars"):
        account(parts.validation, np.zeros(61, int))
    assert isinstance(parts.test.dates, pd.DatetimeIndex)
