"""Two sides are one trader by a rule that can be played slowly, and the same on every machine."""

import itertools
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from market_worlds import SIGHTS, learned, often, random_bars, side_env

from course_lib import DQNAgent
from course_lib.market import (
    MinMaxEncoder,
    PriceDataError,
    ReturnsEncoder,
    RubberBandMarket,
    SideEnv,
    action_values,
    split,
    trade,
)

HOLD, OPEN, CLOSE = range(3)
few_values = st.sampled_from([-1.0, -0.5, 0.0, 0.5, 1.0, 1.5])  # so that there are ties


def trade_slowly(q_long, q_short):
    """The rule, a bar at a time. A side that is not traded is None."""
    sides = {+1: q_long, -1: q_short}
    sides = {side: q for side, q in sides.items() if q is not None}
    positions, held = [], 0
    for t in range(len(next(iter(sides.values())))):
        gain = {side: q[t][0][OPEN] - q[t][0][HOLD] for side, q in sides.items()}
        gain = {side: gain.get(side, 0.0) for side in (1, -1)}
        wanted = 1 if gain[1] > gain[-1] else -1 if gain[-1] > gain[1] else 0
        if gain.get(wanted, 0) <= 0:
            wanted = 0
        if held == 0:
            held = wanted
        elif sides[held][t][1][CLOSE] > sides[held][t][1][HOLD]:
            held = wanted if wanted == -held else 0
        positions.append(held)
    return positions


@often
@given(values=hnp.arrays(float, (2, 12, 2, 3), elements=few_values))
def test_the_rule_is_the_rule(values):
    q_long, q_short = values
    assert trade(q_long, q_short).tolist() == trade_slowly(q_long, q_short)
    assert trade(q_long).tolist() == trade(q_long, None).tolist() == trade_slowly(q_long, None)
    assert trade(q_short=q_short).tolist() == trade(None, q_short).tolist() == trade_slowly(None, q_short)
    assert set(trade(q_long)) <= {0, 1}
    assert set(trade(None, q_short)) <= {0, -1}


def test_all_that_can_happen_happens():
    """The property above has met every change of position."""
    values = np.random.default_rng(0).normal(size=(2, 400, 2, 3))
    positions = np.append(0, trade(*values))
    assert len(set(itertools.pairwise(positions))) == 9
    assert trade(*values).tolist() == trade_slowly(*values)


def bar(hold=0.0, opens=-1.0, keeps=1.0, closes=0.0):
    """Action values of one side at one bar: out, where closing is impossible, and in, where opening is."""
    return [[hold, opens, 99.0], [keeps, 99.0, closes]]


RULES = [  # long bars, short bars, the positions
    ("the larger advantage opens", [bar(opens=0.2)], [bar(opens=0.3)], [-1]),
    ("an advantage counts, not a value", [bar(opens=0.2)], [bar(hold=5, opens=5.1)], [1]),
    ("none is positive", [bar(opens=-0.1)], [bar(opens=-0.2)], [0]),
    ("an advantage of nothing is none", [bar(opens=0.0)], [bar(opens=-0.2)], [0]),
    ("of equals neither", [bar(opens=0.5)], [bar(opens=0.5)], [0]),
    ("holding goes on whatever the other wants", [bar(opens=1)] + [bar()] * 2, [bar()] + [bar(opens=9)] * 2, [1, 1, 1]),
    ("as good as closing is holding", [bar(opens=1), bar(keeps=0.5, closes=0.5)], [bar()] * 2, [1, 1]),
    ("closing", [bar(opens=1), bar(closes=2), bar()], [bar()] * 3, [1, 0, 0]),
    ("who has closed does not reopen", [bar(opens=1), bar(closes=2, opens=1), bar(opens=1)], [bar()] * 3, [1, 0, 1]),
    ("the other side opens at once", [bar(opens=1), bar(closes=2)], [bar(), bar(opens=1)], [1, -1]),
    ("and back", [bar(), bar(opens=1)], [bar(opens=1), bar(closes=2)], [-1, 1]),
    ("but not with less advantage", [bar(opens=1), bar(closes=2, opens=3)], [bar(), bar(opens=1)], [1, 0]),
    ("nor with as much", [bar(opens=1), bar(closes=2, opens=1)], [bar(), bar(opens=1)], [1, 0]),
]


@pytest.mark.parametrize(("q_long", "q_short", "wanted"), [case[1:] for case in RULES], ids=[case[0] for case in RULES])
def test_the_rule_case_by_case(q_long, q_short, wanted):
    assert trade(q_long, q_short).tolist() == wanted
    assert trade_slowly(q_long, q_short) == wanted
    assert trade(q_short, q_long).tolist() == [-position for position in wanted], "the sides are alike"


@pytest.mark.parametrize("shape", [(4,), (2, 3), (1,), (0,)])
def test_many_traders_are_each_one_alone(shape):
    q_long, q_short = np.random.default_rng(1).normal(size=(2, *shape, 30, 2, 3))
    for pair in ((q_long, q_short), (q_long, None), (None, q_short)):
        together = trade(*pair)
        assert together.shape == (*shape, 30)
        assert together.dtype == np.int8
        for i in np.ndindex(shape):
            alone = trade(*(None if q is None else q[i] for q in pair))
            assert np.array_equal(together[i], alone)


