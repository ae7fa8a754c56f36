"""A known world is what its table says."""

import dataclasses

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import RecordEpisodeStatistics

from course_lib import MDP, Maze

WORLDS = {
    "lake": ("FrozenLake-v1", {}),
    "lake without slipping": ("FrozenLake-v1", {"is_slippery": False}),
    "large lake": ("FrozenLake-v1", {"map_name": "8x8"}),
    "large lake without slipping": ("FrozenLake-v1", {"map_name": "8x8", "is_slippery": False}),
    "cliff": ("CliffWalking-v1", {}),
    "slippery cliff": ("CliffWalkingSlippery-v1", {}),
    "taxi": ("Taxi-v4", {}),
    "taxi in the rain": ("Taxi-v4", {"is_rainy": True}),
}
ARRAYS = ("next_state", "probability", "reward", "terminal")


def make(name):
    env_id, rules = WORLDS[name]
    return gymnasium.make(env_id, **rules)


def coin():
    """Two states, one action, two outcomes: written out for tests that need an MDP of their own."""
    return {
        "next_state": np.array([[[0, 1]], [[1, 1]]]),
        "probability": np.array([[[0.25, 0.75]], [[1.0, 0.0]]]),
        "reward": np.array([[[1.0, -1.0]], [[0.0, 0.0]]]),
        "terminal": np.array([[[False, True]], [[True, True]]]),
    }


@pytest.mark.parametrize("name", WORLDS)
def test_t_and_r_are_what_the_table_says(name):
    env = make(name)
    mdp, table = MDP.from_gymnasium(env), env.unwrapped.P
    assert (mdp.num_states, mdp.num_actions) == (env.observation_space.n, env.action_space.n)
    T, R = np.zeros_like(mdp.T), np.zeros_like(mdp.R)
    for s, actions in table.items():
        for a, outcomes in actions.items():
            for p, s_next, r, _ in outcomes:
                T[s, a, s_next] += p
                R[s, a] += p * r
    np.testing.assert_allclose(mdp.T, T, atol=1e-14)
    np.testing.assert_allclose(mdp.R, R, atol=1e-12)
    np.testing.assert_allclose(mdp.T.sum(axis=2), 1.0, atol=1e-12)


@pytest.mark.parametrize("name", WORLDS)
def test_outcomes_keep_the_tables_order_and_its_ends(name):
    env = make(name)
    mdp, table = MDP.from_gymnasium(env), env.unwrapped.P
    for s in range(mdp.num_states):
        for a in range(mdp.num_actions):
            for k, outcome in enumerate(table[s][a]):
                found = tuple(
                    getattr(mdp, array)[s, a, k] for array in ("probability", "next_state", "reward", "terminal")
                )
                assert found == outcome
            assert mdp.probability[s, a, len(table[s][a]) :].sum() == 0


def test_shapes_and_kinds_of_numbers():
    mdp = Maze(slip=0.1).mdp
    assert [getattr(mdp, name).shape for name in ARRAYS] == [(16, 4, 3)] * 4
    assert [getattr(mdp, name).dtype for name in ARRAYS] == [np.int32, np.float64, np.float64, np.bool_]
    assert Maze().mdp.next_state.shape == (16, 4, 1)
    assert (mdp.T.shape, mdp.R.shape) == ((16, 4, 16), (16, 4))


def test_a_maze_is_its_own_mdp_whatever_is_wrapped_around_it():
    maze = Maze()
    assert MDP.from_gymnasium(maze) is maze.mdp
    assert MDP.from_gymnasium(RecordEpisodeStatistics(maze)) is maze.mdp


@pytest.mark.parametrize("name", ARRAYS)
def test_nothing_in_an_mdp_can_be_written(name):
    mdp = MDP(**coin())
    with pytest.raises(ValueError, match="read-only"):
        getattr(mdp, name)[0, 0, 0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(mdp, name, None)


@pytest.mark.parametrize("name", ARRAYS)
def test_writing_in_ones_own_arrays_later_changes_no_mdp(name):
    arrays = {key: np.array(value, dtype=getattr(MDP(**coin()), key).dtype) for key, value in coin().items()}
    mdp = MDP(**arrays)
    before = getattr(mdp, name).copy()
    arrays[name][0, 0, 0] = 1 - arrays[name][0, 0, 0]
    np.testing.assert_array_equal(getattr(mdp, name), before)


def test_plain_lists_do():
    mdp = MDP(**{name: array.tolist() for name, array in coin().items()})
    np.testing.assert_array_equal(mdp.T, [[[0.25, 0.75]], [[0, 1]]])
    np.testing.assert_array_equal(mdp.R, [[-0.5], [0]])


def test_two_outcomes_that_lead_to_the_same_state_add_up():
    arrays = coin()
    arrays["next_state"][0, 0] = [1, 1]
    np.testing.assert_array_equal(MDP(**arrays).T[0, 0], [0, 1])
