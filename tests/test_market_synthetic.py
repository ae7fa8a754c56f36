"""The made-up markets have the laws that they claim, and who knows a law does best by it."""

import numpy as np
import pandas as pd
import pytest
from market_worlds import MARKETS, learned, traded

from course_lib import MDP, value_iteration
from course_lib.market import (
    CycleMarket,
    DayGridMarket,
    GridEncoder,
    LadderMarket,
    MinMaxEncoder,
    Part,
    RandomWalkMarket,
    RubberBandMarket,
    SideEnv,
    TrendMarket,
    WindowEncoder,
    account,
    buy_and_hold,
    check_prices,
    flat,
    optimum,
    oracle,
    split,
)

each_market = pytest.mark.parametrize("name", MARKETS)
each_side = pytest.mark.parametrize("side", [1, -1])


def log_prices(market, num_bars=50_000, seed=1):
    return np.log(market.prices(num_bars, seed=seed)["close"].to_numpy() / 100)


def wealth(part, positions, cost):
    return account(part, positions, cost=cost).log_equity[..., -1]


# --- what all have in common ------------------------------------------------------------------------------------------


@each_market
def test_the_seed_decides_the_prices(name):
    market = MARKETS[name]
    prices = market.prices(500, seed=3)
    pd.testing.assert_frame_equal(prices, market.prices(500, seed=3))
    pd.testing.assert_frame_equal(prices, type(market)().prices(500, seed=3))
    others = [market.prices(500, seed=seed)["close"].to_numpy() for seed in range(6)]
    assert len({close.tobytes() for close in others}) == 6
    pd.testing.assert_frame_equal(market.prices(500), market.prices(500, seed=0))
    assert len(market.prices()) == 5000


@pytest.mark.filterwarnings("error")
@each_market
def test_the_prices_are_prices(name):
    for num_bars in (2, 3, 100, 101):
        prices = MARKETS[name].prices(num_bars, seed=1)
        assert check_prices(prices) is prices
        assert prices.shape == (num_bars, 1)
        assert prices.index.name == "date"
        assert prices.index[0].strftime("%Y-%m-%d") == "2000-01-03"
        assert prices.index.day_of_week.max() < 5


# --- their laws -------------------------------------------------------------------------------------------------------


def test_the_ladder_goes_up_with_its_own_chance_from_every_rung():
    market = LadderMarket()
    rungs = log_prices(market, 100_000) / np.log(1.01)
    assert rungs == pytest.approx(np.round(rungs), abs=1e-9)
    rungs = np.round(rungs).astype(int)
    assert rungs[0] == 5
    assert set(np.abs(np.diff(rungs))) == {1}
    assert set(rungs) == set(range(11))
    for rung in range(11):
        up = np.diff(rungs)[rungs[:-1] == rung] > 0
        chance = {0: 1.0, 10: 0.0}.get(rung, 0.5 - 0.06 * (rung - 5))
        assert up.mean() == pytest.approx(chance, abs=5 * np.sqrt(chance * (1 - chance) / len(up))), rung
    assert np.array_equal(market.knowledge(market.prices(100_000, seed=1)), rungs)


def test_a_day_on_the_grid_begins_in_the_middle_where_the_day_before_ended():
    market = DayGridMarket()
    prices = market.prices(45_000, seed=1)
    days = np.log(prices["close"].to_numpy() / 100).reshape(-1, 9) / 0.005
    assert days[0, 0] == 0
    assert days[1:, 0] == pytest.approx(days[:-1, -1], abs=1e-9)
    assert (
        prices.index.normalize().to_numpy().reshape(-1, 9) == prices.index.normalize()[::9].to_numpy()[:, None]
    ).all()
    assert prices.index.hour.to_numpy().reshape(-1, 9)[7].tolist() == list(range(9, 18))
    rows = np.round(days - days[:, :1]).astype(int)
    assert (days - days[:, :1]) == pytest.approx(rows, abs=1e-9)
    assert (rows.min(), rows.max()) == (-4, 4)
    moves = np.diff(rows, axis=1)
    assert set(np.abs(moves).ravel()) == {1}
    for row in range(-4, 5):
        up = moves[rows[:, :-1] == row] > 0
        chance = {-4: 1.0, 4: 0.0}.get(row, 0.5 - 0.1 * row)
        assert up.mean() == pytest.approx(chance, abs=5 * np.sqrt(chance * (1 - chance) / len(up))), row
    states = market.knowledge(prices)
    assert np.array_equal(states, ((rows + 4) * 9 + np.arange(9)).ravel())


