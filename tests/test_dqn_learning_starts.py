"""Agents collect before they learn: nothing of them moves until then, and what is left out changes nothing."""

import numpy as np
import pytest
from dqn_worlds import WORLDS, everything, learned, remembered, watched
from observed_worlds import Plain, Told
from test_dqn_agent import observations_of
from test_dqn_files import rewritten

from course_lib import DQNAgent, Maze
from course_lib.dqn.inputs import Vectors
from course_lib.files import load_arrays

SETTINGS = {
    "replay": 60, "batch_size": 4, "target_update": 5, "double": True, "hidden": (12,), "learning_rate": 3e-3,
    "epsilon": 1.0, "epsilon_decay": 0.9,
}  # fmt: skip
STARTS = [4, 5, 37, 60, 85]  # as many as a batch, up to more than are remembered
WITH_MASKS = {"a tape": lambda: Told(vectors=True, ends=[30]), "a tape in steps": lambda: Plain(vectors=True)}
every_world = pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())


def networks_of(agent):
    """The part of an agent that only learning moves."""
    names = ("weights", "target", "first moments", "second moments", "updates")
    return {name: rows for name, rows in everything(agent).items() if name in names}


def calls(owner, name):
    """A list that grows by one at every call of a method."""
    made, method = [], getattr(owner, name)

    def noted(*given):
        made.append(1)
        return method(*given)

    setattr(owner, name, noted)
    return made


# --- when it begins ---------------------------------------------------------------------------------------------------


@every_world
@pytest.mark.parametrize("starts", STARTS)
def test_nothing_is_learned_before_so_many_transitions_and_from_then_on_at_every_step(world, starts):
    agent = DQNAgent(world(), num_agents=2, learning_starts=starts, **SETTINGS)
    before = networks_of(agent)
    agent.train(num_steps=starts - 1)
    assert networks_of(agent) == before
    assert agent._memory.count.tolist() == [starts - 1] * 2
    for updates in (1, 2, 3):
        earlier = agent.weights
        agent.train(num_steps=1)
        assert agent._adam.updates.tolist() == [updates] * 2
        assert (agent.weights != earlier).any(axis=1).all()
    assert networks_of(agent)["target"] == before["target"]
    agent.train(num_steps=2)
    assert (agent._target.flat == agent._online.flat).all(), "the fifth gradient step, not the fifth step"


@pytest.mark.parametrize("starts", [4, 60])
def test_an_agent_learns_by_its_own_count_however_many_the_others_have(starts):
    """They play episodes of several lengths, then go on together from where each of them is."""
    agent = DQNAgent(Maze(slip=0.2), num_agents=6, learning_starts=starts, **(SETTINGS | {"epsilon_decay": 1}))
    before = agent.weights
    for how_long in ({"num_episodes": 4}, {"num_steps": 12}):
        agent.train(**how_long)
        count = agent._memory.count
        assert len(set(count.tolist())) > 1
        assert agent._adam.updates.tolist() == np.maximum(count - starts + 1, 0).tolist()
        assert (agent.weights != before).any(axis=1).tolist() == (count >= starts).tolist()
    assert starts == 4 or 0 < (count >= starts).sum() < 6


@every_world
@pytest.mark.parametrize("starts", [5, 37, 85])
def test_it_is_an_agent_that_was_kept_from_learning_to_the_last_bit(world, starts):
    """Beside one that would learn from its batch_size-th transition on, whose gradient steps are left out."""
    agent = DQNAgent(world(), num_agents=3, learning_starts=starts, **SETTINGS)
    kept = DQNAgent(world(), num_agents=3, **SETTINGS)
    learn = kept._learn
    kept._learn = lambda *given: None  # noqa: ARG005
    for steps in (starts - 1, 40):
        agent.train(num_steps=steps)
        kept.train(num_steps=steps)
        kept._learn = learn
        assert everything(agent) == everything(kept)


