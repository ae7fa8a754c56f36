"""Worlds side by side: each agent has its own, and nothing is learned across the border between two episodes."""

import threading

import gymnasium
import numpy as np
import pytest
from dqn_worlds import Chance, Counted, everything, learned, remembered
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import RecordEpisodeStatistics
from hypothesis import given, settings
from hypothesis import strategies as st
from test_q_table import WORLDS as TABLES
from test_q_table import Corridor, OneRoom

from course_lib import DQNAgent, Maze
from course_lib.dqn import draws, lanes
from course_lib.dqn.draws import Draws
from course_lib.files import generator_in

every_mode = pytest.mark.parametrize("mode", list(AutoresetMode), ids=lambda mode: mode.value)
LENGTHS = [[3, 5], [4], [1, 6, 2], [1]]


def side_by_side(makers, mode, **more):
    return SyncVectorEnv(makers, autoreset_mode=mode, **more)


def counted(mode, lengths=LENGTHS, **more):
    return side_by_side([lambda own=own: Counted(own) for own in lengths], mode, **more)


# --- vector environments ----------------------------------------------------------------------------------------------


@every_mode
@pytest.mark.parametrize("copy", [True, False])
def test_each_agent_remembers_its_own_steps_one_after_the_other_and_none_across_a_border(mode, copy):
    agent = DQNAgent(counted(mode, copy=copy), gamma=0.5, replay=100, batch_size=2)
    stored = remembered(agent)
    record = agent.train(num_steps=60)
    for i, own in enumerate(LENGTHS):
        assert len(stored[i]) == 60
        lengths, step_before, episode_before = [], 0, -1
        for transition in stored[i]:
            (episode, step), (next_episode, next_step) = transition["observation"], transition["next_observation"]
            last = next_step == own[int(episode) % len(own)]
            assert step == step_before
            assert (episode > episode_before) if step == 0 else (episode == episode_before)
            assert (next_episode, next_step, transition["reward"]) == (episode, step + 1, step + 1)
            assert transition["discount"] == (0.0 if last and episode % 2 == 0 else 0.5)
            lengths += [int(next_step)] if last else []
            step_before, episode_before = (0 if last else next_step), episode
        assert record.episode_length[i, : len(lengths)].tolist() == lengths
        assert not record.episode_length[i, len(lengths) :].any()


@every_mode
def test_every_agent_plays_as_many_episodes_as_were_asked_for_and_rests_while_the_others_go_on(mode):
    agent = DQNAgent(counted(mode, [[2], [11], [1]]), replay=100, batch_size=2)
    stored, learn, changes = remembered(agent), agent._learn, []

    def noted(passed, batch, learning):
        before = agent._online.flat.clone()
        learn(passed, batch, learning)
        changes.append(((agent._online.flat != before).any(dim=1).tolist(), learning.tolist()))

    agent._learn = noted
    record = agent.train(4)
    assert record.episode_length.tolist() == [[2] * 4, [11] * 4, [1] * 4]
    assert record.episode_return.tolist() == [[3.0] * 4, [66.0] * 4, [1.0] * 4]
    assert [len(own) for own in stored] == [8, 44, 4]
    assert agent._adam.updates.tolist() == [7, 43, 3]
    assert agent._memory.count.tolist() == [8, 44, 4]
    assert all(changed == learning for changed, learning in changes)
    assert agent.train(2).episode_length.tolist() == [[2] * 2, [11] * 2, [1] * 2]


@every_mode
@pytest.mark.parametrize("switches", [{}, {"replay": 30, "batch_size": 4, "target_update": 5, "double": True}])
@pytest.mark.parametrize(
    "make",
    [lambda: Corridor(7, 3), lambda: Counted([3, 5, 1]), lambda: OneRoom(True, False)],
    ids=["states by number", "vectors", "an end at every step"],
)
def test_where_nothing_is_by_chance_lanes_of_any_kind_teach_the_same_to_the_last_bit(make, mode, switches):
    single = DQNAgent(make(), num_agents=3, epsilon=0.9, **switches)
    vector = DQNAgent(side_by_side([make] * 3, mode), epsilon=0.9, **switches)
    for agent in (single, vector):
        agent.train(num_steps=70)
    assert everything(vector) == everything(single)
    for agent in (single, vector):
        agent.train(3)
    assert vector.history.episode_length.shape == (3, 3)


@every_mode
def test_only_lanes_that_can_be_begun_by_hand_are_cut_by_max_steps(mode):
    agent = DQNAgent(counted(mode, [[5], [9]]))
    record = agent.train(2, max_steps=4)
    by_hand = mode == AutoresetMode.DISABLED
    assert record.episode_length.tolist() == ([[4, 4], [4, 4]] if by_hand else [[5, 5], [9, 9]])


