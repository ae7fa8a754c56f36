"""An agent learns what the algorithm says, step by step, whether it is alone, among others or in a table."""

from itertools import pairwise
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
import torch
from dqn_worlds import SWITCHES, WORLDS, everything, one_thread, watched
from gymnasium.wrappers import RecordEpisodeStatistics, TimeLimit
from test_q_table import WORLDS as TABLES
from test_q_table import OneRoom

from course_lib import DQNAgent, Maze, Tile, value_iteration

# --- against a plain loop ---------------------------------------------------------------------------------------------


def plain_agent(
    env, steps, *, hidden=(20,), gamma=0.95, learning_rate=1e-3, epsilon=0.5, epsilon_decay=0.999, replay=None,
    batch_size=1, target_update=None, double=False, mask_terminal=True, max_steps=1000, seed=0,
):  # fmt: skip
    """Deep Q-learning for one agent as torch's tutorials have it, with no help from the package, in double precision.

    Also how close to each other the two best actions were, at the closest: where they are as good as equal, rounding
    decides, and two programs may part ways.
    """
    rng, discrete = np.random.default_rng(seed), isinstance(env.observation_space, gymnasium.spaces.Discrete)
    num_actions = int(env.action_space.n)
    num_inputs = int(env.observation_space.n) if discrete else env.observation_space.shape[0]
    q, target = (network(num_inputs, hidden, num_actions) for _ in range(2))
    with torch.no_grad():
        for layer in q[::2]:
            limit = np.sqrt(6 / (layer.in_features + layer.out_features))
            weights = rng.uniform(-limit, limit, (layer.in_features, layer.out_features)).astype(np.float32)
            layer.weight.copy_(torch.from_numpy(weights.T))
            layer.bias.zero_()
    target.load_state_dict(q.state_dict())
    adam, first_seed = torch.optim.Adam(q.parameters(), lr=learning_rate), int(rng.integers(2**31))

    def inputs(observation):
        return torch.eye(num_inputs).double()[observation] if discrete else torch.as_tensor(observation).double()

    memory, actions, returns, closest, updates = [], [], [0.0], np.inf, 0
    state, steps_of_episode = env.reset(seed=first_seed)[0], 0
    for step in range(steps):
        drawn = rng.random(2 + (batch_size if replay else 0))
        with torch.no_grad():
            values = q(inputs(state)).numpy()
        if drawn[0] < epsilon:
            action = int(drawn[1] * num_actions)
        else:
            action = int(values.argmax())
            closest = min(closest, np.diff(np.sort(values))[-1])
        following, reward, terminated, truncated, _ = env.step(action)
        transition = (inputs(state), action, reward, inputs(following), terminated)
        if replay and len(memory) == replay:
            memory[step % replay] = transition
        else:
            memory.append(transition)
        chosen = [memory[int(number * len(memory))] for number in drawn[2:]] if replay else [transition]
        if not replay or len(memory) >= batch_size:
            losses = []
            for s, a, r, s_next, over in chosen:
                with torch.no_grad():
                    worth_then = q(s_next) if target_update is None else target(s_next)
                    best = (q(s_next) if double else worth_then).argmax()
                    y = r + (0.0 if over and mask_terminal else gamma) * worth_then[best]
                losses.append((q(s)[a] - y) ** 2)
            adam.zero_grad()
            torch.stack(losses).mean().backward()
            adam.step()
            updates += 1
            for theirs, ours in zip(target.parameters(), q.parameters(), strict=True):
                if target_update is not None and (target_update < 1 or updates % target_update == 0):
                    share = min(target_update, 1)
                    theirs.data += share * (ours.data - theirs.data)
        actions.append(action)
        returns[-1] += reward
        state, steps_of_episode = following, steps_of_episode + 1
        if terminated or truncated or steps_of_episode == max_steps:
            returns.append(0.0)
            epsilon *= epsilon_decay
            state, steps_of_episode = env.reset(seed=(first_seed + len(returns) - 1) % 2**31)[0], 0

    def values_of(observations):
        with torch.no_grad():
            return q(torch.stack([inputs(observation) for observation in observations])).numpy()

    return SimpleNamespace(
        q_values=values_of, actions=actions, returns=returns[:-1], epsilon=epsilon, closest=closest, updates=updates
    )


def network(num_inputs, hidden, num_actions):
    layers = []
    for inputs, outputs in pairwise((num_inputs, *hidden, num_actions)):
        layers += [torch.nn.Linear(inputs, outputs, dtype=torch.float64), torch.nn.ReLU()]
    return torch.nn.Sequential(*layers[:-1])


