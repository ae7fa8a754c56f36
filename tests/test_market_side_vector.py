"""Many traders stepped at once are those that are stepped one by one."""

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from market_worlds import FILLS, SIGHTS, bars, random_bars, side_env

from course_lib import DQNAgent
from course_lib.market import PriceDataError, ReturnsEncoder, SideEnv, SideVectorEnv, account

LANES = 7
each_side = pytest.mark.parametrize("side", [1, -1])
pytestmark = pytest.mark.filterwarnings("ignore:split or crash")


def crashing():
    """Prices that triple now and then, so that a short is ruined from time to time."""
    close = random_bars(150, seed=2)["close"].to_numpy().copy()
    for place in (30, 31, 60, 90, 110, 111):
        close[place:] *= 3 if place % 4 else 1 / 3
    return bars(np.roll(close, 1) * 1.001, close)


def both(encoder, side, num_envs=LANES, **given):
    """The vector form, and single ones side by side in Gymnasium's own."""
    prices, make = crashing(), SIGHTS[encoder]
    fitted = make(prices["close"])
    ours = SideVectorEnv(prices, fitted, side=side, num_envs=num_envs, **given)
    theirs = SyncVectorEnv(
        [lambda: SideEnv(prices, fitted, side=side, **given) for _ in range(num_envs)],
        autoreset_mode=AutoresetMode.NEXT_STEP,
    )
    return ours, theirs


def assert_same(ours, theirs):
    """Observations, rewards, ends and infos, to the last bit and type."""
    for mine, other in zip(ours[:-1], theirs[:-1], strict=True):
        assert mine.dtype == other.dtype
        assert mine.shape == other.shape
        assert np.array_equal(mine, other)
    assert ours[-1].keys() == theirs[-1].keys()
    for name, mine in ours[-1].items():
        other = theirs[-1][name]
        if name == "date":
            mine, other = mine.astype("datetime64[us]"), other.astype("datetime64[us]")
        assert mine.dtype == other.dtype, name
        assert np.array_equal(mine, other), name


@pytest.mark.parametrize("seed", [3, [5, 9, 1, 0, 3, 3, 8], [4, None, None, 2, 0, 1, 7]])
@each_side
@pytest.mark.parametrize("encoder", SIGHTS)
def test_lanes_are_environments_side_by_side(encoder, side, seed):
    ours, theirs = both(encoder, side, episode_length=25, cost=0.01, reward_unit=0.02, fill="next_open")
    if isinstance(seed, list) and None in seed:  # those go on where they were
        ours.reset(seed=11), theirs.reset(seed=11)
    assert_same(ours.reset(seed=seed), theirs.reset(seed=seed))
    rng, episodes, ruined = np.random.default_rng(1), 0, 0
    for step in range(300):
        if step == 200:  # all of them in the middle of an episode
            assert_same(ours.reset(), theirs.reset())
        actions = rng.choice(3, LANES, p=[0.6, 0.3, 0.1])
        mine = ours.step(actions)
        assert_same(mine, theirs.step(actions))
        episodes, ruined = episodes + (mine[2] | mine[3]).sum(), ruined + mine[2].sum()
    assert episodes > 5 * LANES
    assert ruined > 5 or side == 1


@pytest.mark.parametrize("fill", FILLS)
def test_lanes_are_environments_by_every_fill_from_beginning_to_end(fill):
    ours, theirs = both("table", -1, num_envs=2, fill=fill)
    assert_same(ours.reset(seed=0), theirs.reset(seed=0))
    rng = np.random.default_rng(2)
    for _ in range(400):
        actions = rng.integers(3, size=2)
        assert_same(ours.step(actions), theirs.step(actions))


@each_side
@pytest.mark.parametrize("fill", FILLS)
def test_rewards_add_up_to_the_log_of_the_money_in_every_lane(fill, side):
    """Which is that of the account of the positions held."""
    prices = random_bars(150)
    encoder = SIGHTS["table"](prices["close"])
    env = SideVectorEnv(prices, encoder, side=side, num_envs=LANES, episode_length=40, fill=fill, cost=0.003)
    _, info = env.reset(seed=0)
    lanes, first, part = np.arange(LANES), env.tape.dates.get_indexer(info["date"]), env.tape.part
    rng, rewards, positions = np.random.default_rng(0), np.zeros(LANES), np.zeros((LANES, len(part)), int)
    for step in range(40):
        _, reward, _, _, info = env.step(rng.integers(3, size=LANES))
        rewards += reward
        assert rewards == pytest.approx(info["log_equity"], abs=1e-12)
        positions[lanes, first + step] = side * info["position"]
    money = account(part, positions, cost=0.003, fill=fill).log_equity
    assert rewards == pytest.approx(money[lanes, first + 40], abs=1e-12)


