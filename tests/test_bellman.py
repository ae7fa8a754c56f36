"""Planners against an exact solver that knows nothing of them, against closed forms, and against their own promises."""

from collections import deque

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_maze import random_rules, world_by_the_rules

from course_lib import (
    MDP,
    Maze,
    action_values,
    bellman,
    bellman_sweep,
    evaluate_policy,
    policy_iteration,
    value_iteration,
)

UP, DOWN, LEFT, RIGHT = range(4)
PLANNERS = {"value iteration": value_iteration, "policy iteration": policy_iteration}


def best_values(table, gamma):
    """V* of table[s][a] = [(probability, next state, reward, ends), …] by Howard's policy iteration on dense arrays."""
    S, A = len(table), len(table[0])
    states, T, R = np.arange(S), np.zeros((S, A, S)), np.zeros((S, A))
    for s in range(S):
        for a in range(A):
            for p, s_next, r, ends in table[s][a]:
                R[s, a] += p * r
                T[s, a, s_next] += 0.0 if ends else p
    policy = np.zeros(S, int)
    while True:
        values = np.linalg.solve(np.eye(S) - gamma * T[states, policy], R[states, policy])
        q = R + gamma * T @ values
        better = q.max(axis=1) > q[states, policy] + 1e-12 * max(1.0, np.abs(values).max())
        if not better.any():
            return values
        policy = np.where(better, q.argmax(axis=1), policy)


def table_of(mdp):
    """A handmade MDP in the form that `best_values` takes."""
    S, A, K = mdp.next_state.shape
    arrays = (mdp.probability, mdp.next_state, mdp.reward, mdp.terminal)
    return [[[tuple(array[s, a, k] for array in arrays) for k in range(K)] for a in range(A)] for s in range(S)]


def random_mdp(rng, S, A, K):
    """Any world at all: loops, ends and rewards of either sign in every place."""
    return MDP(
        next_state=rng.integers(0, S, (S, A, K)),
        probability=rng.dirichlet(np.ones(K), (S, A)),
        reward=rng.normal(size=(S, A, K)),
        terminal=rng.random((S, A, K)) < rng.choice([0.0, 0.2]),
    )


def random_mixed_policy(rng, mdp):
    return rng.dirichlet(np.ones(mdp.num_actions), mdp.num_states)


def policys_own_values(mdp, policy, gamma):
    """V_pi of a mixed policy by one dense solve, entry by entry."""
    S, A, K = mdp.next_state.shape
    T, R = np.zeros((S, S)), np.zeros(S)
    for s, a, k in np.ndindex(S, A, K):
        p = policy[s, a] * mdp.probability[s, a, k]
        R[s] += p * mdp.reward[s, a, k]
        T[s, mdp.next_state[s, a, k]] += 0.0 if mdp.terminal[s, a, k] else p
    return np.linalg.solve(np.eye(S) - gamma * T, R)


def assert_is_optimal(solution, mdp, expected, gamma):
    scale = max(1.0, np.abs(expected).max())
    assert np.abs(solution.values - expected).max() <= 1e-8 + 1e-12 * scale
    assert np.abs(solution.q.max(axis=1) - expected).max() <= 1e-8 + 1e-12 * scale
    chosen = solution.q[np.arange(mdp.num_states), solution.policy]
    np.testing.assert_allclose(chosen, solution.q.max(axis=1), rtol=0, atol=1e-10 * scale)
    followed = evaluate_policy(mdp, solution.policy, gamma)
    assert np.abs(followed - expected).max() <= 2e-8 / (1 - gamma), "the policy earns what it promises"


# --- against the exact solver -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(200))
def test_both_planners_solve_random_mazes_exactly(seed):
    rules, gamma = random_rules(1000 + seed), float(np.random.default_rng(seed).uniform(0.5, 0.99))
    mdp, expected = Maze(**rules).mdp, best_values(world_by_the_rules(**rules), gamma)
    for plan in PLANNERS.values():
        assert_is_optimal(plan(mdp, gamma), mdp, expected, gamma)


@pytest.mark.parametrize("seed", range(60))
def test_both_planners_solve_worlds_that_are_no_mazes(seed):
    rng = np.random.default_rng(seed)
    mdp = random_mdp(rng, *rng.integers(1, [12, 5, 4]))
    gamma = float(rng.uniform(0.5, 0.99))
    expected = best_values(table_of(mdp), gamma)
    for plan in PLANNERS.values():
        assert_is_optimal(plan(mdp, gamma), mdp, expected, gamma)