@pytest.mark.parametrize(("kappa", "sigma"), [(0.2, 0.01), (0.05, 0.02), (1.0, 0.01)])
def test_the_rubber_band_pulls_back_by_its_share_a_bar(kappa, sigma):
    x = log_prices(RubberBandMarket(kappa, sigma))
    assert x[0] == 0
    slope = (x[1:] * x[:-1]).sum() / (x[:-1] ** 2).sum()
    error = np.sqrt((1 - (1 - kappa) ** 2) / len(x)) + 1 / len(x)
    assert slope == pytest.approx(1 - kappa, abs=5 * error)
    noise = x[1:] - (1 - kappa) * x[:-1]
    assert noise.std() == pytest.approx(sigma, rel=0.02)
    assert noise.mean() == pytest.approx(0, abs=5 * sigma / np.sqrt(len(x)))
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 5 / np.sqrt(len(x))


def test_the_trend_has_two_winds_that_stay():
    """Where the noise is small each bar shows its wind."""
    moves = np.diff(log_prices(TrendMarket(drift=0.05, sigma=0.005, stay=0.9), 20_000))
    wind = np.sign(moves)
    assert np.mean(wind[1:] == wind[:-1]) == pytest.approx(0.9, abs=5 * np.sqrt(0.9 * 0.1 / len(wind)))
    assert wind.mean() == pytest.approx(0, abs=5 * np.sqrt(1.9 / 0.1 / len(wind)))
    assert (moves - 0.05 * wind).std() == pytest.approx(0.005, rel=0.03)
    assert (moves - 0.05 * wind).mean() == pytest.approx(0, abs=5 * 0.005 / np.sqrt(len(wind)))
    first = [np.sign(log_prices(TrendMarket(drift=0.05, sigma=0.005), 2, seed)[1]) for seed in range(60)]
    assert 15 < first.count(1.0) < 45, "it begins with either"


def test_the_trend_of_the_course_has_the_memory_of_its_winds():
    """Covariance of returns k bars apart: drift^2 (2 stay - 1)^k."""
    moves = np.diff(log_prices(TrendMarket(), 200_000))
    assert moves.std() == pytest.approx(np.hypot(0.004, 0.01), rel=0.02)
    for lag in (1, 10, 25):
        assert np.mean(moves[lag:] * moves[:-lag]) == pytest.approx(0.004**2 * 0.96**lag, abs=2.5e-6), lag


def test_belief_in_a_wind_is_bayes_rule_bar_by_bar():
    market = TrendMarket(drift=0.004, sigma=0.01, stay=0.95)
    prices = market.prices(300, seed=2)
    moves, belief, known = np.diff(np.log(prices["close"])), 0.5, [50]
    for move in moves:
        tail = belief * 0.95 + (1 - belief) * 0.05
        likely = [np.exp(-((move - wind * 0.004) ** 2) / (2 * 0.01**2)) for wind in (1, -1)]
        belief = tail * likely[0] / (tail * likely[0] + (1 - tail) * likely[1])
        known.append(round(100 * belief))
    assert np.abs(market.knowledge(prices) - known).max() <= 1
    assert np.mean(market.knowledge(prices) == known) > 0.99


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("given", [{"stay": 1.0}, {"drift": 0.1, "sigma": 0.001}, {"stay": 0.001}])
def test_certainty_is_no_division_by_zero(given):
    market = TrendMarket(**given)
    prices = market.prices(400, seed=1)
    states = market.knowledge(prices)
    assert states.min() >= 0
    assert states.max() <= 100
    assert optimum(market, Part("test", prices, 0)).any()


def test_the_cycle_has_its_period_and_its_noise():
    x = log_prices(CycleMarket(period=37, amplitude=0.1, sigma=0.01), 37 * 600)
    power = np.abs(np.fft.rfft(x)) ** 2
    assert power.argmax() == 600, "as many swings as there are periods"
    swing = 0.1 * np.sin(2 * np.pi * np.arange(len(x)) / 37)
    noise = x - swing
    assert noise.std() == pytest.approx(0.01, rel=0.03)
    assert noise.mean() == pytest.approx(0, abs=5 * 0.01 / np.sqrt(len(x)))
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 5 / np.sqrt(len(x))
    default = log_prices(CycleMarket(), 37 * 600)
    assert np.array_equal(default, x)


