"""What may honestly be expected: the figures of the course, over twenty markets each, training beside unseen days.

Everywhere the agents are trained as the lessons do it (`learned`): two tables, 50 passes over the training bars.
"""

from functools import cache

import numpy as np
import pytest
from market_worlds import MARKETS, closes, learned, traded

from course_lib import QAgent, value_iteration
from course_lib.market import (
    GridEncoder,
    LadderMarket,
    MinMaxEncoder,
    SideEnv,
    WindowEncoder,
    account,
    action_values,
    metrics,
    optimum,
    oracle,
    random_shifts,
    real_prices,
    split,
    trade,
)

pytestmark = pytest.mark.filterwarnings("ignore:split or crash")
SEEDS = range(20)
ENCODERS = {
    "window 8": WindowEncoder,
    "window 3": lambda: WindowEncoder(3),
    "min-max 60": MinMaxEncoder,
    "min-max of training": lambda: MinMaxEncoder(None),
    "turn 8": GridEncoder,
}


def shuffled_share(seed):
    """The log returns of a real share in another order: no pattern can have survived."""
    moves = np.diff(np.log(real_prices("IBM")["close"].to_numpy()))
    moves = np.random.default_rng(seed).permutation(moves)
    return closes(100 * np.exp(np.cumsum(np.append(0.0, moves))))


@cache
def parts_of(market, seed):
    return split(shuffled_share(seed) if market == "shuffled share" else MARKETS[market].prices(5000, seed=seed))


@cache
def sharpe_of(market, encoder, cost=0.0005):
    """Sharpe ratios in training and on unseen days, float[20, 2]."""
    ratios = []
    for seed in SEEDS:
        parts = parts_of(market, seed)
        eyes = ENCODERS[encoder]().fit(parts.training.close)
        agents = learned(parts.training, eyes, cost=cost, seed=seed)
        both = (parts.training, parts.test)
        ratios.append([metrics(account(part, traded(agents, part, eyes), cost=cost)).sharpe for part in both])
    return np.array(ratios)


# --- a pattern is there: it works -------------------------------------------------------------------------------------


