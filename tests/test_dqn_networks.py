"""Many networks at once compute what one after the other would: outputs, gradients and Adam's steps."""

from itertools import pairwise

import numpy as np
import pytest
import torch
from dqn_worlds import WORLDS
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib import DQNAgent
from course_lib.dqn.networks import Adam, Networks, layers_of, number_of_weights, row_sums, starting_weights

SIZES = [(3, 2), (16, 4), (4, 20, 2), (1, 1, 1), (5, 7, 6, 3), (2, 3, 4, 5, 2)]
every_shape = pytest.mark.parametrize("sizes", SIZES, ids=str)


def random_networks(sizes, num_networks, seed=0):
    """Networks of double precision, so that a wrong term cannot hide behind rounding; biases are not zero."""
    weights = np.random.default_rng(seed).normal(size=(num_networks, number_of_weights(sizes)))
    return Networks(sizes, torch.from_numpy(weights))


def torch_network(sizes, row):
    """One network as torch has it, from a row of numbers: a layer's weights [inputs, outputs], then its biases."""
    row, layers = torch.as_tensor(row), []
    for inputs, outputs in pairwise(sizes):
        linear = torch.nn.Linear(inputs, outputs, dtype=row.dtype)
        with torch.no_grad():
            linear.weight.copy_(row[: inputs * outputs].reshape(inputs, outputs).T)
            linear.bias.copy_(row[inputs * outputs : inputs * outputs + outputs])
        row = row[inputs * outputs + outputs :]
        layers += [linear, torch.nn.ReLU()]
    assert len(row) == 0
    return torch.nn.Sequential(*layers[:-1])


def row_of(network, what=lambda parameter: parameter):
    """The weights of torch's network, or what belongs to them, in the order of a row."""
    parts = [what(parameter) for parameter in network.parameters()]
    return torch.cat([part.T.reshape(-1) if part.ndim == 2 else part for part in parts]).detach()


# --- outputs and gradients --------------------------------------------------------------------------------------------


def one_hot(states, size):
    """What a network takes for these states, int64[…]: float[…, size]."""
    return torch.eye(size, dtype=torch.float64)[states]


def assert_as_torch(networks, x, dq, explicit=None):
    """Outputs and gradients of each network are torch's for its own inputs, which are x where they are not explicit."""
    passed = networks.forward(x)
    gradient = networks.backward(passed, dq)
    assert gradient.shape == networks.flat.shape
    explicit = x if explicit is None else explicit
    for i, row in enumerate(networks.flat):
        alone = torch_network(networks.sizes, row)
        q = alone(explicit[i])
        (q * dq[i]).sum().backward()
        torch.testing.assert_close(passed.q[i], q.detach(), rtol=1e-10, atol=1e-10)
        torch.testing.assert_close(gradient[i], row_of(alone, lambda p: p.grad), rtol=1e-10, atol=1e-10)


@every_shape
@pytest.mark.parametrize("num_networks", [1, 3])
@pytest.mark.parametrize("rows", [1, 5])
def test_outputs_and_gradients_are_torchs_for_every_network(sizes, num_networks, rows):
    rng = np.random.default_rng(1)
    x, dq = (torch.from_numpy(rng.normal(size=(num_networks, rows, n))) for n in (sizes[0], sizes[-1]))
    assert_as_torch(random_networks(sizes, num_networks), x, dq)


@every_shape
@pytest.mark.parametrize("num_networks", [1, 3])
def test_all_states_at_once_are_the_rows_of_the_identity(sizes, num_networks):
    dq = torch.from_numpy(np.random.default_rng(1).normal(size=(num_networks, sizes[0], sizes[-1])))
    states = torch.arange(sizes[0]).repeat(num_networks, 1)
    assert_as_torch(random_networks(sizes, num_networks), None, dq, one_hot(states, sizes[0]))


@every_shape
@pytest.mark.parametrize("num_networks", [1, 3])
@pytest.mark.parametrize("rows", [1, 12])
def test_states_by_number_are_one_hot_encoded_ones_also_where_one_comes_again(sizes, num_networks, rows):
    rng = np.random.default_rng(1)
    states = torch.from_numpy(rng.integers(sizes[0], size=(num_networks, rows)))
    dq = torch.from_numpy(rng.normal(size=(num_networks, rows, sizes[-1])))
    assert_as_torch(random_networks(sizes, num_networks), states, dq, one_hot(states, sizes[0]))


@pytest.mark.parametrize("shape", [(3, 12), (3, 12, 4)], ids=str)
def test_sums_by_row_are_the_same_wherever_a_row_comes_again(shape):
    """So a GPU, whose threads write in any order, writes the same to a place whoever is last."""
    rng = np.random.default_rng(1)
    rows, values = torch.from_numpy(rng.integers(5, size=(3, 12))), torch.from_numpy(rng.normal(size=shape))
    expected = torch.stack([sum(values[i, rows[i] == row]) for i in range(3) for row in rows[i]]).view(shape)
    torch.testing.assert_close(row_sums(rows, values), expected)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(st.lists(st.integers(1, 9), min_size=2, max_size=5), st.integers(1, 4), st.integers(1, 6), st.integers(0, 1000))