def test_what_is_drawn_at_first_comes_from_all_that_was_collected():
    agent = DQNAgent(WORLDS["cart pole"](), replay=500, batch_size=64, learning_starts=400, epsilon=1)
    stored, batches, sample = remembered(agent), [], agent._memory.sample

    def noted(numbers):
        batches.append(sample(numbers))
        return batches[-1]

    agent._memory.sample = noted
    agent.train(num_steps=400)
    (batch,) = batches
    rows = [entry["observation"].tobytes() for entry in stored[0]]
    places = np.array([rows.index(row.numpy().tobytes()) for row in batch["observation"][0]])
    assert np.histogram(places, [0, 100, 200, 300, 400])[0].min() >= 5


# --- what None means --------------------------------------------------------------------------------------------------


@every_world
def test_without_a_word_it_is_the_size_of_a_batch(world):
    unsaid, said, later = (
        DQNAgent(world(), **SETTINGS, **more) for more in ({}, {"learning_starts": 4}, {"learning_starts": 9})
    )
    assert (unsaid.learning_starts, said.learning_starts, later.learning_starts) == (4, 4, 9)
    for agent in (unsaid, said, later):
        agent.train(num_steps=30)
    assert everything(unsaid) == everything(said)
    assert everything(unsaid)["weights"] != everything(later)["weights"]


def test_without_a_memory_it_can_only_be_the_first():
    unsaid, said = DQNAgent(Maze()), DQNAgent(Maze(), learning_starts=1)
    for agent in (unsaid, said):
        assert agent.learning_starts == 1
        agent.train(num_steps=1)
        assert agent._adam.updates.tolist() == [1]
    assert everything(unsaid) == everything(said)


# --- what is left out -------------------------------------------------------------------------------------------------


def unshortened(monkeypatch, make):
    """An agent that asks its networks at every step, whoever explores, and draws a batch at every step."""
    agent = make()
    store, sample = agent._memory.store, agent._memory.sample

    def noted(transition, agents):
        store(transition, agents)
        sample(np.zeros((agent.num_agents, agent.batch_size)))

    agent._memory.store = noted
    train = agent.train

    def trained(*given, **named):
        with monkeypatch.context() as patch:
            patch.setattr(Vectors, "asks_all", True)
            return train(*given, **named)

    agent.train = trained
    return agent


@pytest.mark.parametrize("world", (WORLDS | WITH_MASKS).values(), ids=(WORLDS | WITH_MASKS).keys())
@pytest.mark.parametrize("num_agents", [1, 3])
@pytest.mark.parametrize(("epsilon", "starts"), [(1.0, 37), (0.7, 4), (0.0, 37)])
def test_what_is_left_out_changes_nothing_to_the_last_bit(world, num_agents, epsilon, starts, monkeypatch):
    def make():
        masks = isinstance(env := world(), Plain)
        given = SETTINGS | {"epsilon": epsilon, "learning_starts": starts, "num_agents": num_agents}
        return DQNAgent(env, mask_actions=masks, **given)

    agent, thorough = make(), unshortened(monkeypatch, make)
    asked, asked_thoroughly = (calls(one._online, "forward") for one in (agent, thorough))
    for one in (agent, thorough):
        one.train(num_steps=50)
        one.train(3, max_steps=20)
    assert everything(agent) == everything(thorough)
    if epsilon and not agent._inputs.asks_all:
        assert len(asked) < len(asked_thoroughly)
    else:
        assert len(asked) == len(asked_thoroughly)


def test_while_everybody_explores_and_nobody_learns_no_network_is_asked_and_no_batch_drawn():
    agent = DQNAgent(WORLDS["cart pole"](), num_agents=3, learning_starts=40, **(SETTINGS | {"epsilon_decay": 1}))
    asked, drawn = calls(agent._online, "forward"), calls(agent._memory, "sample")
    agent.train(num_steps=39)
    assert not asked
    assert not drawn
    agent.train(num_steps=10)
    assert len(drawn) == 10
    assert len(asked) == 2 * 10, "a pass to learn from, one to choose the next action by; none to act"