@every_mode
def test_an_episode_under_way_in_a_vector_environment_is_given_up_for_a_new_one(mode):
    """What it does cannot be had again, so the next call begins anew and counts from there."""
    agent = DQNAgent(counted(mode, [[5], [9]]))
    agent.train(num_steps=7)
    assert agent._underway.steps.tolist() == [2, 7]
    record = agent.train(1)
    assert record.episode_length.tolist() == [[5], [9]]
    assert record.episode_return.tolist() == [[15.0], [45.0]]


@every_mode
def test_no_two_lanes_see_the_same_world_one_after_the_other(mode):
    """All end together, so that all begin together: with seeds that only count up, one would follow the other."""
    agent = DQNAgent(side_by_side([Chance] * 3, mode), replay=100, batch_size=2)
    stored = remembered(agent)
    agent.train(num_steps=40)
    seen = np.array([[transition["observation"] for transition in own] for own in stored])
    assert np.unique(seen).size == 3 * 40


@every_mode
def test_the_seed_decides_what_a_vector_environment_does(mode):
    first, again, other = (DQNAgent(side_by_side([Chance] * 2, mode), seed=seed) for seed in (1, 1, 3))
    for agent in (first, again, other):
        agent.train(num_steps=30)
    assert everything(first) == everything(again)
    assert everything(first)["weights"] != everything(other)["weights"]
    before = learned(first)
    first.test(2)
    assert learned(first) == before
    for agent in (first, again):
        agent.train(3)
    assert everything(first) == everything(again)


