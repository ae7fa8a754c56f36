"""Training counts right, goes on where it was, and leaves alone what is not its own."""

import random
import signal
import warnings

import gymnasium
import numpy as np
import pytest
import torch
from dqn_worlds import SWITCHES, WORLDS, Chance, Counted, everything, learned, watched
from gymnasium.wrappers import RecordEpisodeStatistics
from test_q_table import OneRoom

from course_lib import DQNAgent, Maze

MEMORY = SWITCHES["everything"]
every_world = pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())


def rows_of(agent, i):
    """All that training changes of agent i, but for the history."""
    return {name: rows[i] for name, rows in learned(agent).items() if name != "actions"}


# --- how long ---------------------------------------------------------------------------------------------------------


@every_world
def test_every_agent_plays_exactly_as_many_episodes_as_were_asked_for(world):
    agent = DQNAgent(world(), num_agents=4, **MEMORY)
    steps = watched(agent)
    record = agent.train(7, max_steps=40)
    assert record is agent.history
    assert record.episode_return.shape == record.episode_length.shape == (4, 7)
    assert (record.episode_length > 0).all()
    assert (record.terminated != record.truncated).all()
    played = np.array([stepped for _, _, stepped in steps])
    assert played.sum(axis=0).tolist() == record.episode_length.sum(axis=1).tolist()
    assert agent._underway.steps.tolist() == [0] * 4


def test_an_agent_that_has_finished_is_left_as_it_is_to_the_last_bit():
    """Together they play until the slowest has finished; none is further then than it would be alone."""
    agent = DQNAgent(Maze(slip=0.2, step_reward=-0.1), num_agents=5, **MEMORY)
    step, seen = agent._step, []

    def noted(lanes, playing, *rest):
        before = [rows_of(agent, i) for i in range(5)]
        stepped = step(lanes, playing, *rest)
        seen.append((playing.copy(), [rows_of(agent, i) != before[i] for i in range(5)]))
        return stepped

    agent._step = noted
    agent.train(3)
    assert {tuple(playing) for playing, _ in seen} > {(True,) * 5}, "some finish before the others"
    for playing, changed in seen:
        assert playing.tolist() == changed


@pytest.mark.parametrize("wrap", [lambda env: env, RecordEpisodeStatistics], ids=["table", "plain"])
def test_every_agent_makes_exactly_as_many_steps_as_were_asked_for(wrap):
    agent = DQNAgent(wrap(Maze(slip=0.2)), num_agents=4)
    steps = watched(agent)
    record = agent.train(num_steps=73)
    assert len(steps) == 73
    assert all(stepped.all() for _, _, stepped in steps)
    assert (record.episode_length.sum(axis=1) + agent._underway.steps).tolist() == [73] * 4
    np.testing.assert_allclose(
        np.nansum(record.episode_return, axis=1) + agent._underway.returns, sum(rewards for _, rewards, _ in steps)
    )


def test_agents_with_fewer_episodes_have_empty_places_at_the_end():
    agent = DQNAgent(Maze(slip=0.2), num_agents=6)
    steps = watched(agent)
    record = agent.train(num_steps=60)
    played = record.episode_length > 0
    counts = played.sum(axis=1)
    assert len(set(counts.tolist())) > 1
    assert len(record) == counts.max()
    assert (played == (np.arange(len(record)) < counts[:, None])).all()
    for array in (record.terminated, record.truncated):
        assert not array[~played].any()
    assert (record.terminated[played] != record.truncated[played]).all()
    assert (np.isnan(record.episode_return) == ~played).all()
    for i in range(6):
        ends = np.cumsum(record.episode_length[i, : counts[i]])
        rewards = np.array([rewards[i] for _, rewards, _ in steps])
        assert [part.sum() for part in np.split(rewards, ends)[:-1]] == record.episode_return[i, : counts[i]].tolist()


def test_episodes_and_steps_may_be_limited_together():
    agent = DQNAgent(OneRoom(False, False))
    assert agent.train(3, num_steps=100, max_steps=5).episode_length.tolist() == [[5, 5, 5]]
    assert agent.train(3, num_steps=12, max_steps=5).episode_length.tolist() == [[5, 5]]
    assert agent.train(1, max_steps=5).episode_length.tolist() == [[5]], "two of its steps were made before"