def test_on_the_ladder_it_finds_the_policy_that_is_best():
    """The share of (position, rung) pairs in which the greedy action is as good as the best by Q*.

    As good: to 1e-6, where the nearest second best is 4e-4 away.
    """
    market, agreement = LadderMarket(), {}
    best = {side: value_iteration(market.mdp(side, 0.0005), 0.95).q for side in (1, -1)}
    possible = np.repeat([[True, True, False], [True, False, True]], 11, axis=0)
    for steps in (2_000, 10_000, 100_000):
        shares = []
        for seed in SEEDS:
            training = split(market.prices(5000, seed=seed)).training
            encoder = MinMaxEncoder(m=None, levels=11).fit(training.close)
            assert np.array_equal(encoder.transform(training.close), market.knowledge(training.prices)[60:])
            for side, q in best.items():
                env = SideEnv(training, encoder, side=side, cost=0.0005, episode_length=250)
                agent = QAgent(
                    env, gamma=0.95, alpha=1.0, alpha_power=0.6, epsilon=1.0, epsilon_decay=0.1 ** (250 / steps),
                    mask_actions=True, seed=seed,
                )  # fmt: skip
                agent.train(steps // 250)
                chosen = np.where(possible, agent.q_table, -np.inf).argmax(axis=1)
                shares.append(np.mean(q[np.arange(22), chosen] >= q.max(axis=1) - 1e-6))
        agreement[steps] = np.mean(shares)
    assert agreement[2_000] + 0.05 < agreement[10_000] < agreement[100_000]
    assert agreement[100_000] >= 0.95
    assert 0.7 < agreement[2_000] < 0.95


def test_on_the_rubber_band_levels_see_the_pattern_in_every_one_of_twenty_markets():
    assert sharpe_of("rubber band", "min-max 60", 0.001)[:, 1].min() > 2


def test_on_the_rubber_band_turns_see_some_of_it_in_every_market():
    """Markets of 10,000 bars: over 2,000 unseen ones a Sharpe ratio is good to about 0.35, over 1,000 to 0.5."""
    unseen = []
    for seed in SEEDS:
        parts = split(MARKETS["rubber band"].prices(10_000, seed=seed))
        eyes = GridEncoder(8).fit(parts.training.close)
        agents = learned(parts.training, eyes, cost=0.001, seed=seed)
        unseen.append(metrics(account(parts.test, traded(agents, parts.test, eyes), cost=0.001)).sharpe)
    assert np.min(unseen) > 0.5
    assert np.mean(unseen) > 1.3


def test_on_the_rubber_band_a_long_window_learns_its_training_by_heart_and_nothing_else():
    training, unseen = sharpe_of("rubber band", "window 8", 0.001).T
    assert training.min() > 8
    assert unseen.max() < 1


def test_which_state_can_see_the_pattern():
    """Levels see the rubber band, directions see the cycle; nearly all that is to be had is in ten levels."""
    band = {name: sharpe_of("rubber band", name, 0.001)[:, 1].mean() for name in ("window 8", "window 3", "min-max 60")}
    assert band["window 8"] + 0.5 < band["window 3"] < band["min-max 60"] - 1.5
    market, best = MARKETS["rubber band"], []
    for seed in SEEDS:
        part = parts_of("rubber band", seed).test
        best.append(metrics(account(part, optimum(market, part, cost=0.001), cost=0.001)).sharpe)
    assert 0.8 * np.mean(best) < band["min-max 60"] < np.mean(best)
    cycle = {name: sharpe_of("cycle", name)[:, 1] for name in ("window 8", "window 3", "turn 8")}
    assert min(cycle["window 3"].min(), cycle["turn 8"].min()) > 6
    assert cycle["window 8"].mean() < 5


# --- none is there: nothing works -------------------------------------------------------------------------------------


@pytest.mark.parametrize("encoder", ENCODERS)
def test_on_the_random_walk_nothing_works(encoder):
    training, unseen = sharpe_of("random walk", encoder).T
    assert unseen.mean() < 0.3
    assert training.mean() > unseen.mean() + 0.5, "and all of them look better in training"


def test_a_shuffled_share_is_learned_by_heart_and_not_known_on_unseen_days():
    training, unseen = sharpe_of("shuffled share", "window 8").T
    assert training.min() > 8
    assert unseen.mean() < 0.5


def test_a_leak_of_one_bar_is_worth_a_fortune():
    """The states of tomorrow, which nobody has today."""

    class TooClever(WindowEncoder):
        def transform(self, close):
            states = super().transform(close)
            return np.append(states[1:], states[-1])

    for seed in range(3):
        parts = parts_of("random walk", seed)
        encoder = TooClever(3).fit(parts.training.close)
        positions = traded(learned(parts.training, encoder, seed=seed), parts.test, encoder)
        assert metrics(account(parts.test, positions)).sharpe > 8


# --- real shares: nothing is promised ---------------------------------------------------------------------------------


@pytest.mark.parametrize("symbol", ["AAPL", "GOOG", "IBM", "MSFT"])
def test_on_real_shares_the_accounts_are_right_whatever_they_say(symbol):
    parts = split(real_prices(symbol))
    for make in ENCODERS.values():
        encoder = make().fit(parts.training.close)
        agents = learned(parts.training, encoder, passes=10)
        for part in parts:
            positions = traded(agents, part, encoder)
            own, best = account(part, positions), account(part, oracle(part))
            assert own.rewards.sum() == pytest.approx(own.log_equity[-1], abs=1e-12)
            assert own.log_equity[-1] <= best.log_equity[-1]
            assert np.isfinite([*vars(metrics(own)).values()]).all()
            dearer = account(part, positions, cost=0.002)
            assert dearer.log_equity[-1] - own.log_equity[-1] == pytest.approx(
                own.trades * (np.log(0.998) - np.log(0.9995)), abs=1e-9
            )
            assert random_shifts(positions, 3).shape == (3, len(part))
            for side, agent, other in ((1, agents[0], None), (-1, None, agents[1])):
                values = [None if one is None else action_values(one, part, encoder) for one in (agent, other)]
                assert set(trade(*values)) <= {0, side}