def test_outputs_and_gradients_are_torchs_for_any_shape(sizes, num_networks, rows, seed):
    rng = np.random.default_rng(seed)
    x, dq = (torch.from_numpy(rng.normal(size=(num_networks, rows, n))) for n in (sizes[0], sizes[-1]))
    networks, states = random_networks(sizes, num_networks, seed), torch.arange(sizes[0]).repeat(num_networks, 1)
    assert_as_torch(networks, x, dq)
    if rows <= sizes[0]:
        assert_as_torch(networks, states[:, :rows], dq, one_hot(states[:, :rows], sizes[0]))
    if rows == sizes[0]:
        assert_as_torch(networks, None, dq, one_hot(states, sizes[0]))


def test_a_forward_pass_leaves_its_inputs_and_the_weights_as_they_are():
    networks = random_networks((4, 6, 5, 3), 2)
    x = torch.from_numpy(np.random.default_rng(1).normal(size=(2, 3, 4)))
    before = x.clone(), networks.flat.clone()
    passed = networks.forward(x)
    networks.forward(None)
    networks.backward(passed, torch.ones_like(passed.q))
    assert torch.equal(x, before[0])
    assert torch.equal(networks.flat, before[1])


# --- the loss ---------------------------------------------------------------------------------------------------------

LOSSES = {
    "latest transition": {},
    "no hidden layer": {"hidden": ()},
    "batch": {"replay": 40, "batch_size": 16},
    "batch and target network": {"replay": 40, "batch_size": 16, "target_update": 0.3, "hidden": (8, 5)},
    "double": {"replay": 40, "batch_size": 16, "target_update": 7, "double": True},
    "no mask": {"replay": 40, "batch_size": 16, "target_update": 7, "mask_terminal": False},
}


@pytest.mark.parametrize("world", ["slippery maze", "large maze", "cart pole"])
@pytest.mark.parametrize("switches", LOSSES.values(), ids=LOSSES.keys())
def test_the_gradient_is_that_of_the_mean_squared_error_of_the_batch(world, switches, monkeypatch):
    """The gradient that Adam gets, against autograd on a sum over the samples, one by one, for each agent alone."""
    agent = DQNAgent(WORLDS[world](), num_agents=3, gamma=0.8, learning_rate=0.02, seed=4, **switches)
    agent.train(num_steps=60)
    sizes, caught = agent._online.sizes, {}
    learn, step = agent._learn, agent._adam.step

    def learning(passed, batch, which):
        rows = {"online": agent._online.flat.clone(), "target": agent._target.flat.clone()}
        caught.update(rows, batch={name: tensor.clone() for name, tensor in batch.items()})
        learn(passed, batch, which)

    def stepping(flat, gradient, *rest):
        caught["gradient"] = gradient.clone()
        step(flat, gradient, *rest)

    monkeypatch.setattr(agent, "_learn", learning)
    monkeypatch.setattr(agent._adam, "step", stepping)
    agent.train(num_steps=1)

    for i in range(3):
        online, target = (torch_network(sizes, caught[name][i]) for name in ("online", "target"))
        batch = {name: tensor[i] for name, tensor in caught["batch"].items()}
        loss = 0.0
        for k in range(len(batch["reward"])):
            s, a, s_next = sample(batch, k, sizes)
            with torch.no_grad():
                best = online(s_next).argmax() if switches.get("double") else target(s_next).argmax()
                y = batch["reward"][k] + batch["discount"][k] * target(s_next)[best]
            loss = loss + (online(s)[a] - y) ** 2 / len(batch["reward"])
        loss.backward()
        expected = row_of(online, lambda p: p.grad)
        assert expected.abs().max() > 1e-4
        torch.testing.assert_close(caught["gradient"][i], expected, rtol=1e-4, atol=1e-6)
    if "target_update" in switches:
        assert not torch.equal(caught["online"], caught["target"])


def sample(batch, k, sizes):
    """State, action and next state of one transition of a batch, states as a network takes them."""
    if "entry" in batch:
        s, a = divmod(int(batch["entry"][k]), sizes[-1])
        s_next = batch["next_state"][k]
    else:
        s, a, s_next = batch["observation"][k], int(batch["action"][k]), batch["next_observation"][k]
    if sizes[0] == 4:
        return s, a, s_next
    return one_hot(s, sizes[0]).float(), a, one_hot(s_next, sizes[0]).float()