def test_training_for_nothing_changes_nothing():
    agent = DQNAgent(Maze(slip=0.2), num_agents=2, **MEMORY)
    agent.train(num_steps=33)
    before = learned(agent)
    assert agent.train(0).episode_return.shape == (2, 0)
    assert agent.train(num_steps=0).episode_return.shape == (2, 0)
    assert learned(agent) == before


@every_world
@pytest.mark.parametrize("switches", [{}, MEMORY], ids=["latest transition", "memory"])
def test_training_in_parts_is_training_once(world, switches):
    """By steps, so that the parts end in the middle of episodes, and then by episodes."""
    whole, parts = (DQNAgent(world(), num_agents=2, **switches) for _ in range(2))
    records = [whole.train(num_steps=100), *(parts.train(num_steps=n) for n in (1, 46, 0, 53))]
    assert learned(parts) == learned(whole)
    for i in range(2):
        lengths = [record.episode_length[i][record.episode_length[i] > 0] for record in records]
        assert np.concatenate(lengths[1:]).tolist() == lengths[0].tolist()
    for agent, numbers in ((whole, [5]), (parts, [2, 0, 3])):
        for number in numbers:
            agent.train(number, max_steps=30)
    assert learned(parts) == learned(whole)


def test_epsilon_decays_with_each_agents_own_episodes():
    agent = DQNAgent(Maze(slip=0.2), num_agents=4, epsilon=0.8, epsilon_decay=0.75)
    record = agent.train(num_steps=50)
    counts = (record.episode_length > 0).sum(axis=1)
    assert len(set(counts.tolist())) > 1
    np.testing.assert_allclose(agent.epsilon, 0.8 * 0.75**counts, rtol=1e-12)


@pytest.mark.parametrize("epsilon", [0.0, 0.3, 1.0])
def test_a_share_epsilon_of_the_actions_is_random(epsilon):
    agent = DQNAgent(OneStateManyActions(), num_agents=10, epsilon=epsilon, epsilon_decay=1.0, learning_rate=1e-9)
    steps, best = watched(agent), agent.q_values([0])[:, 0].argmax(axis=1)
    agent.train(num_steps=400)
    greedy = np.mean([actions == best for actions, _, _ in steps])
    assert greedy == pytest.approx(1 - epsilon + epsilon / 8, abs=0.03 * (epsilon > 0))
    assert (np.unique([actions for actions, _, _ in steps]).size == 8) == (epsilon > 0)


class OneStateManyActions(OneRoom):
    action_space = gymnasium.spaces.Discrete(8)

    def __init__(self):
        super().__init__(False, False)

    def step(self, action):
        return super().step(0 * action)


def test_learning_begins_when_there_are_as_many_transitions_as_a_batch_takes():
    agent = DQNAgent(Maze(), num_agents=2, replay=20, batch_size=6)
    start = agent._online.flat.clone()
    agent.train(num_steps=5)
    assert torch.equal(agent._online.flat, start)
    agent.train(num_steps=1)
    assert agent._adam.updates.tolist() == [1, 1]
    assert (agent._online.flat != start).any(dim=1).all()


def test_the_memory_holds_the_latest_transitions_and_no_others():
    agent = DQNAgent(Counted([4, 7, 5]), replay=10, batch_size=2)
    agent.train(num_steps=37)
    memory = {name: tensor.numpy() for name, tensor in agent._memory.tensors.items()}
    assert agent._memory.count.tolist() == [37]
    seen, following = memory["observation"], memory["next_observation"]
    expected = [(k, step) for k, length in enumerate([4, 7, 5, 4, 7, 5, 4, 7]) for step in range(length)][27:37]
    assert sorted(map(tuple, seen.tolist())) == expected
    assert (following == seen + np.array([0, 1])).all()
    assert (memory["reward"] == following[:, 1]).all()


# --- what is not its own ----------------------------------------------------------------------------------------------


