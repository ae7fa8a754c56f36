"""A world without a table, learned by sixteen agents: lesson 6's training, judged on 100 episodes an agent."""

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.wrappers import TransformObservation

from course_lib import DQNAgent

# Every hyper-parameter there is. Rewards: 0 a step and -1 for falling, an option of CartPole-v1's own; observations
# brought to about one size; the learning rate falls to 0.8 of itself ten times; of the ten moments each agent keeps the
# one at which it balanced longest in 10 greedy episodes. The test's 100 episodes are others, paid 1 a step.
SETTINGS = {
    "hidden": (128,), "gamma": 0.99, "learning_rate": 0.001, "epsilon": 1.0, "epsilon_decay": 0.98, "replay": 50_000,
    "batch_size": 64, "target_update": 50, "double": True,
}  # fmt: skip
SCALE = np.array([0.5, 0.5, 5.0, 0.5], np.float32)
MOMENTS, STEPS_BETWEEN, DECAY = 10, 1500, 0.8
AGENTS, SOLVED = 16, 475


def cart_pole(**options):
    world = gymnasium.make("CartPole-v1", **options)
    return TransformObservation(world, lambda seen: seen * SCALE, Box(-np.inf, np.inf, (4,), np.float32))


def mean_returns(agents, num_episodes, seed):
    """The mean greedy return of each agent, in the world as it is."""
    training, agents.env = agents.env, cart_pole()
    walks = agents.test(num_episodes, seed=seed)
    agents.env = training
    return np.reshape([walk.rewards.sum() for walk in walks], (AGENTS, num_episodes)).mean(axis=1)


@pytest.fixture(scope="module")
def trained():
    """The agents with the weights of their best moments, and their mean returns before any training."""
    agents = DQNAgent(cart_pole(sutton_barto_reward=True), num_agents=AGENTS, **SETTINGS)
    untrained = mean_returns(agents, 10, seed=0)
    best, record = agents.weights, np.zeros(AGENTS)
    for moment in range(MOMENTS):
        agents.train(num_steps=STEPS_BETWEEN)
        agents.learning_rate *= DECAY
        now = mean_returns(agents, 10, seed=moment)
        better = now > record
        record[better], best[better] = now[better], agents.weights[better]
    agents.weights = best
    return agents, untrained


def test_at_least_three_quarters_of_the_agents_solve_it(trained):
    agents, _ = trained
    returns = mean_returns(agents, 100, seed=1000)
    assert (returns >= SOLVED).sum() >= 0.75 * AGENTS, np.sort(returns)


def test_it_is_the_training_that_solves_it(trained):
    _, untrained = trained
    assert np.median(untrained) < 100