def test_the_random_walk_remembers_nothing():
    moves = np.diff(log_prices(RandomWalkMarket(sigma=0.01)))
    n = len(moves)
    assert moves.std() == pytest.approx(0.01, rel=0.02)
    assert moves.mean() == pytest.approx(0, abs=5 * 0.01 / np.sqrt(n))
    for lag in range(1, 11):
        for series in (moves, np.abs(moves)):
            assert abs(np.corrcoef(series[lag:], series[:-lag])[0, 1]) < 5 / np.sqrt(n), lag


# --- as chains and as MDPs --------------------------------------------------------------------------------------------


@each_market
def test_a_chain_is_what_follows_on_what_is_known(name):
    """Where each state of knowledge leads to, and what a bar pays, on average over a long history."""
    market = MARKETS[name]
    chain, prices = market.chain, market.prices(60_000, seed=2)
    assert chain.transition.min() >= 0
    assert chain.transition.sum(axis=1) == pytest.approx(1)
    assert (chain.growth[:, 1] == 0).all()
    moves, known = np.diff(np.log(prices["close"].to_numpy())), market.knowledge(prices)
    states, following = known[:-1], known[1:]
    expected = chain.transition @ np.arange(len(chain.growth))
    common = np.flatnonzero(np.bincount(states, minlength=len(chain.growth)) > 150)
    assert len(common) >= min(len(chain.growth), 3)
    for state in common:
        seen = moves[states == state]
        error = 5 * seen.std() / np.sqrt(len(seen)) + 4e-4  # and what rounding to a grid may cost
        assert np.mean(seen) == pytest.approx(chain.growth[state, 2], abs=error), state
        after = following[states == state]
        assert after.mean() == pytest.approx(expected[state], abs=5 * after.std() / np.sqrt(len(after)) + 0.5), state
        assert np.mean(np.log(2 - np.exp(seen))) == pytest.approx(chain.growth[state, 0], abs=error), state


@each_side
@pytest.mark.parametrize(
    ("market", "encoder"), [(LadderMarket(), MinMaxEncoder(None, levels=11)), (DayGridMarket(), GridEncoder(9, "day"))]
)
def test_the_mdp_is_what_the_environment_does_on_average(market, encoder, side):
    prices = market.prices(40_000, seed=3)
    encoder.fit(prices["close"])
    mdp, env = market.mdp(side, 0.002), SideEnv(prices, encoder, side=side, cost=0.002)
    num_states = 2 * encoder.num_states
    assert (mdp.num_states, mdp.num_actions) == (num_states, 3)
    assert not mdp.terminal.any()
    paid, squared, times = np.zeros((3, num_states, 3))
    followed = np.zeros((num_states, 3, num_states))
    rng, over = np.random.default_rng(1), False
    state, _ = env.reset(seed=0)
    while not over:
        action = rng.integers(3)
        after, reward, terminated, truncated, _ = env.step(action)
        paid[state, action] += reward
        squared[state, action] += reward**2
        times[state, action] += 1
        followed[state, action, after] += 1
        state, over = after, terminated or truncated
    often = times > 100
    assert often.sum() > 0.25 * times.size
    mean = paid[often] / times[often]
    spread = np.sqrt(np.maximum(squared[often] / times[often] - mean**2, 0))
    assert (np.abs(mean - mdp.R[often]) <= 5 * spread / np.sqrt(times[often]) + 1e-9).all()
    shares, chances = followed[often] / times[often][:, None], mdp.T[often]
    error = 5 * np.sqrt(chances * (1 - chances) / times[often][:, None]) + 1e-9
    assert (np.abs(shares - chances) <= error).all()


def test_the_default_cost_of_an_mdp_is_that_of_the_account():
    for market in (LadderMarket(), DayGridMarket()):
        assert np.array_equal(market.mdp(1).reward, market.mdp(1, 0.0005).reward)
        out, into = market.mdp(1).R[0, 0], market.mdp(1).R[0, 1]
        assert into - out == pytest.approx(market.chain.growth[0, 2] + np.log(0.9995))


# --- who knows the law ------------------------------------------------------------------------------------------------