@pytest.mark.parametrize("gamma", [0.9, 0.99])
@pytest.mark.parametrize(
    ("env_id", "rules"),
    [
        ("FrozenLake-v1", {"map_name": "4x4", "is_slippery": True}),
        ("FrozenLake-v1", {"map_name": "4x4", "is_slippery": False}),
        ("FrozenLake-v1", {"map_name": "8x8", "is_slippery": True}),
        ("FrozenLake-v1", {"map_name": "8x8", "is_slippery": False}),
        ("CliffWalking-v1", {}),
        ("Taxi-v4", {}),
    ],
)
def test_both_planners_solve_gymnasiums_worlds_exactly(env_id, rules, gamma):
    env = gymnasium.make(env_id, **rules)
    mdp, expected = MDP.from_gymnasium(env), best_values(env.unwrapped.P, gamma)
    for plan in PLANNERS.values():
        assert_is_optimal(plan(mdp, gamma), mdp, expected, gamma)


# --- large worlds -----------------------------------------------------------------------------------------------------


def steps_to_the_goal(grid):
    """Breadth first from the goal in the bottom right corner; -1 where there is no way."""
    rows, columns = grid.shape
    wide = columns + 2
    distance = np.where(np.pad(grid, 1, constant_values=1) == 1, -2, -1).ravel().tolist()
    goal = rows * wide + columns
    distance[goal] = 0
    waiting = deque([goal])
    while waiting:
        cell = waiting.popleft()
        for neighbour in (cell - wide, cell + wide, cell - 1, cell + 1):
            if distance[neighbour] == -1:
                distance[neighbour] = distance[cell] + 1
                waiting.append(neighbour)
    return np.array(distance).reshape(rows + 2, wide)[1:-1, 1:-1].ravel()


def test_a_million_cells_are_worth_their_distance_from_the_goal():
    maze, gamma = Maze.random(1000, 1000, walls=0.35, seed=0, wall_ends_episode=False, wall_reward=0.0), 0.999
    distance = steps_to_the_goal(maze.grid)
    expected = np.where(distance > 0, gamma ** (distance - 1.0), 0.0)  # walls, the goal and closed cells: nothing
    values = value_iteration(maze.mdp, gamma).values
    assert distance.max() > 1900
    assert (distance == -1).any()
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-10)


def test_ninety_thousand_slippery_cells_satisfy_the_equation_and_both_planners_agree():
    mdp, gamma = Maze.random(300, 300, slip=0.2, seed=0).mdp, 0.99
    solution = value_iteration(mdp, gamma)
    residual = np.abs(bellman_sweep(mdp, solution.values, gamma) - solution.values).max()
    assert residual <= 1e-8
    assert solution.error_bound <= 1e-8
    np.testing.assert_allclose(policy_iteration(mdp, gamma).values, solution.values, rtol=0, atol=2e-8)


# --- what is promised about the answer --------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [3.0, 0.3, 1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("seed", range(10))
def test_the_error_bound_is_honest_and_within_the_tolerance(seed, tolerance):
    rng = np.random.default_rng(seed)
    rules = random_rules(2000 + seed)
    worlds = [random_mdp(rng, 10, 3, 3), random_mdp(rng, 10, 3, 1), Maze(**rules).mdp]
    tables = [table_of(worlds[0]), table_of(worlds[1]), world_by_the_rules(**rules)]
    for mdp, table in zip(worlds, tables, strict=True):
        for gamma in (0.5, 0.9, 0.99):
            expected, solution = best_values(table, gamma), value_iteration(mdp, gamma, tolerance=tolerance)
            assert solution.error_bound <= tolerance
            rounding = 1e-12 * max(1.0, np.abs(expected).max())
            assert np.abs(solution.values - expected).max() <= solution.error_bound + rounding


def test_a_loose_tolerance_is_cheaper_and_its_bound_larger():
    mdp = Maze.random(12, 12, slip=0.3, seed=0).mdp
    loose, tight = value_iteration(mdp, 0.99, tolerance=1.0), value_iteration(mdp, 0.99, tolerance=1e-10)
    assert loose.sweeps < tight.sweeps
    assert loose.error_bound > tight.error_bound