def everything_shared():
    """What belongs to all who run in this process."""
    return (
        (torch.get_num_threads(), torch.is_grad_enabled(), torch.get_default_dtype()),
        takes_tiny_numbers_for_zero(),
        (random.getstate(), repr(np.random.get_state()), torch.get_rng_state().numpy().tobytes()),  # noqa: NPY002
        (list(warnings.filters), np.geterr(), signal.getsignal(signal.SIGINT)),
    )


@pytest.fixture(params=[(2, True, False), (3, False, True)], ids=["as usual", "as somebody set it"])
def shared(request):
    """All of it in two states, and as it was afterwards."""

    def share(threads, grad, flush):
        torch.set_num_threads(threads)
        torch.set_grad_enabled(grad)
        torch.set_flush_denormal(flush)

    before = torch.get_num_threads(), torch.is_grad_enabled(), takes_tiny_numbers_for_zero()
    share(*request.param)
    yield
    share(*before)


def takes_tiny_numbers_for_zero():
    return float(torch.full((8,), 1e-39).mul_(0.5).max()) == 0.0


@pytest.mark.usefixtures("shared")
@pytest.mark.parametrize("world", ["slippery maze", "cart pole"])
def test_nothing_that_all_share_is_changed(world, tmp_path):
    before = everything_shared()
    agent = DQNAgent(WORLDS[world](), num_agents=2, **MEMORY)
    agent.train(3)
    agent.q_values(agent.test(2)[0].states)
    agent.save(tmp_path / "agent")
    DQNAgent.load(tmp_path / "agent", WORLDS[world]()).train(num_steps=5)
    assert everything_shared() == before


class Broken(Chance):
    """It raises once, in the step or the reset of that number."""

    def __init__(self, where, number):
        self.where, self.number = where, number

    def _count(self, where):
        self.number -= where == self.where
        if where == self.where and self.number == 0:
            raise RuntimeError("out of order")

    def reset(self, **arguments):
        self._count("reset")
        return super().reset(**arguments)

    def step(self, action):
        self._count("step")
        return super().step(action)


@pytest.mark.usefixtures("shared")
@pytest.mark.parametrize("switches", [{}, MEMORY], ids=["latest transition", "memory"])
@pytest.mark.parametrize(("where", "number"), [("step", 1), ("step", 22), ("reset", 1), ("reset", 5)])
def test_an_error_in_the_world_changes_nothing_and_training_goes_on_after_it(where, number, switches):
    agent, unbroken = DQNAgent(Broken(where, number), **switches), DQNAgent(Chance(), **switches)
    before, made = everything_shared(), watched(agent)
    with pytest.raises(RuntimeError, match="out of order"):
        agent.train(num_steps=40)
    assert everything_shared() == before
    assert len(agent.history) == len(made) // 4
    agent.train(num_steps=40 - len(made))
    unbroken.train(num_steps=40)
    assert learned(agent) == learned(unbroken)


class Peeking(Chance):
    """It looks at what the training has made of torch, for as long as it lasts."""

    def step(self, action):
        self.seen = torch.get_num_threads(), torch.is_grad_enabled(), takes_tiny_numbers_for_zero()
        return super().step(action)


@pytest.mark.usefixtures("shared")
def test_small_tensors_are_computed_with_one_thread_without_a_tape_and_without_tiny_numbers():
    before = takes_tiny_numbers_for_zero()
    possible = torch.set_flush_denormal(True)
    torch.set_flush_denormal(before)
    agent = DQNAgent(Peeking())
    for call in (agent.train, agent.test):
        agent.env.seen = None
        call(1)
        assert agent.env.seen == (1, False, possible)


def test_a_bar_changes_nothing_and_goes_to_stderr(capsys):
    quiet, by_episodes, by_steps = (DQNAgent(Maze(), num_agents=2) for _ in range(3))
    quiet.train(10)
    assert capsys.readouterr().err == ""
    for agent, arguments, words in (
        (by_episodes, {"num_episodes": 10}, ("/20", "episode")),
        (by_steps, {"num_steps": 60}, ("/60", "step")),
    ):
        agent.train(progress=True, **arguments)
        shown = capsys.readouterr()
        assert all(word in shown.err for word in words)
        assert shown.out == ""
    assert everything(quiet) == everything(by_episodes)