@each_side
@pytest.mark.parametrize("encoder", SIGHTS)
def test_its_spaces_are_those_of_its_lanes(encoder, side):
    ours, theirs = both(encoder, side, num_envs=3)
    for name in ("observation_space", "action_space", "single_observation_space", "single_action_space", "num_envs"):
        assert getattr(ours, name) == getattr(theirs, name), name
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    observations, _ = ours.reset(seed=0)
    assert ours.observation_space.contains(observations)


def test_its_defaults_are_those_of_its_lanes():
    prices = random_bars(80)
    encoder = ReturnsEncoder(3).fit(prices["close"])
    ours, single = SideVectorEnv(prices, encoder, side=1, num_envs=1), SideEnv(prices, encoder, side=1)
    assert np.array_equal(ours.reset(seed=4)[0][0], single.reset(seed=4)[0])
    for action in [1, 0, 2, 1, 1] * 15:
        _, mine, *_ = ours.step(np.array([action]))
        assert mine[0] == single.step(action)[1]


def test_what_it_gives_away_is_the_takers_own():
    given, kept = both("network", 1, episode_length=9)[0], both("network", 1, episode_length=9)[0]
    mine, other = given.reset(seed=0), kept.reset(seed=0)
    rng = np.random.default_rng(3)
    for _ in range(30):
        for array in (mine[0], *mine[-1].values()):
            array[:] = np.zeros_like(array)
        actions = rng.integers(3, size=LANES)
        mine, other = given.step(actions), kept.step(actions)
        assert_same(mine, other)


BAD_ACTIONS = [[0, 1], [0, 1, 3], [0, -1, 2], [0.0, 1.0, 2.0], ["hold"] * 3, None, 1, [[0, 1, 2]], [True, False, True]]


@pytest.mark.parametrize("actions", BAD_ACTIONS)
def test_what_are_no_actions_is_a_clear_error_and_no_step(actions):
    env, _ = both("table", 1, num_envs=3)
    env.reset(seed=0)
    before = env.step(np.array([1, 0, 1]))[-1]
    with pytest.raises(ValueError, match="actions must be 3 whole numbers from 0 to 2, got"):
        env.step(actions)
    after = env.step(np.zeros(3, int))[-1]
    assert np.array_equal(after["position"], before["position"])
    assert (after["date"] > before["date"]).all()
    assert np.array_equal(env.tape.dates.get_indexer(after["date"]), env.tape.dates.get_indexer(before["date"]) + 1)


def test_nothing_is_done_before_the_first_reset():
    env, _ = both("table", 1)
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\) before step\(\)"):
        env.step(np.zeros(LANES, int))


@pytest.mark.parametrize("seed", [[1, 2], [1] * 8, 2.5, []])
def test_seeds_that_are_not_one_a_lane_are_refused(seed):
    env, _ = both("table", 1, episode_length=20)
    env.reset(seed=1)
    with pytest.raises(ValueError, match="seed must be a number, or a list of 7, one a lane, got"):
        env.reset(seed=seed)
    wanted, _ = both("table", 1, episode_length=20)
    wanted.reset(seed=1)
    assert_same(env.reset(), wanted.reset())


@pytest.mark.parametrize("num_envs", [0, -1, 2.0, None, "many"])
def test_a_number_of_lanes_that_makes_no_sense_is_refused(num_envs):
    with pytest.raises(PriceDataError, match="num_envs must be"):
        both("table", 1, num_envs=num_envs)


@pytest.fixture
def one_thread():
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.mark.usefixtures("one_thread")
@pytest.mark.parametrize("encoder", ["table", "network"])
@pytest.mark.parametrize("mask_actions", [False, True])
def test_networks_train_in_it(encoder, mask_actions):
    ours, theirs = (
        DQNAgent(env, replay=200, batch_size=8, mask_actions=mask_actions, epsilon=0.5, seed=1)
        for env in both(encoder, 1, num_envs=3, episode_length=20)
    )
    for agents in (ours, theirs):
        agents.train(num_steps=60)
    assert ours.num_agents == 3
    assert np.array_equal(ours.weights, theirs.weights)
    assert np.array_equal(ours.history.episode_return, theirs.history.episode_return, equal_nan=True)
    assert ours.history.episode_length.shape[0] == 3


def test_single_environments_of_the_same_seeds_agree_with_its_lanes():
    env, _ = both("table", 1, episode_length=20)
    _, info = env.reset(seed=40)
    for lane in range(LANES):
        alone = side_env(crashing(), episode_length=20)
        assert alone.reset(seed=40 + lane)[1]["date"] == info["date"][lane]
