"""Other people's agents take our worlds as they are. Needs the `peers` extra; skipped without it."""

import numpy as np
import pytest

from course_lib import Maze

stable_baselines3 = pytest.importorskip("stable_baselines3")


@pytest.mark.parametrize("rules", [{}, {"slip": 0.2}, {"grid": [[3, 0, 0, 0, 4]], "wall_ends_episode": False}])
def test_stable_baselines3_finds_no_fault_with_the_maze(rules):
    from stable_baselines3.common.env_checker import check_env

    check_env(Maze(**rules))


def test_stable_baselines3_learns_the_way_through_the_maze_unchanged():
    maze = Maze(step_reward=-0.05, wall_reward=-0.3, wall_ends_episode=False)
    model = stable_baselines3.PPO(
        "MlpPolicy", maze, n_steps=256, batch_size=256, learning_rate=3e-3, gamma=0.9, seed=0, device="cpu"
    )
    model.learn(5_000)
    state, _ = maze.reset(seed=0)
    states, terminated = [state], False
    while not terminated and len(states) < 20:
        action, _ = model.predict(np.array(state), deterministic=True)
        state, _, terminated, _, _ = maze.step(action)
        states.append(state)
    assert terminated
    assert states[-1] in maze.goals
    assert len(states) == 7, "the shortest path has six steps"