def test_values_of_tables_are_looked_up_bar_by_bar():
    parts = split(random_bars(200, seed=3), warmup=5)
    encoder = MinMaxEncoder(5, levels=4).fit(parts.training.close)
    table = np.random.default_rng(0).normal(size=(8, 3))
    for part in parts:
        values = action_values(table, part, encoder)
        assert values.shape == (len(part), 2, 3)
        states = encoder.transform(part.prices["close"])[part.first :]
        for t, state in enumerate(states):
            assert np.array_equal(values[t], [table[state], table[4 + state]])
    agent = learned(parts.training, encoder, passes=10)[0]
    assert np.array_equal(action_values(agent, parts.test, encoder), action_values(agent.q_table, parts.test, encoder))
    assert np.array_equal(action_values(table.tolist(), parts.test, encoder), values)
    values[:] = 0
    assert table.any()
    frame = random_bars(200, seed=3)
    assert action_values(table, frame, encoder).shape == (200 - 4, 2, 3), "a whole frame, from the warm-up on"


def test_values_of_networks_are_those_of_the_observations_an_environment_shows():
    for sight in SIGHTS:
        prices = random_bars(60, seed=4)
        env = side_env(prices, sight)
        agents = DQNAgent(env, num_agents=2, hidden=(5,), seed=1)
        values = action_values(agents, prices, SIGHTS[sight](prices["close"]))
        bars = env.tape.bars
        assert values.shape == (2, bars, 2, 3)
        for position in (0, 1):
            seen = [env.reset(seed=0)[0]]
            actions = [OPEN, *[HOLD] * (bars - 2)] if position else [HOLD] * (bars - 1)
            seen += [env.step(action)[0] for action in actions]
            wanted = agents.q_values(np.array(seen))
            assert values[:, position:, position] == pytest.approx(wanted[:, position:], abs=1e-6)
        assert trade(values).shape == (2, bars)


def test_a_greedy_agent_in_its_environment_takes_the_same_positions():
    """One side alone: the trader is the agent that walks through the environment."""
    parts = split(RubberBandMarket().prices(500, seed=1), warmup=10)
    encoder = MinMaxEncoder(10, levels=5).fit(parts.training.close)
    for side, agent in zip((1, -1), learned(parts.training, encoder, passes=20), strict=True):
        values = action_values(agent, parts.test, encoder)
        positions = trade(values) if side == 1 else trade(None, values)
        env = SideEnv(parts.test, encoder, side=side)
        agent.env = env
        walk = agent.test(max_steps=10_000)
        held = walk.states[1:] // encoder.num_states
        assert held.any()
        assert positions[:-1].tolist() == (side * held).tolist()


def test_a_network_for_other_inputs_is_refused():
    prices = random_bars(60)
    agents = DQNAgent(side_env(prices, "network"), hidden=(5,))
    with pytest.raises(ValueError, match="must have shape"):
        action_values(agents, prices, ReturnsEncoder(9).fit(prices["close"]))
    with pytest.raises(PriceDataError, match="a table for this encoder has 0 rows"):
        action_values(np.zeros((8, 3)), prices, ReturnsEncoder(3).fit(prices["close"]))


# --- the same everywhere ----------------------------------------------------------------------------------------------

CODE = """
import hashlib, numpy as np
from course_lib import DQNAgent, QAgent
from course_lib.market import *
digest = hashlib.sha256()
for market in (RubberBandMarket(), TrendMarket(), DayGridMarket()):
    parts = split(market.prices(600, seed=7), warmup=10)
    tables, networks = WindowEncoder(3).fit(parts.training.close), ReturnsEncoder(4).fit(parts.training.close)
    values, more = [], []
    for side in (1, -1):
        env = SideEnv(parts.training, tables, side=side, episode_length=50)
        agent = QAgent(env, alpha_power=0.6, epsilon=1.0, epsilon_decay=0.9, mask_actions=True, seed=3)
        agent.train(30)
        values.append(action_values(agent, parts.test, tables))
        lanes = SideVectorEnv(parts.training, networks, side=side, num_envs=2, episode_length=50)
        agents = DQNAgent(lanes, hidden=(8,), replay=100, batch_size=8, target_update=20, double=True, seed=3)
        agents.train(num_steps=120)
        more.append(action_values(agents, parts.test, networks))
    for positions in (trade(*values), *trade(*more), oracle(parts.test), optimum(market, parts.test)):
        digest.update(positions.tobytes())
        digest.update(account(parts.test, positions).log_equity.tobytes())
    digest.update(random_shifts(trade(*values)).tobytes())
    print(trade(*values).any(), trade(*more).any())
print(digest.hexdigest())
"""


def test_the_same_seed_makes_the_same_trades_in_every_process():
    answers = set()
    for seed, threads in (("1", "1"), ("2", "2")):
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
        environment = os.environ | {"PYTHONHASHSEED": seed} | dict.fromkeys(names, threads)
        done = subprocess.run(
            [sys.executable, "-P", "-c", CODE], env=environment, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        answers.add(done.stdout)
    assert len(answers) == 1
    assert "False False" not in answers.pop(), "somebody has traded"