@every_mode
def test_walks_in_a_vector_environment_are_whole(mode):
    agent = DQNAgent(counted(mode))
    walks = agent.test(3)
    assert len(walks) == 4 * 3
    for i, walk in enumerate(walks):
        [episode], own = np.unique(walk.states[:, 0]), LENGTHS[i // 3]
        assert walk.states[:, 1].tolist() == list(range(own[int(episode) % len(own)] + 1))
        assert walk.rewards.tolist() == walk.states[1:, 1].tolist()
        assert walk.terminated == (episode % 2 == 0) != walk.truncated


@every_mode
def test_a_walk_that_cannot_be_cut_says_so(mode):
    agent = DQNAgent(counted(mode, [[3], [9]]))
    assert [len(walk) for walk in agent.test(1, max_steps=4)] == [3, 4]
    if mode == AutoresetMode.DISABLED:
        assert [len(walk) for walk in agent.test(2, max_steps=4)] == [3, 3, 4, 4]
        return
    with pytest.raises(ValueError, match="lane 1 is not over after 4 steps: max_steps cannot cut it"):
        agent.test(2, max_steps=4)


def test_gymnasiums_own_vector_environment_is_learned_from_by_the_laws_of_its_world():
    """A step of a cart moves it by its speed; a step across a border would put it back into the middle."""
    env = gymnasium.make_vec("CartPole-v1", num_envs=4, vectorization_mode="vector_entry_point")
    agent = DQNAgent(env, replay=300, batch_size=4, epsilon=1.0)
    stored = remembered(agent)
    record = agent.train(num_steps=200)
    assert agent.num_agents == 4
    assert (record.episode_length > 0).sum(axis=1).min() >= 4
    for i, own in enumerate(stored):
        before, after = (np.stack([t[name] for t in own]) for name in ("observation", "next_observation"))
        np.testing.assert_allclose(after[:, [0, 2]], before[:, [0, 2]] + 0.02 * before[:, [1, 3]], atol=1e-6)
        ends = np.flatnonzero([t["discount"] == 0 for t in own])
        assert np.diff(ends, prepend=-1).tolist() == record.episode_length[i, : len(ends)].tolist()
        assert [t["reward"] for t in own] == [1.0] * 200
        assert (np.abs(before[ends[:-1] + 1]) <= 0.05).all()


@every_mode
def test_a_vector_environment_has_a_lane_an_agent(mode):
    env = counted(mode)
    assert DQNAgent(env).num_agents == DQNAgent(env, num_agents=4).num_agents == 4
    with pytest.raises(ValueError, match="got 4 lanes for 3 agents"):
        DQNAgent(env, num_agents=3)


# --- copies and tables ------------------------------------------------------------------------------------------------


class Locked(Chance):
    """Nobody can copy a lock."""

    def __init__(self):
        self.lock = threading.Lock()


def test_an_environment_that_cannot_be_copied_serves_one_agent_and_says_so_to_more():
    one, two = DQNAgent(Locked()), DQNAgent(Locked(), num_agents=2)
    assert len(one.train(2)) == 2
    before = everything(two)
    for call in (two.train, two.test):
        with pytest.raises(ValueError, match=r"cannot copy .*Locked.* for 2 agents \(.*\): give a VectorEnv"):
            call(2)
    assert everything(two) == before


def test_agents_do_not_share_a_world():
    agent = DQNAgent(Counted([3, 5]), num_agents=3, replay=50, batch_size=2)
    stored = remembered(agent)
    agent.train(num_steps=20)
    assert [[t["observation"].tolist() for t in own] for own in stored[1:]] == [
        [t["observation"].tolist() for t in stored[0]]
    ] * 2


@pytest.mark.parametrize("world", TABLES.values(), ids=TABLES.keys())
def test_a_table_tells_what_the_world_itself_would_tell_number_by_number(world):
    """Three lanes, 400 steps at random, now and then one that stands still, new episodes where one ended or earlier."""
    table, plain = lanes.lanes_of(world(), 3), lanes.lanes_of(RecordEpisodeStatistics(world()), 3)
    assert type(table) is lanes.TableLanes
    assert type(plain) is lanes.EnvLanes
    rng, begin = np.random.default_rng(0), np.ones(3, bool)
    for step in range(400):
        if begin.any():
            seeds = rng.integers(2**31, size=3)
            for side in (table, plain):
                side.begin(begin, seeds)
        assert table.observations.tolist() == plain.observations.tolist()
        moving, actions = rng.random(3) < 0.9, rng.integers(plain.envs[0].action_space.n, size=3)
        told, expected = (side.step(actions, moving) for side in (table, plain))
        for ours, theirs in zip(told, expected, strict=True):
            assert np.asarray(ours)[moving].tolist() == np.asarray(theirs)[moving].tolist()
        begin = moving & (expected[2] | expected[3] | (rng.random(3) < 0.002))


def test_an_episode_that_cannot_be_had_again_is_begun_anew():
    """It has become shorter than what had been played of it, for those agents that had played as much."""
    env = Counted([100])
    agent = DQNAgent(env, num_agents=2)
    agent.train(num_steps=7)
    assert agent._underway.steps.tolist() == [7, 7]
    env.lengths = [5]
    record = agent.train(1)
    assert record.episode_length.tolist() == [[5], [5]]
    assert record.episode_return.tolist() == [[15.0], [15.0]]


# --- random numbers ---------------------------------------------------------------------------------------------------


@settings(derandomize=True, deadline=None, max_examples=25)
@given(st.integers(1, 4), st.integers(1, 9), st.sampled_from([1, 7, 64, 2**18]), st.integers(0, 100))
def test_rows_are_what_each_generator_would_draw_one_after_the_other_however_far_ahead(agents, width, ahead, seed):
    """And at every step, the first too, the states are those of generators that go on with the current row."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(draws, "_NUMBERS_AT_ONCE", ahead)
        ours = Draws([np.random.default_rng(seed + i) for i in range(agents)], width)
    plain = [np.random.default_rng(seed + i) for i in range(agents)]
    rng, expected = np.random.default_rng(seed), np.stack([generator.random(width) for generator in plain])
    for _ in range(40):
        if rng.random() < 0.8:
            assert ours.rows().tolist() == expected.tolist()
        states = ours.states()
        assert [generator_in(state).random(width).tolist() for state in states] == expected.tolist()
        assert ours.rows().tolist() == expected.tolist()
        spent = rng.random(agents) < 0.7
        ours.spend(spent)
        for i in np.flatnonzero(spent):
            expected[i] = plain[i].random(width)


def test_long_rows_of_many_agents_are_drawn_right_over_several_blocks():
    ours = Draws([np.random.default_rng(i) for i in range(3)], 5)
    plain = [np.random.default_rng(i) for i in range(3)]
    for _ in range(600):
        expected = [generator.random(5).tolist() for generator in plain]
        assert ours.rows().tolist() == expected
        ours.spend(np.ones(3, bool))


def test_an_agents_generator_goes_on_after_its_weights_and_its_first_seed():
    agent = DQNAgent(Maze(slip=0.2), num_agents=2, seed=8, replay=10, batch_size=3, hidden=(5,))
    for i in range(2):
        rng = np.random.default_rng(8 + i)
        rng.uniform(size=16 * 5 + 5 * 4)
        assert agent._underway.first_seeds[i] == rng.integers(2**31)
        assert agent._draws.rows()[i].tolist() == rng.random(5).tolist()
