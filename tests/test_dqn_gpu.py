"""On a GPU the agents do what they do on the processor, and the same every time."""

import gymnasium
import numpy as np
import pytest
import torch
from dqn_worlds import SWITCHES, WORLDS, watched
from observed_worlds import Plain

from course_lib import DQNAgent
from course_lib.files import load_arrays

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no GPU that torch can use")

BATCHED = {"replay": 60, "batch_size": 16, "target_update": 5, "double": True, "hidden": (12, 9)}
RUNS = {f"{world}, {name}": (WORLDS[world], SWITCHES[name]) for world in WORLDS for name in SWITCHES}
RUNS |= {f"{world}, batches": (make, BATCHED) for world, make in WORLDS.items()}
RUNS |= {
    f"masks, {kind}": (lambda vectors=vectors: Plain(vectors=vectors), BATCHED | {"mask_actions": True})
    for kind, vectors in (("states", False), ("vectors", True))
}
every_run = pytest.mark.parametrize(("world", "switches"), RUNS.values(), ids=RUNS.keys())


def trained(world, switches, device="cuda", *, num_agents=3, seed=11, num_steps=200):
    """(agent, its actions, step by step)."""
    agent = DQNAgent(world(), num_agents=num_agents, seed=seed, device=device, **switches)
    steps = watched(agent)
    agent.train(num_steps=num_steps)
    return agent, np.array([actions for actions, _, _ in steps])


def answers(agent):
    """What the networks say of all states, or of some vectors."""
    space = agent.env.observation_space
    if isinstance(space, gymnasium.spaces.Discrete):
        return agent.q_values(space.start + np.arange(space.n))
    return agent.q_values(np.random.default_rng(0).uniform(-1, 1, (20, *space.shape)))


def saved(agent, path):
    """All that training needs, to the last bit."""
    agent.save(path)
    arrays, settings = load_arrays(path, kind="DQNAgent")
    return {name: array.tobytes() for name, array in arrays.items()}, settings


@every_run
def test_the_processor_plays_and_learns_the_same(world, switches):
    gpu, gpus_actions = trained(world, switches)
    cpu, cpus_actions = trained(world, switches, "cpu")
    assert gpus_actions.tolist() == cpus_actions.tolist()
    np.testing.assert_allclose(answers(gpu), answers(cpu), rtol=0, atol=1e-4)
    assert [walk.actions.tolist() for walk in gpu.test(max_steps=50)] == [
        walk.actions.tolist() for walk in cpu.test(max_steps=50)
    ]


@every_run
def test_the_seed_decides_everything_to_the_last_bit(world, switches, tmp_path):
    first, again = (trained(world, switches, num_agents=300, num_steps=70)[0] for _ in range(2))
    assert saved(first, tmp_path / "first") == saved(again, tmp_path / "again")


@every_run
def test_an_agent_among_others_is_the_agent_alone(world, switches):
    together, their_actions = trained(world, switches)
    alone, own_actions = trained(world, switches, num_agents=1, seed=13)
    assert their_actions[:, 2].tolist() == own_actions[:, 0].tolist()
    np.testing.assert_allclose(answers(together)[2], answers(alone)[0], rtol=0, atol=1e-4)


@every_run
@pytest.mark.parametrize(("saved_on", "loaded_on"), [("cuda", "cuda"), ("cuda", "cpu"), ("cpu", "cuda")])
def test_a_file_goes_from_one_to_the_other(world, switches, saved_on, loaded_on, tmp_path):
    agent, _ = trained(world, switches, saved_on, num_steps=70)
    content = saved(agent, tmp_path / "saved")
    loaded = DQNAgent.load(tmp_path / "saved", world(), device=loaded_on)
    assert loaded.device.type == loaded_on
    assert saved(loaded, tmp_path / "loaded") == content
    for some in (agent, loaded):
        some.train(num_steps=50)
    if saved_on == loaded_on:
        assert loaded.weights.tobytes() == agent.weights.tobytes()
    np.testing.assert_allclose(answers(loaded), answers(agent), rtol=0, atol=1e-4)


def test_a_memory_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="there is no memory for"):
        DQNAgent(WORLDS["maze"](), replay=10**9, num_agents=1000, device="cuda")
