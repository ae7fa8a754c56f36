"""Other people's agents take our worlds as they are. Needs the `peers` extra; skipped without it."""

import numpy as np
import pytest
import torch
from market_worlds import SIGHTS, random_bars, side_env

from course_lib import Maze
from course_lib.dqn import DQNAgent
from course_lib.market import RubberBandMarket

stable_baselines3 = pytest.importorskip("stable_baselines3")


@pytest.fixture(autouse=True)
def one_thread():
    """Such small tensors are no work to share: where the cores are busy, two threads wait for each other."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.mark.parametrize("rules", [{}, {"slip": 0.2}, {"grid": [[3, 0, 0, 0, 4]], "wall_ends_episode": False}])
def test_stable_baselines3_finds_no_fault_with_the_maze(rules):
    from stable_baselines3.common.env_checker import check_env

    check_env(Maze(**rules))


def shortest_way_taken(maze, choose):
    """Whether `choose(state)` leads through the lesson's maze to its goal the shortest way."""
    state, _ = maze.reset(seed=0)
    states, terminated = [state], False
    while not terminated and len(states) < 20:
        state, _, terminated, _, _ = maze.step(choose(state))
        states.append(state)
    return terminated and states[-1] in maze.goals and len(states) == 7


def lenient_maze():
    """The lesson's maze, in which a wall costs but does not end the episode."""
    return Maze(step_reward=-0.05, wall_reward=-0.3, wall_ends_episode=False)


def test_stable_baselines3_learns_the_way_through_the_maze_unchanged():
    maze = lenient_maze()
    model = stable_baselines3.PPO(
        "MlpPolicy", maze, n_steps=256, batch_size=256, learning_rate=3e-3, gamma=0.9, seed=0, device="cpu"
    )
    model.learn(5_000)
    assert shortest_way_taken(maze, lambda state: model.predict(np.array(state), deterministic=True)[0])


def test_stable_baselines3s_deep_q_learning_and_ours_learn_the_same_maze_unchanged():
    maze = lenient_maze()
    same = {"gamma": 0.9, "learning_rate": 1e-3, "batch_size": 32, "seed": 0, "device": "cpu"}
    agent = DQNAgent(maze, hidden=(20,), epsilon=0.3, epsilon_decay=1.0, replay=10_000, target_update=100, **same)
    agent.train(num_steps=3_000)
    model = stable_baselines3.DQN(
        "MlpPolicy", maze, buffer_size=10_000, learning_starts=32, train_freq=1, target_update_interval=100,
        exploration_initial_eps=0.3, exploration_final_eps=0.3, policy_kwargs={"net_arch": [20]}, **same,
    )  # fmt: skip
    model.learn(3_000)
    assert shortest_way_taken(maze, lambda state: model.predict(np.array(state), deterministic=True)[0])
    assert shortest_way_taken(maze, lambda state: agent.q_values(np.array([state]))[0, 0].argmax())
    assert agent.test()[0].terminated


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("sight", SIGHTS)
def test_stable_baselines3_finds_no_fault_with_a_side_of_a_share(sight, side):
    from stable_baselines3.common.env_checker import check_env

    check_env(side_env(random_bars(80), sight, side, episode_length=20))


@pytest.mark.parametrize("sight", ["table", "network"])
@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("DQN", {"buffer_size": 500, "learning_starts": 50, "target_update_interval": 50}),
        ("PPO", {"n_steps": 64, "batch_size": 64, "n_epochs": 2}),
    ],
)
def test_stable_baselines3_trains_on_a_side_of_a_share_unchanged(kind, settings, sight):
    prices = RubberBandMarket().prices(400)
    env = side_env(prices, sight, episode_length=60, reward_unit=0.01)
    model = getattr(stable_baselines3, kind)("MlpPolicy", env, seed=0, device="cpu", **settings)
    model.learn(400)
    assert model.num_timesteps >= 400
    observation, info = env.reset(seed=1)
    rewards, over = [], False
    while not over:
        action, _ = model.predict(observation, deterministic=True)
        observation, reward, terminated, truncated, info = env.step(action)
        rewards.append(reward)
        over = terminated or truncated
    assert len(rewards) == 60
    assert 0.01 * sum(rewards) == pytest.approx(info["log_equity"], abs=1e-12)


def test_stable_baselines3_learns_when_to_be_in_a_share_that_rises_every_other_day():
    """By 1 %, and falls as far on the days between: two states, and no doubt what to do."""
    prices = random_bars(300)[["close"]]
    prices["close"] = 100 * np.exp(0.01 * (np.arange(300) % 2))
    env = side_env(prices, "a learner's table", cost=0.0, episode_length=50, reward_unit=0.01)
    model = stable_baselines3.DQN(
        "MlpPolicy", env, learning_rate=3e-3, gamma=0.5, learning_starts=100, train_freq=1, target_update_interval=50,
        exploration_fraction=0.8, policy_kwargs={"net_arch": [16]}, seed=0, device="cpu",
    )  # fmt: skip
    model.learn(1_500)
    observation, info = env.reset(seed=2)
    for _ in range(50):
        action, _ = model.predict(observation, deterministic=True)
        observation, *_, info = env.step(action)
    assert info["log_equity"] > 0.8 * 25 * 0.01
