"""What the agents say and where they go, whatever their world calls its states and actions."""

import gymnasium
import numpy as np
import pytest
import torch
from dqn_worlds import SWITCHES, WORLDS, Chance, Counted, everything
from gymnasium.wrappers import RecordEpisodeStatistics
from test_q_table import Corridor

from course_lib import DQNAgent, Maze

MEMORY = SWITCHES["everything"]
every_world = pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())


# --- walks ------------------------------------------------------------------------------------------------------------


@every_world
def test_a_walk_teaches_nothing_and_does_not_disturb_the_training(world):
    walked, unwalked = (DQNAgent(world(), num_agents=3, **MEMORY) for _ in range(2))
    for agent in (walked, unwalked):
        agent.train(num_steps=61)
    before, record = everything(walked), walked.history
    walked.test(2, max_steps=30)
    assert everything(walked) == before
    assert walked.history is record
    for agent in (walked, unwalked):
        agent.train(num_steps=40)
    assert everything(walked) == everything(unwalked)


@every_world
def test_walks_are_greedy_come_agent_by_agent_and_the_same_again(world):
    together = DQNAgent(world(), num_agents=3, seed=5)
    together.train(num_steps=40)
    walks, again, other = (together.test(4, max_steps=25, seed=seed) for seed in (0, 0, 1))
    assert len(walks) == 3 * 4
    for i, walk in enumerate(walks):
        q = together.q_values(walk.states)[i // 4]
        assert walk.actions.tolist() == q[:-1].argmax(axis=1).tolist()
        assert walk.terminated != walk.truncated
        assert len(walk.states) == len(walk) + 1 <= 26
    assert told(again) == told(walks)
    if isinstance(together.env.observation_space, gymnasium.spaces.Box):
        assert len({walk.states[0].tobytes() for walk in walks + other}) == 24, "each begins somewhere else"
    alone = DQNAgent(world(), seed=7)
    alone._online.flat.copy_(together._online.flat[2:])
    assert [walk.states[0].tolist() for walk in alone.test(4)] == [walk.states[0].tolist() for walk in walks[8:]]


def told(walks):
    return [(w.states.tolist(), w.actions.tolist(), w.rewards.tolist(), w.terminated, w.truncated) for w in walks]


def test_a_walk_tells_what_the_world_did():
    agent = DQNAgent(Counted([3, 5]), num_agents=2)
    for walk in agent.test(3):
        [episode], steps = np.unique(walk.states[:, 0]), len(walk)
        assert steps == (3, 5)[int(episode) % 2]
        assert walk.states[:, 1].tolist() == list(range(steps + 1))
        assert walk.rewards.tolist() == list(range(1, steps + 1))
        assert (walk.terminated, walk.truncated) == (episode % 2 == 0, episode % 2 == 1)
        assert walk.rewards.dtype == np.float64


@pytest.mark.parametrize("wrap", [lambda env: env, RecordEpisodeStatistics], ids=["table", "plain"])
def test_a_walk_is_cut_by_its_own_limit_or_the_worlds(wrap):
    agent = DQNAgent(wrap(Maze(wall_ends_episode=False)), num_agents=2)
    limited = DQNAgent(wrap(gymnasium.wrappers.TimeLimit(Maze(wall_ends_episode=False), 4)), num_agents=2)
    for walk in (*agent.test(3, max_steps=4), *limited.test(3)):
        assert (walk.terminated, walk.truncated) == (False, True)
        assert (len(walk), len(walk.states)) == (4, 5)


def test_agents_can_walk_in_another_world_than_they_learn_in():
    walked, unwalked = (DQNAgent(Maze(slip=0.2), num_agents=2, **MEMORY) for _ in range(2))
    for agent in (walked, unwalked):
        agent.train(num_steps=50)
    own, walked.env = walked.env, Maze(wall_ends_episode=False)
    for i, walk in enumerate(walked.test(max_steps=9)):
        q, moves = walked.q_values(walk.states)[i], walked.env.mdp.next_state[:, :, 0]
        assert walk.actions.tolist() == q[:-1].argmax(axis=1).tolist()
        assert walk.states[1:].tolist() == moves[walk.states[:-1], walk.actions].tolist()
    walked.env = own
    for agent in (walked, unwalked):
        agent.train(num_steps=50)
    assert everything(walked) == everything(unwalked)


# --- answers ----------------------------------------------------------------------------------------------------------


@every_world
def test_a_batch_may_be_the_same_for_all_agents_or_each_agents_own(world):
    agent = DQNAgent(world(), num_agents=3)
    batch = np.stack([agent.env.observation_space.sample() for _ in range(7)])
    if batch.dtype != np.int64:
        batch = np.random.default_rng(0).normal(size=batch.shape)
    num_actions, q = int(agent.env.action_space.n), agent.q_values(batch)
    assert (q.dtype, q.shape) == (np.float32, (3, 7, num_actions))
    own = np.stack([batch, batch[::-1], np.roll(batch, 2, axis=0)])
    expected = [q[0], q[1, ::-1], np.roll(q[2], 2, axis=0)]
    np.testing.assert_allclose(agent.q_values(own), expected, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(agent.q_values(batch[:1]), q[:, :1], rtol=1e-5, atol=1e-6)
    assert agent.q_values(batch[:0]).shape == (3, 0, num_actions)
    np.testing.assert_allclose(agent.q_values(batch.tolist()), q, rtol=1e-5, atol=1e-6)


@every_world
@pytest.mark.usefixtures("each_time")
@pytest.mark.filterwarnings("error")
def test_answers_are_the_learners_own_to_write_in_and_come_without_a_warning(world):
    agent = DQNAgent(world())
    batch = np.stack([agent.env.reset(seed=0)[0]])
    batch.flags.writeable = False
    q = agent.q_values(batch)
    before = q.copy()
    q[:] = 7.0
    assert agent.q_values(batch).tobytes() == before.tobytes()


@pytest.fixture
def each_time():
    """torch warns each time, not only the first time in a process."""
    before = torch.is_warn_always_enabled()
    torch.set_warn_always(True)
    yield
    torch.set_warn_always(before)


# --- spaces of all kinds ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("first_state", "first_action"), [(7, 0), (0, 3), (100, -2), (-100, 0)])
def test_states_and_actions_may_begin_at_any_number(first_state, first_action):
    usual, moved = (DQNAgent(env, epsilon=0.9) for env in (Corridor(), Corridor(first_state, first_action)))
    for agent in (usual, moved):
        agent.train(40)
    assert everything(moved) == everything(usual)
    states = first_state + np.arange(5)
    q = usual.q_values(np.arange(5))
    assert moved.q_values(states).tobytes() == q.tobytes()
    assert moved.q_values(states.astype(np.int8)).tobytes() == q.tobytes()
    [walk], [usual_walk] = moved.test(max_steps=20), usual.test(max_steps=20)
    assert len(walk) == 4
    assert walk.states.tolist() == states.tolist()
    assert walk.actions.tolist() == [first_action + 1] * 4
    assert (usual_walk.states + first_state).tolist() == walk.states.tolist()
    usual.env = moved.env
    [walk_there] = usual.test(max_steps=20)
    assert (walk_there.states.tolist(), walk_there.actions.tolist()) == (walk.states.tolist(), walk.actions.tolist())


class Tables(gymnasium.ObservationWrapper):
    """The same observations as 1 x 2 x 2 tables of whole numbers and fractions."""

    def __init__(self, env):
        super().__init__(env)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (1, 2, 2), np.float64)

    def observation(self, observation):
        return np.reshape(observation, (1, 2, 2)).astype(float)


def test_observations_of_several_dimensions_are_flattened_for_the_networks_only():
    flat, tables = (DQNAgent(env, num_agents=2) for env in (WORLDS["cart pole"](), Tables(WORLDS["cart pole"]())))
    for agent in (flat, tables):
        agent.train(num_steps=100)
    assert everything(tables) == everything(flat)
    [walk, _], [usual, _] = tables.test(), flat.test()
    assert walk.states.shape == (len(walk) + 1, 1, 2, 2)
    assert walk.states.tobytes() == usual.states.tobytes()
    assert tables.q_values(walk.states).tobytes() == flat.q_values(usual.states).tobytes()


def test_an_environment_may_be_given_by_its_id():
    by_id, by_hand = DQNAgent("CartPole-v1"), DQNAgent(gymnasium.make("CartPole-v1"))
    for agent in (by_id, by_hand):
        agent.train(3)
    assert everything(by_id) == everything(by_hand)


def test_an_environment_that_reuses_its_observation_is_remembered_right():
    class Reusing(Chance):
        room = np.zeros(1, np.float32)

        def reset(self, **arguments):
            self.room[:] = super().reset(**arguments)[0]
            return self.room, {}

        def step(self, action):
            observation, *rest = super().step(action)
            self.room[:] = observation
            return self.room, *rest

    plain, reusing = (DQNAgent(env, replay=20) for env in (Chance(), Reusing()))
    for agent in (plain, reusing):
        agent.train(num_steps=30)
    assert everything(plain) == everything(reusing)


# --- a world put in another's place -----------------------------------------------------------------------------------


def test_another_world_with_the_same_spaces_can_be_put_in():
    agent = DQNAgent(Maze(wall_reward=0.0), seed=1)
    agent.train(num_episodes=20)
    agent.env = Maze(wall_reward=-5.0, step_reward=-1.0)
    (walk,) = agent.test(max_steps=3)
    assert walk.rewards.max() < 0
    assert agent.train(num_episodes=5).episode_return.max() < 0


@pytest.mark.parametrize(
    ("world", "words"),
    [
        (Maze.random(5, 5), "layers of (16, 20, 4) nodes, this env needs others: (25, 20, 4)"),
        (gymnasium.make("CartPole-v1"), "this env needs others: (4, 20, 2)"),
        (gymnasium.make_vec("CartPole-v1", num_envs=3), "got 3 lanes for 1 agents"),
        (None, "Discrete or Box observation_space, got None"),
    ],
)
@pytest.mark.parametrize("call", [lambda agent: agent.train(num_steps=3), lambda agent: agent.test()])
def test_a_world_that_the_networks_do_not_fit_is_refused(world, words, call):
    agent = DQNAgent(Maze())
    agent.train(num_steps=5)
    before, record, agent.env = agent.weights, agent.history, world
    with pytest.raises(ValueError, match=r"^[^\n]+$") as error:
        call(agent)
    assert words in str(error.value)
    assert (agent.weights == before).all()
    assert agent.history is record


def test_numbers_and_vectors_of_the_same_size_are_not_the_same():
    class Four(gymnasium.Env):
        def __init__(self, space):
            self.observation_space, self.action_space = space, gymnasium.spaces.Discrete(2)

    agent = DQNAgent(Four(gymnasium.spaces.Discrete(4)))
    agent.env = Four(gymnasium.spaces.Box(0, 1, (4,)))
    with pytest.raises(ValueError, match="another kind of observations"):
        agent.test()