@pytest.mark.parametrize("seed", range(10))
def test_a_tolerance_finer_than_rounding_is_not_waited_for(seed):
    rng = np.random.default_rng(seed)
    mdp = random_mdp(rng, 20, 3, int(rng.integers(1, 30)))
    solution = value_iteration(mdp, 0.99, tolerance=1e-300)
    np.testing.assert_allclose(solution.values, best_values(table_of(mdp), 0.99), rtol=1e-11, atol=1e-11)


def test_planning_changes_nothing_in_the_world_and_gives_the_same_twice():
    mdp = Maze.random(6, 6, slip=0.3, seed=0).mdp
    for plan in PLANNERS.values():
        first, second = plan(mdp, 0.9), plan(mdp, 0.9)
        assert first.values.tobytes() == second.values.tobytes()
        assert first.policy.tobytes() == second.policy.tobytes()


def test_shapes_and_kinds_of_numbers_of_a_solution():
    for plan in PLANNERS.values():
        solution = plan(Maze().mdp, 0.9)
        assert (solution.values.shape, solution.q.shape, solution.policy.shape) == ((16,), (16, 4), (16,))
        assert (solution.values.dtype, solution.q.dtype, solution.policy.dtype) == (float, float, np.int64)
        assert solution.sweeps >= 1


# --- the lesson's maze ------------------------------------------------------------------------------------------------


def test_values_of_the_lessons_maze():
    values = value_iteration(Maze().mdp, 0.9).values.reshape(4, 4)
    path = [values[0, 0], values[0, 1], values[1, 1], values[2, 1], values[3, 1], values[3, 2], values[3, 3]]
    np.testing.assert_allclose(path, [0.9**5, 0.9**4, 0.9**3, 0.9**2, 0.9, 1.0, 0.0], atol=1e-12)


def test_action_values_are_the_right_hand_side_of_the_equation():
    q = action_values(Maze(step_reward=-0.1).mdp, np.arange(16.0), 0.5)
    assert q[0, RIGHT] == -0.1 + 0.5 * 1
    assert q[0, UP] == -0.1 + 0.5 * 0
    assert q[5, RIGHT] == -1.0, "nothing follows a wall that ends the episode"
    assert q[14, RIGHT] == 1.0, "nothing follows the goal"


def test_a_sweep_needs_no_values_but_the_old_ones_and_leaves_them_alone():
    mdp, old = Maze().mdp, np.arange(16.0)
    new = bellman_sweep(mdp, old, 0.5)
    assert old.tolist() == list(range(16))
    assert new[0] == 0.5 * 4, "DOWN leads to state 4, and not to what state 4 has become"


def test_a_sweep_of_a_policy_takes_actions_or_probabilities():
    mdp, old = Maze(slip=0.2).mdp, np.random.default_rng(0).normal(size=16)
    policy = np.random.default_rng(1).integers(0, 4, 16)
    q = action_values(mdp, old, 0.9)
    np.testing.assert_array_equal(bellman_sweep(mdp, old, 0.9, policy), q[np.arange(16), policy])
    np.testing.assert_array_equal(bellman_sweep(mdp, old, 0.9, np.eye(4)[policy]), q[np.arange(16), policy])
    np.testing.assert_allclose(bellman_sweep(mdp, old, 0.9, np.full((16, 4), 0.25)), q.mean(axis=1), atol=1e-15)


# --- what a policy is worth -------------------------------------------------------------------------------------------


def coin_walk(states):
    """A fair coin moves the walker one state left or right; beyond the last state it ends, and pays 1."""
    s = np.arange(states)
    next_state = np.stack([np.maximum(s - 1, 0), np.minimum(s + 1, states - 1)], axis=1)[:, None]
    terminal = np.stack([s == 0, s == states - 1], axis=1)[:, None]
    reward = np.stack([np.zeros(states), (s == states - 1) * 1.0], axis=1)[:, None]
    return MDP(next_state, np.full((states, 1, 2), 0.5), reward, terminal)


def test_the_chance_to_win_a_coin_walk_is_how_far_one_has_come():
    mdp = coin_walk(9)
    np.testing.assert_allclose(evaluate_policy(mdp, np.zeros(9, int), 1.0), np.arange(1, 10) / 10, atol=1e-12)
    np.testing.assert_allclose(policy_iteration(mdp, 1.0).values, np.arange(1, 10) / 10, atol=1e-12)
    np.testing.assert_allclose(value_iteration(mdp, 1.0, tolerance=1e-12).values, np.arange(1, 10) / 10, atol=1e-9)


