"""Many Q-tables in one compiled call: the same as one agent after the other, to the last bit."""

import gymnasium
import numpy as np
import pytest

from course_lib import Maze, QAgent
from course_lib.q_table import train_side_by_side


@pytest.mark.parametrize(
    ("make", "settings"),
    [
        (Maze, {}),
        (lambda: Maze(wall_reward=0.0, wall_ends_episode=False), {"alpha": 0.5}),
        (lambda: Maze(slip=0.3), {"alpha_power": 0.7, "epsilon": 0.4, "epsilon_decay": 0.99}),
        (lambda: gymnasium.make("FrozenLake-v1"), {"gamma": 0.99}),
        (lambda: gymnasium.make("Taxi-v4"), {}),
        (lambda: gymnasium.wrappers.TimeLimit(Maze(wall_ends_episode=False), 7), {}),
        (lambda: gymnasium.Wrapper(Maze()), {}),  # stepped in Python
    ],
    ids=["strict", "kind", "slippery", "lake", "taxi", "time limit", "python"],
)
def test_side_by_side_each_learns_what_it_learns_alone(make, settings):
    seeds = [3, 0, 11]
    tables, history = train_side_by_side(make(), seeds, 60, max_steps=50, **settings)
    for i, seed in enumerate(seeds):
        alone = QAgent(make(), seed=seed, **settings)
        expected = alone.train(60, max_steps=50)
        assert np.array_equal(tables[i], alone.q_table)
        for name in ("episode_return", "episode_length", "terminated", "truncated"):
            assert np.array_equal(getattr(history, name)[i], getattr(expected, name)), name
    assert len(history) == 60


@pytest.mark.parametrize(
    ("arguments", "settings"),
    [
        (([],), {}),
        (([1.5],), {}),
        (([-1],), {}),
        (([0], -1), {}),
        (([0], 1.5), {}),
        (([0],), {"max_steps": 0}),
        (([0],), {"alpha": 2}),
    ],
)
def test_side_by_side_refuses_what_an_agent_refuses(arguments, settings):
    with pytest.raises(ValueError, match=r"must be"):
        train_side_by_side(Maze(), *arguments, **settings)