def ladder_by_hand(cost, gamma):
    """Both sides' world on the ladder, built a number at a time: states position * 11 + rung, actions: positions."""
    next_state, probability, reward = np.zeros((33, 3, 2), int), np.zeros((33, 3, 2)), np.zeros((33, 3, 2))
    for held in range(3):
        for rung in range(11):
            up = {0: 1.0, 10: 0.0}.get(rung, 0.5 - 0.06 * (rung - 5))
            for new in range(3):
                here = (held * 11 + rung, new)
                next_state[here] = [new * 11 + min(rung + 1, 10), new * 11 + max(rung - 1, 0)]
                probability[here] = [up, 1 - up]
                reward[here] = [np.log(1 + (new - 1) * (factor - 1)) for factor in (1.01, 1 / 1.01)]
                reward[here] += abs(new - held) * np.log(1 - cost)
    return value_iteration(MDP(next_state, probability, reward, np.zeros((33, 3, 2), bool)), gamma)


@pytest.mark.parametrize("cost", [0.0005, 0.004, 0.02])
def test_the_optimum_on_the_ladder_is_the_best_policy_of_the_ladder(cost):
    q = ladder_by_hand(cost, 0.995).q.reshape(3, 11, 3)
    prices = LadderMarket().prices(3000, seed=5)
    positions, held = optimum(LadderMarket(), Part("test", prices, 0), cost=cost), 1
    for rung, position in zip(LadderMarket().knowledge(prices), positions, strict=True):
        assert q[held, rung, position + 1] == pytest.approx(q[held, rung].max(), abs=1e-9)
        held = position + 1
    assert len(set(positions)) == 3


@pytest.mark.parametrize("name", [name for name in MARKETS if name != "random walk"])
def test_nobody_does_better_in_the_long_run_than_who_knows_the_law(name):
    """On 15,000 unseen bars; but for the oracle, who has seen them."""
    market, cost = MARKETS[name], 0.001
    parts = split(market.prices(30_000, seed=1), (0.3, 0.2, 0.5))
    best = wealth(parts.test, optimum(market, parts.test, cost=cost), cost)
    others = {"flat": flat(parts.test), "hold": buy_and_hold(parts.test), "short": -buy_and_hold(parts.test)}
    for make in (MinMaxEncoder, lambda: MinMaxEncoder(None, levels=11), GridEncoder, lambda: WindowEncoder(3)):
        encoder = make().fit(parts.training.close)
        agents = learned(parts.training, encoder, cost=cost, passes=20)
        others[encoder.describe(0)] = traded(agents, parts.test, encoder)
    others["random"] = np.random.default_rng(0).integers(-1, 2, len(parts.test))
    for who, positions in others.items():
        assert wealth(parts.test, positions, cost) <= best + 1e-9, who
    assert best > 0.5
    assert best < wealth(parts.test, oracle(parts.test, cost=cost), cost)


@pytest.mark.parametrize("cost", [0.0, 0.0005, 0.01])
def test_on_the_random_walk_the_best_is_to_stay_out(cost):
    assert not optimum(RandomWalkMarket(), RandomWalkMarket().prices(2000), cost=cost).any()


@each_market
def test_random_policies_lose(name):
    """The costs of a thousand trades; on average over forty traders, whatever the market."""
    prices = MARKETS[name].prices(3000, seed=4)
    positions = np.random.default_rng(1).integers(-1, 2, (40, 3000))
    money = wealth(prices, positions, 0.001)
    assert money.mean() < -2
    assert (money < 0).all()


def test_to_hold_on_to_a_rubber_band_leads_nowhere():
    held = [wealth(p, buy_and_hold(p), 0.001) for p in (RubberBandMarket().prices(5000, seed=s) for s in range(20))]
    assert np.abs(held).max() < 5 * 0.01 / 0.6, "not more than the price can ever be off"
    assert np.mean(held) == pytest.approx(0, abs=0.02)


def test_the_optimum_pays_attention_to_cost_and_to_what_was_before_the_part():
    market, prices = LadderMarket(), LadderMarket().prices(2000, seed=6)
    trades = [account(prices, optimum(market, prices, cost=c), cost=c).trades for c in (0.0, 0.002, 0.01, 0.2)]
    assert trades == sorted(trades, reverse=True)
    assert trades[0] > 4 * trades[2]
    assert trades[3] == 0
    assert np.array_equal(optimum(market, prices), optimum(market, prices, cost=0.0005))
    day, bars = DayGridMarket(), DayGridMarket().prices(903, seed=6)
    part = Part("test", bars, 400)
    assert len(optimum(day, part)) == 503
    states = day.knowledge(part.prices)[400:]
    assert (states % 9 == (np.arange(503) + 400) % 9).all()