RUNS = {
    "the defaults": ("maze", {}),
    "memory and batch": ("slippery maze", {"replay": 150, "batch_size": 4, "learning_rate": 3e-3}),
    "target network": ("maze", {"target_update": 20, "learning_rate": 3e-3}),
    "target network that follows slowly": ("lake", {"target_update": 0.05, "learning_rate": 3e-3, "seed": 1}),
    "double": ("maze", {"target_update": 20, "double": True, "replay": 100, "batch_size": 4, "learning_rate": 3e-3}),
    "no mask": ("maze", {"mask_terminal": False, "learning_rate": 3e-3}),
    "many states and everything": ("large maze", SWITCHES["everything"] | {"max_steps": 60}),
    "no hidden layer, short episodes": ("maze", {"hidden": (), "max_steps": 4, "epsilon_decay": 0.98}),
    "vectors": ("cart pole", {"hidden": (12, 7), "seed": 3}),
    "vectors and everything": ("cart pole", SWITCHES["everything"] | {"epsilon": 0.3}),
}


@pytest.mark.parametrize(("world", "switches"), RUNS.values(), ids=RUNS.keys())
def test_a_plain_loop_plays_and_learns_the_same(world, switches):
    agent_settings = {name: value for name, value in switches.items() if name != "max_steps"}
    env, max_steps = WORLDS[world](), switches.get("max_steps", 1000)
    agent = DQNAgent(env, **agent_settings)
    asked = observations_of(WORLDS[world]())
    before, steps = agent.q_values(asked), watched(agent)
    record = agent.train(num_steps=520, max_steps=max_steps)
    with one_thread():
        plain = plain_agent(WORLDS[world](), 520, **switches)

    assert plain.closest > 50 * 1e-6, "no two actions so alike that rounding, some 1e-6 of it, decides between them"
    assert [int(actions[0]) for actions, _, _ in steps] == plain.actions
    assert record.episode_return.tolist() == [plain.returns]
    assert agent.epsilon.tolist() == [plain.epsilon]
    assert agent._adam.updates.tolist() == [plain.updates]
    np.testing.assert_allclose(agent.q_values(asked)[0], plain.q_values(asked), rtol=0, atol=1e-4)
    assert np.abs(agent.q_values(asked) - before).max() > 0.05, "it has learned something"


def observations_of(env):
    """Every state of a table, or what a cart sees that is pushed to and fro."""
    if isinstance(env.observation_space, gymnasium.spaces.Discrete):
        return np.arange(env.observation_space.n)
    seen = [env.reset(seed=0)[0]]
    seen += [env.step(step % 2)[0] for step in range(20)]
    return np.stack(seen)


# --- many are as one --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())
@pytest.mark.parametrize("switches", SWITCHES.values(), ids=SWITCHES.keys())
@pytest.mark.parametrize("i", [2])
def test_an_agent_among_others_is_the_agent_alone(world, switches, i):
    together, alone = (
        DQNAgent(world(), seed=11 + first, num_agents=many, **switches) for first, many in ((0, 3), (i, 1))
    )
    asked, steps, own_steps = observations_of(world()), watched(together), watched(alone)
    record, own = together.train(num_steps=500), alone.train(num_steps=500)
    assert [int(actions[i]) for actions, _, _ in steps] == [int(actions[0]) for actions, _, _ in own_steps]
    for name in ("episode_return", "episode_length", "terminated", "truncated"):
        assert getattr(record, name)[i, : len(own)].tobytes() == getattr(own, name).tobytes()
    assert not record.episode_length[i, len(own) :].any()
    assert together.epsilon[i] == alone.epsilon[0]
    np.testing.assert_allclose(together.q_values(asked)[i], alone.q_values(asked)[0], rtol=0, atol=1e-4)
    assert np.abs(together.q_values(asked)[0] - together.q_values(asked)[2]).max() > 1e-2


@pytest.mark.parametrize("world", TABLES.values(), ids=TABLES.keys())
def test_a_table_is_played_as_the_world_itself_to_the_last_bit(world):
    switches = {"replay": 30, "batch_size": 3, "epsilon": 0.7, "epsilon_decay": 0.9, "hidden": (5,)}
    table, plain = (DQNAgent(env, num_agents=3, **switches) for env in (world(), RecordEpisodeStatistics(world())))
    for agent in (table, plain):
        agent.train(num_steps=70, max_steps=20)
        agent.train(num_episodes=1, max_steps=20)
    assert everything(table) == everything(plain)


def test_the_seed_decides_everything():
    first, again, other = (DQNAgent(Maze(slip=0.2), num_agents=2, seed=seed) for seed in (1, 1, 3))
    for agent in (first, again, other):
        agent.train(20)
    assert everything(first) == everything(again)
    assert everything(first)["weights"] != everything(other)["weights"]


# --- terminated is not truncated --------------------------------------------------------------------------------------

