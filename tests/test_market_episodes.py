"""Episodes on one side of one share: how they begin and end, and the table that they are."""

import gymnasium
import numpy as np
import pytest
from market_worlds import FILLS, SIGHTS, bars, played, random_bars, side_env

from course_lib import QAgent
from course_lib.market import MinMaxEncoder, RubberBandMarket, SideEnv, split

HOLD, OPEN, CLOSE = range(3)
each_side = pytest.mark.parametrize("side", [1, -1])
each_fill = pytest.mark.parametrize("fill", FILLS)


# --- beginnings and ends ----------------------------------------------------------------------------------------------


def test_the_end_of_the_data_truncates():
    prices = random_bars(50)
    _, _, terminated, truncated, infos = played(side_env(prices), [OPEN] + [HOLD] * 100)
    assert len(infos) == 48
    assert truncated == [False] * 47 + [True]
    assert not any(terminated)
    assert (infos[0]["date"], infos[-1]["date"]) == (prices.index[2], prices.index[-1])


@pytest.mark.filterwarnings("ignore:split or crash")
@pytest.mark.parametrize("last", [False, True])
def test_ruin_terminates_and_does_not_truncate(last):
    values = [100, 100, 100, 100, 200] + ([] if last else [100, 100])
    env = SideEnv(bars(values, values), MinMaxEncoder(None).fit(values), side=-1, fill="close", cost=0.0)
    _, rewards, terminated, truncated, infos = played(env, [HOLD, OPEN, HOLD, HOLD, HOLD])
    assert terminated == [False] * 4 + [True]
    assert not any(truncated)
    assert rewards[-1] == infos[-1]["log_equity"] == np.log(1e-6)
    env.reset()
    assert env.step(HOLD)[1] == 0, "and the next episode begins with money"


def test_episodes_have_their_length_and_begin_anywhere():
    prices = random_bars(60)
    env, starts, place = side_env(prices, episode_length=50), set(), {d: i for i, d in enumerate(prices.index)}
    for seed in range(200):
        *_, truncated, infos = played(env, [HOLD] * 60, seed)
        assert truncated == [False] * 50 + [True]
        starts.add(place[infos[0]["date"]])
        assert place[infos[-1]["date"]] - place[infos[0]["date"]] == 50
    assert starts == set(range(2, 10)), "from the first bar to the last that leaves 50 moves"


def test_the_seed_decides_everything_and_episodes_without_one_differ():
    env = side_env(episode_length=20)
    first = [env.reset(seed=5)[1]["date"]] + [env.reset()[1]["date"] for _ in range(30)]
    other = side_env(episode_length=20)
    other.reset(seed=1)
    assert [other.reset(seed=5)[1]["date"]] + [other.reset()[1]["date"] for _ in range(30)] == first
    assert len(set(first)) > 15
    assert first != [env.reset(seed=6)[1]["date"]] + [env.reset()[1]["date"] for _ in range(30)]


def test_a_new_episode_begins_out_of_the_market():
    env = side_env(episode_length=20)
    env.reset(seed=0)
    env.step(OPEN)
    _, info = env.reset()
    assert (info["position"], info["trades"], info["log_equity"], info["invalid"]) == (0, 0, 0.0, False)


def test_nothing_is_done_before_the_first_episode_or_after_the_end_of_one():
    env = side_env(episode_length=2)
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\) before step\(\)"):
        env.step(HOLD)
    played(env, [HOLD, HOLD])
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(HOLD)
    env.reset()
    env.step(HOLD)


@pytest.mark.parametrize("action", [-1, 3, 0.5, 1.0, float("nan"), "open", None, [1], np.array([1]), np.float64(1.0)])
def test_what_is_no_action_is_a_clear_error_and_no_step(action):
    env = side_env()
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"action must be 0 \(hold\), 1 \(open\) or 2 \(close\), got "):
        env.step(action)
    assert env.step(HOLD)[4]["date"] == random_bars(120).index[3]


@pytest.mark.parametrize("action", [1, np.int64(1), np.uint8(1), np.array(1), True])
def test_whole_numbers_of_every_kind_are_actions(action):
    env = side_env()
    env.reset(seed=0)
    *_, info = env.step(action)
    assert (info["position"], info["invalid"]) == (1, False)


# --- as a table -------------------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore:split or crash")
@each_side
@each_fill
@pytest.mark.parametrize("encoder", SIGHTS)
def test_its_table_is_itself_stepped(encoder, fill, side):
    """Every state, every action: the same place, the same reward, the same end, the same sight."""
    close = random_bars(30)["close"].to_numpy().copy()
    close[12:] *= 2.5
    prices = bars(close, close)
    env = side_env(prices, encoder, side, fill=fill, cost=0.01, episode_length=9, reward_unit=0.1)
    told, n = env.as_table_world(), env.tape.bars
    mdp, observed = told["mdp"], told["observed"]
    assert (told["time_limit"], told["starts"], n) == (9, range(n - 9), len(env.tape.dates))
    ends = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        seen, info = env.reset(seed=seed)
        state, steps, over = told["starts"][int(np.random.default_rng(seed).random() * len(told["starts"]))], 0, False
        while not over:
            assert info["date"] == env.tape.dates[state % n]
            assert info["position"] == state // n
            assert np.array_equal(seen, observed[state])
            assert told["possible"][state].tolist() == info["action_mask"].astype(bool).tolist()
            action = rng.integers(3)
            seen, reward, terminated, truncated, info = env.step(action)
            assert reward == mdp.reward[state, action, 0]
            assert terminated == mdp.terminal[state, action, 0]
            state, steps, ends = mdp.next_state[state, action, 0], steps + 1, ends + terminated
            over = terminated or truncated
            assert truncated == (steps == 9 and not terminated)
    assert ends > 0 or side == 1


@each_side
def test_agents_learn_the_same_in_it_as_a_table_and_stepped(side):
    """The compiled loop takes the table; a subclass is stepped, as it might play by other rules."""

    class Stepped(SideEnv):
        pass

    parts = split(RubberBandMarket().prices(400, seed=3), warmup=10)
    encoder = MinMaxEncoder(10, levels=4).fit(parts.training.close)
    agents = [
        QAgent(kind(parts.training, encoder, side=side, episode_length=60), mask_actions=True, epsilon=0.5, seed=2)
        for kind in (SideEnv, Stepped)
    ]
    records = [agent.train(40) for agent in agents]
    assert np.array_equal(agents[0].q_table, agents[1].q_table)
    assert agents[0].q_table[4:, 2].any()
    assert np.array_equal(records[0].episode_return, records[1].episode_return)