def test_a_reward_for_ever_is_worth_one_over_one_minus_gamma():
    mdp = MDP([[[0]]], [[[1.0]]], [[[1.0]]], [[[False]]])
    for gamma in (0.5, 0.9, 0.999):
        expected = [pytest.approx(1 / (1 - gamma), rel=1e-9)]
        assert evaluate_policy(mdp, [0], gamma) == expected
        assert value_iteration(mdp, gamma).values == expected
        assert policy_iteration(mdp, gamma).values == expected


@pytest.mark.parametrize("seed", range(20))
def test_the_value_of_a_mixed_policy_solves_its_equations(seed):
    rng = np.random.default_rng(seed)
    mdp, gamma = Maze(**random_rules(seed)).mdp, float(rng.uniform(0.5, 0.99))
    policy = random_mixed_policy(rng, mdp)
    np.testing.assert_allclose(
        evaluate_policy(mdp, policy, gamma), policys_own_values(mdp, policy, gamma), rtol=1e-10, atol=1e-10
    )


@pytest.mark.parametrize("slip", [0.0, 0.3])
def test_a_large_world_is_evaluated_as_exactly_as_a_small_one(slip):
    rng = np.random.default_rng(0)
    mdp = Maze.random(40, 40, slip=slip, step_reward=-0.1, wall_ends_episode=False, seed=0).mdp
    assert mdp.num_states > bellman._DENSE_STATES
    for policy in (random_mixed_policy(rng, mdp), np.eye(4)[rng.integers(0, 4, 1600)]):
        expected = policys_own_values(mdp, policy, 0.95)
        np.testing.assert_allclose(evaluate_policy(mdp, policy, 0.95), expected, rtol=0, atol=1e-9)
    as_actions = policy.argmax(axis=1)
    np.testing.assert_allclose(evaluate_policy(mdp, as_actions, 0.95), expected, rtol=0, atol=1e-9)


# --- gamma at its ends ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("plan", PLANNERS.values(), ids=PLANNERS.keys())
def test_with_gamma_0_only_the_next_reward_counts(plan):
    mdp = Maze.random(5, 5, slip=0.2, step_reward=-0.1, seed=0).mdp
    solution = plan(mdp, 0)
    np.testing.assert_allclose(solution.values, mdp.R.max(axis=1), atol=1e-15)
    assert solution.error_bound == 0
    np.testing.assert_allclose(evaluate_policy(mdp, np.zeros(25, int), 0), mdp.R[:, 0], atol=1e-15)


def test_with_gamma_1_a_step_that_costs_1_counts_the_steps():
    maze = Maze(step_reward=-1.0, goal_reward=0.0, wall_ends_episode=False)
    solution = value_iteration(maze.mdp, 1)
    distance = steps_to_the_goal(maze.grid)
    np.testing.assert_allclose(solution.values, np.where(distance > 0, 1.0 - distance, 0.0), atol=1e-12)
    assert solution.error_bound == np.inf


def test_with_gamma_1_the_values_of_gymnasiums_worlds_are_the_known_ones():
    cliff = MDP.from_gymnasium(gymnasium.make("CliffWalking-v1"))
    assert value_iteration(cliff, 1).values[36] == pytest.approx(-13, abs=1e-12)
    lake = MDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
    assert value_iteration(lake, 1, tolerance=1e-13).values[0] == pytest.approx(14 / 17, abs=1e-9)


def test_with_gamma_1_a_world_without_end_is_refused(monkeypatch):
    monkeypatch.setattr(bellman, "_MOST_SWEEPS", 200)
    paying = Maze([[3, 0, 4]], step_reward=1.0)
    with pytest.raises(ValueError, match=r"gamma = 1.*200 sweeps.*never reaches an end"):
        value_iteration(paying.mdp, 1)
    large = Maze.random(40, 40, walls=0.0, step_reward=-1.0).mdp
    with pytest.raises(ValueError, match=r"gamma = 1.*never reaches an end"):
        evaluate_policy(large, np.full(1600, UP), 1)