def test_one_that_does_not_explore_is_enough_to_ask_all():
    agent = DQNAgent(WORLDS["cart pole"](), num_agents=3, learning_starts=50, **(SETTINGS | {"epsilon_decay": 1}))
    agent.epsilon[1] = 0
    asked, actions = calls(agent._online, "forward"), watched(agent)
    agent.train(num_steps=30)
    assert len(asked) == 30
    greedy = [int(step[0][1]) for step in actions]
    alone = DQNAgent(WORLDS["cart pole"](), learning_starts=50, seed=1, **(SETTINGS | {"epsilon": 0}))
    own = watched(alone)
    alone.train(num_steps=30)
    assert greedy == [int(step[0][0]) for step in own]


# --- saved, and among others ------------------------------------------------------------------------------------------


@every_world
@pytest.mark.parametrize("steps", [20, 36, 37, 50])
def test_a_saved_agent_goes_on_collecting_where_it_was(world, steps, tmp_path):
    unbroken = DQNAgent(world(), num_agents=2, learning_starts=37, **SETTINGS)
    unbroken.train(num_steps=steps)
    unbroken.save(tmp_path / "agent")
    resumed = DQNAgent.load(tmp_path / "agent", world())
    assert resumed.learning_starts == 37
    assert learned(resumed) == learned(unbroken)
    for more in (16, 1, 20):
        for agent in (unbroken, resumed):
            agent.train(num_steps=more)
        assert everything(resumed) == everything(unbroken)
    assert resumed._adam.updates.tolist() == [steps + 37 - 36] * 2


def test_a_file_from_before_there_was_such_a_setting_learns_from_a_batch_on(tmp_path):
    path, env = tmp_path / "agent", WORLDS["cart pole"]()
    agent = DQNAgent(env, num_agents=2, **SETTINGS)
    agent.train(num_steps=3)
    agent.save(path)
    assert load_arrays(path, kind="DQNAgent")[1]["agent"]["learning_starts"] == 4
    rewritten(path, agent={"learning_starts": None})
    assert "learning_starts" not in load_arrays(path, kind="DQNAgent")[1]["agent"]
    older = DQNAgent.load(path, env)
    assert older.learning_starts == 4
    for one in (agent, older):
        one.train(num_steps=20)
    assert everything(older) == everything(agent)


@pytest.mark.parametrize("wrong", [3, 0, -1, 2.5, "many", [], float("nan")])
def test_a_file_with_a_number_that_cannot_be_meant_is_refused(wrong, tmp_path):
    path = tmp_path / "agent"
    DQNAgent(Maze(), **SETTINGS).save(path)
    rewritten(path, agent={"learning_starts": wrong})
    with pytest.raises(ValueError, match=r"^[^\n]*agent cannot be loaded: learning_starts must be [^\n]+$"):
        DQNAgent.load(path, Maze())


@every_world
@pytest.mark.parametrize("i", [0, 2])
def test_an_agent_among_others_is_the_agent_alone(world, i):
    given = SETTINGS | {"learning_starts": 60, "epsilon_decay": 0.8}
    together, alone = (DQNAgent(world(), seed=11 + first, num_agents=many, **given) for first, many in ((0, 3), (i, 1)))
    steps, own_steps = watched(together), watched(alone)
    for agent in (together, alone):
        agent.train(num_steps=150)
    assert [int(actions[i]) for actions, _, _ in steps] == [int(actions[0]) for actions, _, _ in own_steps]
    assert together._adam.updates.tolist() == [91] * 3
    assert alone._adam.updates.tolist() == [91]
    asked = observations_of(world())
    np.testing.assert_allclose(together.q_values(asked)[i], alone.q_values(asked)[0], rtol=0, atol=1e-4)


def test_a_training_in_parts_is_one_training():
    whole, parts = (DQNAgent(WORLDS["cart pole"](), num_agents=2, learning_starts=37, **SETTINGS) for _ in range(2))
    whole.train(num_steps=80)
    for steps in (10, 26, 1, 1, 42):
        parts.train(num_steps=steps)
    assert learned(parts) == learned(whole)