# --- Adam -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1.0, 1e3, 1e-8])
def test_adam_is_torchs_for_every_network_whatever_the_others_do(scale):
    """Four networks that make 60, about 45, about 15 and no updates; some of their gradients stay zero throughout."""
    rng, chance = np.random.default_rng(2), np.array([1.0, 0.75, 0.25, 0.0])
    start = rng.normal(size=(4, 30)).astype(np.float32)
    flat, alone = torch.from_numpy(start.copy()), [torch.nn.Parameter(torch.from_numpy(row.copy())) for row in start]
    ours, theirs = Adam(flat), [torch.optim.Adam([row], lr=0.01) for row in alone]
    for _ in range(60):
        gradient = (scale * rng.normal(size=(4, 30)) * (np.arange(30) > 3)).astype(np.float32)
        learning = rng.random(4) < chance
        ours.step(flat, torch.from_numpy(gradient.copy()), 0.01, learning)
        for i in np.flatnonzero(learning):
            alone[i].grad = torch.from_numpy(gradient[i])
            theirs[i].step()
    assert ours.updates.tolist() == [int(theirs[i].state[alone[i]]["step"]) if i < 3 else 0 for i in range(4)]
    assert len(set(ours.updates.tolist())) == 4
    torch.testing.assert_close(flat, torch.stack([row.detach() for row in alone]), rtol=0, atol=2e-6)
    moved = (flat[:3] - torch.from_numpy(start[:3])).abs()
    assert moved[:, :4].max() == 0
    assert moved[:, 4:].max() > 100 * 2e-6


def test_a_network_that_is_not_learning_stays_as_it_is_to_the_last_bit():
    rng = np.random.default_rng(3)
    flat = torch.from_numpy(rng.normal(size=(3, 40)).astype(np.float32))
    adam = Adam(flat)

    def rows(i):
        return [array[i].numpy().tobytes() for array in (flat, adam.first, adam.second)], int(adam.updates[i])

    for step in range(20):
        learning = np.array([True, step < 10, step % 2 == 0])
        before = [rows(i) for i in range(3)]
        adam.step(flat, torch.from_numpy(rng.normal(size=(3, 40)).astype(np.float32)), 0.1, learning)
        for i in range(3):
            assert (rows(i) == before[i]) == (not learning[i])


# --- where they begin -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sizes", [(16, 20, 4), (4, 120, 84, 2), (500, 6)], ids=str)
def test_weights_begin_uniform_within_glorots_bounds_and_biases_at_zero(sizes):
    flat = starting_weights(sizes, np.random.default_rng(0))
    assert (flat.dtype, flat.shape) == (np.float32, (number_of_weights(sizes),))
    network = torch_network(sizes, torch.from_numpy(flat))
    for linear in network[::2]:
        limit = np.sqrt(6 / (linear.in_features + linear.out_features))
        weights = linear.weight.detach().numpy().ravel()
        assert np.abs(weights).max() <= limit * (1 + 1e-6)
        assert weights.max() > 0.9 * limit
        assert weights.min() < -0.9 * limit
        assert abs(weights.mean()) < 4 * limit / np.sqrt(3 * len(weights))
        assert not linear.bias.any()


def test_weights_begin_with_the_first_numbers_of_the_agents_own_generator():
    agent = DQNAgent(WORLDS["maze"](), hidden=(3,), num_agents=2, seed=5)
    for i in range(2):
        rng = np.random.default_rng(5 + i)
        for (weights, biases), (inputs, outputs) in zip(agent.layers, [(16, 3), (3, 4)], strict=True):
            limit = np.sqrt(6 / (inputs + outputs))
            np.testing.assert_array_equal(weights[i].ravel(), rng.uniform(-limit, limit, weights[i].size).astype("f4"))
            assert not biases[i].any()


def test_the_layers_of_an_agent_are_copies_and_say_what_it_says():
    agent = DQNAgent(WORLDS["cart pole"](), hidden=(6, 5), num_agents=2)
    agent.train(num_steps=30)
    assert [(w.shape, b.shape) for w, b in agent.layers] == [
        ((2, 4, 6), (2, 6)), ((2, 6, 5), (2, 5)), ((2, 5, 2), (2, 2)),
    ]  # fmt: skip
    x = np.random.default_rng(0).normal(size=(7, 4)).astype(np.float32)
    said, before = agent.q_values(x), agent._online.flat.clone()
    for i in range(2):
        h = x
        for w, b in agent.layers:
            last, h = h @ w[i] + b[i], np.maximum(h @ w[i] + b[i], 0)
        np.testing.assert_allclose(said[i], last, rtol=1e-5, atol=1e-5)
    for w, b in agent.layers:
        w[:], b[:] = 0, 0
    assert torch.equal(agent._online.flat, before)


@every_shape
def test_layers_are_views_that_fill_a_row_without_gaps(sizes):
    flat = torch.zeros(2, number_of_weights(sizes))
    for weights, biases in layers_of(sizes, flat):
        weights += 1
        biases += 1
    assert (flat == 1).all()