def test_with_gamma_1_a_policy_that_never_ends_is_refused():
    maze = Maze([[3, 0, 4]])
    with pytest.raises(ValueError, match=r"gamma = 1.*ever end"):
        evaluate_policy(maze.mdp, [UP, UP, UP], 1)
    with pytest.raises(ValueError, match=r"gamma = 1.*ever end"):
        policy_iteration(maze.mdp, 1)
    assert evaluate_policy(maze.mdp, [RIGHT, RIGHT, UP], 1).tolist() == [1.0, 1.0, 0.0]


@pytest.mark.parametrize("seed", range(100))
def test_with_gamma_1_a_policy_has_its_value_or_is_refused_and_never_rounding_noise(seed):
    """A slippery world can be singular only up to rounding; a linear solve then gives numbers that mean nothing."""
    rng = np.random.default_rng(seed)
    mdp = Maze.random(*(int(n) for n in rng.integers(2, 7, 2)), walls=0.3, slip=float(rng.uniform(0.05, 0.5)),
                      wall_ends_episode=False, wall_reward=0.0, seed=seed).mdp  # fmt: skip
    policy = np.eye(4)[rng.integers(0, 4, mdp.num_states)]
    chance = policy[:, :, None] * mdp.probability
    ending = np.zeros(mdp.num_states)
    for _ in range(mdp.num_states):  # by then every state that can come to an end has a chance to have done so
        ending = (chance * np.where(mdp.terminal, 1.0, ending[mdp.next_state])).sum(axis=(1, 2))
    if (ending > 0).all():
        values = evaluate_policy(mdp, policy, 1)
        np.testing.assert_allclose(values, bellman_sweep(mdp, values, 1, policy), atol=1e-9)
        assert values.min() >= -1e-9
        assert values.max() <= 1 + 1e-9, "no more than the goal pays"
    else:
        with pytest.raises(ValueError, match="ever end"):
            evaluate_policy(mdp, policy, 1)


# --- laws -------------------------------------------------------------------------------------------------------------

worlds = st.builds(
    lambda seed, S, A, K: random_mdp(np.random.default_rng(seed), S, A, K),
    st.integers(0, 2**32), st.integers(1, 8), st.integers(1, 4), st.integers(1, 3),
)  # fmt: skip
gammas = st.floats(0, 0.99)
seeds = st.integers(0, 2**32)
lawful = settings(derandomize=True, deadline=None, max_examples=100)


@lawful
@given(worlds, gammas, seeds, st.floats(0, 100))
def test_a_sweep_brings_any_two_guesses_closer_by_gamma(mdp, gamma, seed, size):
    rng = np.random.default_rng(seed)
    u, v = rng.normal(size=(2, mdp.num_states)) * size
    apart = np.abs(u - v).max()
    for policy in (None, random_mixed_policy(rng, mdp)):
        after = np.abs(bellman_sweep(mdp, u, gamma, policy) - bellman_sweep(mdp, v, gamma, policy)).max()
        assert after <= gamma * apart + 1e-12 * (1 + size)


@lawful
@given(worlds, gammas, seeds)
def test_a_sweep_of_larger_values_gives_larger_values(mdp, gamma, seed):
    rng = np.random.default_rng(seed)
    low = rng.normal(size=mdp.num_states)
    high = low + rng.random(mdp.num_states) * rng.integers(0, 2, mdp.num_states)
    for policy in (None, random_mixed_policy(rng, mdp)):
        rise = bellman_sweep(mdp, high, gamma, policy) - bellman_sweep(mdp, low, gamma, policy)
        assert rise.min() >= -1e-12


@lawful
@given(worlds, gammas)
def test_the_best_values_satisfy_their_equation(mdp, gamma):
    for plan in PLANNERS.values():
        values = plan(mdp, gamma).values
        assert np.abs(bellman_sweep(mdp, values, gamma) - values).max() <= 1e-8


@lawful
@given(worlds, gammas, seeds)
def test_no_policy_earns_more_than_the_best_values_in_any_state(mdp, gamma, seed):
    rng = np.random.default_rng(seed)
    best = value_iteration(mdp, gamma).values
    for policy in (random_mixed_policy(rng, mdp), rng.integers(0, mdp.num_actions, mdp.num_states)):
        assert (evaluate_policy(mdp, policy, gamma) <= best + 1e-8).all()