WITH_REPLAY = {"replay": 50, "batch_size": 8, "target_update": 5}


def worth(env, *, max_steps=1000, **switches):
    """What an agent comes to think of the one action of a world with one state, where each step pays 1."""
    agent = DQNAgent(env, gamma=0.5, learning_rate=0.05, hidden=(4,), **switches)
    record = agent.train(num_steps=450, max_steps=max_steps)
    return float(agent.q_values([0])[0, 0, 0]), record


@pytest.mark.parametrize("switches", [{}, WITH_REPLAY], ids=["latest transition", "memory"])
@pytest.mark.parametrize(
    ("terminated", "truncated", "expected"), [(True, False, 1.0), (False, True, 2.0), (True, True, 1.0)]
)
def test_only_a_termination_stops_the_bootstrap(terminated, truncated, expected, switches):
    value, record = worth(OneRoom(terminated, truncated), **switches)
    assert value == pytest.approx(expected, abs=0.02)
    assert record.episode_length.tolist() == [[1] * 450]
    assert record.terminated.all() == terminated
    assert (record.truncated == ~record.terminated).all()


@pytest.mark.parametrize("switches", [{}, WITH_REPLAY], ids=["latest transition", "memory"])
@pytest.mark.parametrize(
    ("make", "max_steps"),
    [(lambda: OneRoom(False, False), 3), (lambda: TimeLimit(OneRoom(False, False), 3), 1000)],
    ids=["max_steps", "a time limit"],
)
def test_a_cut_does_not_stop_the_bootstrap(make, max_steps, switches):
    value, record = worth(make(), max_steps=max_steps, **switches)
    assert value == pytest.approx(2.0, abs=0.02)
    assert record.episode_length.tolist() == [[3] * 150]
    assert record.truncated.all()


@pytest.mark.parametrize("end", [(True, False), (False, True), (True, True)])
def test_without_the_mask_nothing_stops_the_bootstrap(end):
    assert worth(OneRoom(*end), mask_terminal=False)[0] == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize("wrap", [lambda env: env, RecordEpisodeStatistics], ids=["table", "plain"])
def test_a_time_limit_does_not_stop_the_bootstrap_and_the_goal_does(wrap):
    corridor = {"grid": [[3, 4]], "step_reward": 1.0, "goal_reward": 1.0}
    agent = DQNAgent(
        wrap(TimeLimit(Maze(**corridor), 1)), hidden=(), gamma=0.5, epsilon=1.0, epsilon_decay=1.0, learning_rate=0.02
    )
    record = agent.train(num_steps=800)
    np.testing.assert_allclose(agent.q_values([0])[0, 0], [2, 2, 2, 1], atol=0.05)
    assert (record.terminated != record.truncated).all()
    assert record.terminated.any()
    assert record.truncated.any()


# --- what is learned --------------------------------------------------------------------------------------------------

GOOD = {
    "replay": 10_000, "batch_size": 32, "target_update": 50, "learning_rate": 2e-3, "gamma": 0.95,
    "epsilon": 1.0, "epsilon_decay": 0.995,
}  # fmt: skip


def cells_to_stand_in(maze):
    return np.flatnonzero(np.isin(maze.grid.ravel(), (Tile.OPEN, Tile.START)))


def test_thirty_two_agents_learn_the_exact_values_of_the_path_they_take():
    """Of 960 other seeds, none was further off than 0.009. The last steps are small ones, as for any exact answer."""
    maze = Maze(wall_reward=0.0)
    agent = DQNAgent(maze, num_agents=32, **GOOD)
    agent.train(num_steps=2700)
    agent.learning_rate = 2e-4
    agent.train(num_steps=500)
    best, q = value_iteration(maze.mdp, 0.95).q, agent.q_values(np.arange(16))
    for i, walk in enumerate(agent.test()):
        path, worth = walk.states[:-1], q[i, walk.states[:-1], walk.actions]
        assert walk.terminated
        assert walk.states[-1] in maze.goals
        np.testing.assert_allclose(worth, 0.95 ** np.arange(5, -1, -1), atol=0.05)
        np.testing.assert_allclose(worth, best[path].max(axis=1), atol=0.05)
    assert q[:, cells_to_stand_in(maze)].max() < 1.1


def test_without_the_mask_values_grow_beyond_anything_there_is_to_earn():
    """The goal pays 1, once. Of 320 other seeds, all had a value above 1.5 by now."""
    agent = DQNAgent(Maze(wall_reward=0.0), num_agents=32, mask_terminal=False, **GOOD)
    agent.train(num_steps=2000)
    largest = agent.q_values(cells_to_stand_in(agent.env)).max(axis=(1, 2))
    assert (largest > 1.2).mean() >= 0.9
