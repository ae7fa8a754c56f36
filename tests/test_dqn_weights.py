"""Weights can be looked at, kept, and put back: of some agents or of all."""

import numpy as np
import pytest

from course_lib import DQNAgent, Maze

BATCHED = {"replay": 200, "batch_size": 8, "target_update": 30, "double": True}
ALL_STATES = np.arange(16)


@pytest.fixture
def agents():
    trained = DQNAgent(Maze(wall_reward=0.0), num_agents=3, **BATCHED)
    trained.train(num_steps=100)
    return trained


def test_there_is_a_row_an_agent_and_a_number_a_weight(agents):
    assert agents.weights.shape == (3, 16 * 20 + 20 + 20 * 4 + 4)
    assert agents.weights.dtype == np.float32


def test_the_layers_are_the_same_numbers_by_layer(agents):
    (w1, b1), (w2, b2) = agents.layers
    assert [array.shape for array in (w1, b1, w2, b2)] == [(3, 16, 20), (3, 20), (3, 20, 4), (3, 4)]
    flat = np.concatenate([array.reshape(3, -1) for array in (w1, b1, w2, b2)], axis=1)
    assert (flat == agents.weights).all()
    by_hand = np.maximum(w1[1] + b1[1], 0) @ w2[1] + b2[1]
    np.testing.assert_allclose(agents.q_values(ALL_STATES)[1], by_hand, atol=1e-5)


def test_what_one_gets_is_a_copy(agents):
    before = agents.q_values(ALL_STATES)
    kept = agents.weights
    kept[:] = 7
    for weights, biases in agents.layers:
        weights[:], biases[:] = 7, 7
    assert (agents.q_values(ALL_STATES) == before).all()
    kept = agents.weights
    agents.train(num_steps=50)
    assert (kept != agents.weights).any(), "training does not write into what was kept"


def test_kept_weights_bring_back_what_the_agent_said(agents):
    said, kept = agents.q_values(ALL_STATES), agents.weights
    agents.train(num_steps=100)
    assert (agents.q_values(ALL_STATES) != said).any()
    agents.weights = kept
    assert (agents.q_values(ALL_STATES) == said).all()


def test_one_agent_can_be_put_back_alone(agents):
    said, kept = agents.q_values(ALL_STATES), agents.weights
    agents.train(num_steps=100)
    mixed, later = agents.weights, agents.q_values(ALL_STATES)
    mixed[1] = kept[1]
    agents.weights = mixed
    now = agents.q_values(ALL_STATES)
    assert (now[1] == said[1]).all()
    assert (now[[0, 2]] == later[[0, 2]]).all()


@pytest.mark.parametrize("target_update", [30, 0.1])
def test_the_target_networks_follow(target_update):
    """Targets made by other networks than those put in would be news from nowhere."""
    agents = DQNAgent(Maze(), num_agents=2, **(BATCHED | {"target_update": target_update}))
    agents.train(num_steps=40)
    assert (agents._target.flat != agents._online.flat).any()
    agents.weights = agents.weights * 0.5
    assert (agents._target.flat == agents._online.flat).all()
    expected = agents._target.forward(None).q.numpy()
    assert (agents._best_next(agents._online.forward(None), None).numpy() == expected.max(axis=2)).all()


def test_training_goes_on_from_other_weights(agents):
    other = DQNAgent(Maze(wall_reward=0.0), num_agents=3, seed=9, **BATCHED).weights
    agents.weights = other
    record = agents.train(num_episodes=5)
    assert len(record) == 5
    assert (agents.weights != other).any()
