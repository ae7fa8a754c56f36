"""Other people's agents take our worlds as they are. Needs the `peers` extra; skipped without it."""

import numpy as np
import pytest
import torch

from course_lib import Maze
from course_lib.dqn import DQNAgent

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
