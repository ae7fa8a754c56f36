"""One side of one share as a Gymnasium environment: what it shows, what it pays, when it ends, what it refuses."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from gymnasium.utils.env_checker import check_env
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import FILLS, SIGHTS, closes, often, played, random_bars, ruinous_bars, side_env

from course_lib.market import MinMaxEncoder, Part, ReturnsEncoder, SideEnv, WindowEncoder, account, log_growth

pytestmark = pytest.mark.filterwarnings("ignore:split or crash")
HOLD, OPEN, CLOSE = range(3)
each_side = pytest.mark.parametrize("side", [1, -1])
each_fill = pytest.mark.parametrize("fill", FILLS)


# --- as Gymnasium wants it --------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("given", [{}, {"episode_length": 30}, {"fill": "next_close", "reward_unit": 0.01}])
@each_side
@pytest.mark.parametrize("encoder", SIGHTS)
def test_gymnasium_finds_no_fault_with_it(encoder, side, given):
    check_env(side_env(encoder=encoder, side=side, **given), skip_render_check=True)  # that needs a name to be made by


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("encoder", SIGHTS)
def test_it_is_made_by_its_name(encoder):
    prices = random_bars(120)
    own = {"prices": prices, "encoder": SIGHTS[encoder](prices["close"]), "side": 1}
    env = gymnasium.make("course_lib/Side-v0", **own, episode_length=30)
    check_env(env.unwrapped)
    assert type(env.unwrapped) is SideEnv
    assert env.spec.max_episode_steps is None
    length = len(played(env, [HOLD] * 100)[0]) - 1
    assert length == 30


def test_it_is_wrapped_like_any_other():
    env = gymnasium.wrappers.TimeLimit(side_env(episode_length=30), 12)
    assert len(played(env, [HOLD] * 100)[0]) == 13
    counted = gymnasium.wrappers.RecordEpisodeStatistics(side_env(episode_length=30))
    *_, infos = played(counted, [OPEN] + [HOLD] * 40)
    assert infos[-1]["episode"]["r"] == pytest.approx(infos[-1]["log_equity"])


@each_side
def test_what_a_table_sees_is_position_times_states_plus_state(side):
    prices = random_bars(120)
    env = side_env(prices, side=side)
    assert env.observation_space == Discrete(2 * 9)
    assert env.action_space == Discrete(3)
    states = WindowEncoder(2).fit(prices["close"]).transform(prices["close"])[2:]
    seen, *_ = played(env, [HOLD, OPEN, HOLD, CLOSE, OPEN])
    assert seen == [states[0], states[1], 9 + states[2], 9 + states[3], states[4], 9 + states[5]]
    assert all(type(state) is int for state in seen)


@each_side
def test_what_a_network_sees_are_the_inputs_and_the_position(side):
    prices = random_bars(120)
    env = side_env(prices, "network", side)
    assert env.observation_space == Box(-5.0, 5.0, (4,), np.float32)
    inputs = ReturnsEncoder(3).fit(prices["close"]).transform(prices["close"])[3:]
    seen, *_ = played(env, [HOLD, OPEN, HOLD, CLOSE])
    assert np.array_equal(seen, np.column_stack([inputs[:5], [0, 0, 1, 1, 0]]))
    assert seen[0].dtype == np.float32


def test_what_is_seen_of_wide_inputs_fits_the_space():
    env = side_env(encoder="a learner's network")
    seen, *_ = played(env, [OPEN] + [HOLD] * 200)
    largest = max(np.abs(observation).max() for observation in seen)
    assert env.observation_space == Box(-largest, largest, (3,), np.float32)
    assert all(env.observation_space.contains(observation) for observation in seen)
    clipped = SideEnv(random_bars(50), ReturnsEncoder(2, clip=0.5).fit(random_bars(50)["close"]), side=1)
    assert clipped.observation_space == Box(-1, 1, (3,), np.float32), "the position is 1"


def test_what_it_gives_away_is_the_takers_own():
    """Writing into an observation or a mask changes nothing of the world."""
    env = side_env(encoder="network")
    wanted = played(side_env(encoder="network"), [OPEN] + [HOLD] * 5)
    observation, info = env.reset(seed=0)
    observation[:], info["action_mask"][:] = 9, 9
    for action, seen, told in zip([OPEN] + [HOLD] * 5, wanted[0][1:], wanted[4][1:], strict=True):
        observation, *_, info = env.step(action)
        assert np.array_equal(observation, seen)
        assert info["action_mask"].tolist() == told["action_mask"].tolist()
        observation[:], info["action_mask"][:] = 9, 9
    assert np.array_equal(env.reset(seed=0)[0], wanted[0][0])


# --- what it says and pays --------------------------------------------------------------------------------------------


def test_info_says_where_one_stands():
    prices = random_bars(120)
    actions = [HOLD, CLOSE, OPEN, OPEN, HOLD, CLOSE, OPEN]
    *_, rewards, terminated, truncated, infos = played(side_env(prices), actions)
    assert [info["position"] for info in infos] == [0, 0, 0, 1, 1, 1, 0, 1]
    assert [info["invalid"] for info in infos] == [False, False, True, False, True, False, False, False]
    assert [info["trades"] for info in infos] == [0, 0, 0, 1, 1, 1, 2, 3]
    assert [info["date"] for info in infos] == list(prices.index[2:10])
    assert np.array([info["log_equity"] for info in infos]) == pytest.approx(np.cumsum(rewards), abs=1e-15)
    for info in infos:
        assert set(info) == {"action_mask", "position", "date", "trades", "log_equity", "invalid"}
        assert info["action_mask"].dtype == np.int8
        assert info["action_mask"].tolist() == ([1, 0, 1] if info["position"] else [1, 1, 0])
        assert type(info["invalid"]) is bool
        assert type(info["position"]) is type(info["trades"]) is int
        assert type(info["log_equity"]) is float
    assert type(rewards[-1]) is float
    assert type(terminated[-1]) is type(truncated[-1]) is bool


@each_side
@each_fill
def test_an_impossible_action_is_holding(fill, side):
    """Also in what it costs."""
    wishes = np.random.default_rng(1).integers(3, size=80)
    seen, rewards, *_, infos = played(side_env(side=side, fill=fill, cost=0.01), wishes)
    before = [info["position"] for info in infos[:-1]]
    done = [HOLD if wish == (1 if held else 2) else wish for wish, held in zip(wishes, before, strict=True)]
    assert (np.array(done) != wishes).sum() > 10
    again = played(side_env(side=side, fill=fill, cost=0.01), done)
    assert again[:2] == [seen, rewards]
    assert not any(info["invalid"] for info in again[4])


@each_side
@each_fill
@often
@given(prices=ruinous_bars(min_bars=4, max_bars=15), cost=st.sampled_from([0.0, 0.001, 0.2]), data=st.data())
def test_its_rewards_are_the_account_of_the_positions_held(fill, side, prices, cost, data):
    part = Part("training", prices, 2)
    env = SideEnv(part, WindowEncoder(2).fit(prices["close"]), side=side, cost=cost, fill=fill)
    wishes = data.draw(st.lists(st.integers(0, 2), min_size=len(part), max_size=len(part)))
    _, rewards, terminated, truncated, infos = played(env, wishes)
    positions = np.zeros(len(part), int)
    held = [side * info["position"] for info in infos[1:]]
    positions[: len(held)] = held
    result = account(part, positions, cost=cost, fill=fill)
    assert rewards[1:] == result.rewards[: len(held)].tolist(), "to the last bit"
    assert sum(rewards) == pytest.approx(result.log_equity[-1], abs=1e-12)
    assert infos[-1]["log_equity"] == pytest.approx(result.log_equity[-1], abs=1e-12)
    assert infos[-1]["trades"] == result.trades
    assert (terminated[-1], truncated[-1]) == (result.ruined, not result.ruined)
    growth = log_growth(part, cost, fill)
    before = [0, *held[:-1]]
    assert rewards[1:] == [growth[t, before[t] + 1, held[t] + 1] for t in range(len(held))]


def test_the_reward_is_dense():
    """Every bar in a position pays, not only the last."""
    prices = closes([100, 101, 102, 101, 104, 105])
    env = SideEnv(prices, MinMaxEncoder(None).fit(prices["close"]), side=1, cost=0.01)
    _, rewards, *_ = played(env, [OPEN, HOLD, HOLD, CLOSE, HOLD])
    assert rewards[1:] == pytest.approx([np.log(1.01 * 0.99), np.log(102 / 101), np.log(101 / 102), np.log(0.99), 0])


def test_rewards_are_counted_in_units():
    plain, scaled = (played(side_env(reward_unit=unit), [OPEN, HOLD, CLOSE]) for unit in (1.0, 0.02))
    assert scaled[1] == pytest.approx(np.array(plain[1]) / 0.02)
    assert [info["log_equity"] for info in scaled[4]] == [info["log_equity"] for info in plain[4]], "that is money"


def test_the_defaults_are_five_basis_points_and_what_the_prices_allow():
    actions = [OPEN, HOLD, CLOSE] * 20
    for frame, fill in ((random_bars(80), "next_open"), (random_bars(80)[["close"]], "close")):
        assert played(side_env(frame), actions)[1] == played(side_env(frame, fill=fill, cost=0.0005), actions)[1]
