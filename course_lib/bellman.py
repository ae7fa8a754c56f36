"""Plan in a known world: what a policy is worth, and which policy is best.

The Bellman equations (Sutton & Barto, 2nd ed., sections 3.5, 3.6 and chapter 4), one equation a state:

    V_pi(s) = R(s, pi(s)) + gamma Σ_s' T(s, pi(s), s') V_pi(s')
    V*(s)   = max_a ( R(s, a) + gamma Σ_s' T(s, a, s') V*(s') )
"""

from dataclasses import dataclass

import numpy as np

from course_lib.mdp import MDP
from course_lib.validate import fraction, number

_DENSE_STATES = 1500  # up to here a linear system is solved as one; beyond, sweeps reach the same to 1e-12
_SWEEPS_BETWEEN = 10  # cheap sweeps of one policy between two that improve it (modified policy iteration)
_MOST_SWEEPS = 100_000  # gamma = 1 only: by then a world that has an end has come to it


@dataclass(frozen=True, eq=False)
class Solution:
    """What a planner found: S states, A actions.

    values       float64[S]     V*, as far as it was computed
    q            float64[S, A]  Q*
    policy       int64[S]       a best action; which one, where several are equal up to rounding, is left open
    sweeps       how often every state was looked at to improve the policy
    error_bound  no value is further than this from V* (inf for gamma = 1, where no bound follows from the last change)
    """

    values: np.ndarray
    q: np.ndarray
    policy: np.ndarray
    sweeps: int
    error_bound: float


def action_values(mdp, values, gamma):
    """Q(s, a) = Σ_k probability (reward + gamma V(next_state)), float64[S, A]; nothing follows an end.

    values: float64[S]. `ValueError` for a gamma outside [0, 1] or values of another shape.
    """
    _check_mdp(mdp)
    gamma, values = fraction("gamma", gamma), _checked_values(mdp, values)
    following = np.where(mdp.terminal, 0.0, values[mdp.next_state])
    return (mdp.probability * (mdp.reward + gamma * following)).sum(axis=2)


def bellman_sweep(mdp, values, gamma, policy=None):
    """One sweep: the right-hand side of every state's Bellman equation at once, from the old `values`, float64[S].

    Without a policy the optimality equation; with one (int[S] or float[S, A]) that policy's own.
    Either brings two guesses closer together by a factor of gamma or better.
    """
    q = action_values(mdp, values, gamma)
    if policy is None:
        return q.max(axis=1)
    return (_as_probabilities(mdp, policy) * q).sum(axis=1)


def evaluate_policy(mdp, policy, gamma):
    """V_pi, float64[S]: the exact solution of the policy's linear equations; policy: int[S] or float[S, A].

    Up to 1,500 states one linear solve, (I - gamma T_pi) V = R_pi; beyond that sweeps, to a bound of 1e-12 of the
    largest value. `ValueError` for a policy that is not one and, at gamma = 1, for one under which an episode may never
    end.
    """
    _check_mdp(mdp)
    gamma, weights = fraction("gamma", gamma), _as_probabilities(mdp, policy)
    if mdp.num_states <= _DENSE_STATES:
        if gamma == 1:
            _refuse_never_ending(mdp, weights)
        return _solve_densely(mdp, weights, gamma)
    values = np.zeros(mdp.num_states)
    _settle(_follow_mixed_policy(mdp, weights, gamma), values, gamma)
    return values


def value_iteration(mdp, gamma, *, tolerance=1e-8):
    """V*, Q* and a best policy, no value further than `tolerance` from V* (gamma < 1).

    Sweeps in place, forwards and backwards in turn, with a few sweeps of the policy just found between two that
    improve it (modified policy iteration: Puterman & Shin, 1978); where every action has one outcome the news is
    first passed from state to state. For gamma = 1 it stops when nothing changes by more than `tolerance`.
    `ValueError` for a gamma outside [0, 1], a tolerance that is not positive, and a world without end at gamma = 1.
    """
    from course_lib import kernels

    _check_mdp(mdp)
    gamma = fraction("gamma", gamma)
    if number("tolerance", tolerance) <= 0:
        raise ValueError(f"tolerance must be positive, got {tolerance!r}")
    world, values = _world(mdp), np.zeros(mdp.num_states)
    q, policy = np.empty((mdp.num_states, mdp.num_actions)), np.zeros(mdp.num_states, np.int64)
    if mdp.next_state.shape[2] == 1:
        kernels.spread_news(world, gamma, values)
    sweeps, change = 1, kernels.all_action_values(world, gamma, values, q, policy)
    most_sweeps = _enough_sweeps(change, gamma, tolerance)
    while not _settled(change, values, gamma, tolerance):
        if sweeps == most_sweeps:
            _refuse_endless(gamma)
            change = kernels.all_action_values(world, gamma, values, q, policy)
            break
        followed = kernels.follow_policy(world, gamma, policy)
        for i in range(_SWEEPS_BETWEEN):
            if kernels.sweep_policy(*followed, values, i % 2 == 0) <= change * 1e-2:
                break
        change = kernels.sweep_best(world, gamma, values, policy, sweeps % 2 == 1)
        sweeps += 1
        if _settled(change, values, gamma, tolerance):
            change = kernels.all_action_values(world, gamma, values, q, policy)
    _refuse_overflow(values)
    return Solution(values, q, policy, sweeps, _bound(change, gamma))


def policy_iteration(mdp, gamma):
    """V*, Q* and a best policy by turns: evaluate the policy exactly, then choose the best action everywhere.

    An action is given up only for one better by more than rounding, so it ends (Howard, 1960; Sutton & Barto, 4.3).
    `sweeps` counts the improvements. At gamma = 1 it needs a world in which every policy comes to an end; where that
    fails it raises `ValueError`, as `evaluate_policy` does.
    """
    from course_lib import kernels

    _check_mdp(mdp)
    gamma, states = fraction("gamma", gamma), np.arange(mdp.num_states)
    policy = np.zeros(mdp.num_states, np.int64)
    q, values = np.empty((mdp.num_states, mdp.num_actions)), np.zeros(mdp.num_states)
    if gamma < 1:  # a first policy that has heard of the rewards spares large worlds many evaluations
        policy = value_iteration(mdp, gamma, tolerance=1e-2).policy
    sweeps = 0
    while True:
        values = _evaluate_actions(mdp, policy, gamma, values)
        best = np.empty_like(policy)
        change = kernels.all_action_values(_world(mdp), gamma, values, q, best)
        sweeps += 1
        margin = 1e-11 * max(1.0, np.abs(values).max())
        better = q[states, best] > q[states, policy] + margin
        if not better.any():
            return Solution(values, q, policy, sweeps, _bound(change, gamma))
        policy = np.where(better, best, policy)


def _check_mdp(mdp):
    if not isinstance(mdp, MDP):
        raise ValueError(f"an MDP is needed, got a {type(mdp).__name__}: take maze.mdp, or MDP.from_gymnasium(env)")


def _world(mdp):
    return mdp.next_state, mdp.probability, mdp.reward, mdp.terminal


def _checked_values(mdp, values):
    values = np.asarray(values, dtype=float)
    if values.shape != (mdp.num_states,):
        raise ValueError(f"values must have shape ({mdp.num_states},), one a state, got {values.shape}")
    if not np.isfinite(values).all():
        raise ValueError("values must be finite, got NaN or infinity")
    return values


def _as_probabilities(mdp, policy):
    """The policy as float64[S, A], rows summing to 1."""
    policy = np.asarray(policy)
    shape = (mdp.num_states, mdp.num_actions)
    if policy.shape == shape[:1] and np.issubdtype(policy.dtype, np.integer):
        if policy.min() < 0 or policy.max() >= shape[1]:
            raise ValueError(
                f"a policy's actions must be from 0 to {shape[1] - 1}, got {policy.min()} to {policy.max()}"
            )
        return np.eye(shape[1])[policy]
    if policy.shape != shape or not np.issubdtype(policy.dtype, np.number):
        raise ValueError(
            f"a policy is int[{shape[0]}] (actions) or float{list(shape)} (probabilities),"
            f" got {policy.dtype}{list(policy.shape)}"
        )
    if not ((policy >= 0).all() and (np.abs(policy.sum(axis=1) - 1) <= 1e-9).all()):
        raise ValueError("a policy's probabilities must not be negative or NaN, and sum to 1 in every state")
    return policy.astype(float)


def _solve_densely(mdp, weights, gamma):
    reward = (weights * mdp.R).sum(axis=1)
    going_on = np.zeros((mdp.num_states, mdp.num_states))
    chance = weights[:, :, None] * np.where(mdp.terminal, 0.0, mdp.probability)
    np.add.at(going_on, (np.arange(mdp.num_states)[:, None, None], mdp.next_state), chance)
    try:
        values = np.linalg.solve(np.eye(mdp.num_states) - gamma * going_on, reward)
    except np.linalg.LinAlgError:
        values = np.full(mdp.num_states, np.inf)
    if gamma == 1 and not np.abs(values).max() < 1e12:  # singular up to rounding
        raise ValueError("at gamma = 1 this policy's values are not defined: an episode under it may never end")
    _refuse_overflow(values)
    return values


def _refuse_never_ending(mdp, weights):
    """At gamma = 1 the equations have one solution exactly where an end can be reached from every state."""
    may_happen = (weights[:, :, None] > 0) & (mdp.probability > 0)
    ending, before = (may_happen & mdp.terminal).any(axis=(1, 2)), None
    while not np.array_equal(ending, before):
        before = ending
        ending = before | (may_happen & before[mdp.next_state]).any(axis=(1, 2))
    if not ending.all():
        state = np.flatnonzero(~ending)[0]
        raise ValueError(f"at gamma = 1 this policy's values are not defined: from state {state} no episode ever ends")


def _follow_mixed_policy(mdp, weights, gamma):
    """gain[S], weight[S, A·K] and following[S, A·K] of a policy that may mix actions."""
    chance = weights[:, :, None] * np.where(mdp.terminal, 0.0, mdp.probability)
    gain = (weights * mdp.R).sum(axis=1)
    return gain, gamma * chance.reshape(mdp.num_states, -1), mdp.next_state.reshape(mdp.num_states, -1)


def _evaluate_actions(mdp, policy, gamma, values):
    """V of a policy int[S]; large worlds start from `values`, which are overwritten."""
    if mdp.num_states <= _DENSE_STATES:
        return evaluate_policy(mdp, policy, gamma)
    from course_lib import kernels

    _settle(kernels.follow_policy(_world(mdp), gamma, policy), values, gamma)
    return values


def _settle(followed, values, gamma):
    """Sweep one policy's equations, there and back, to within 1e-12 of the largest value, or to rounding."""
    from course_lib import kernels

    sweeps, change = 1, kernels.sweep_policy(*followed, values, False)
    most_sweeps = _enough_sweeps(change, gamma, 1e-12)
    while not _settled(change, values, gamma, 1e-12 * max(1.0, np.abs(values).max())):
        if sweeps == most_sweeps:
            _refuse_endless(gamma)
            break
        change = kernels.sweep_policy(*followed, values, sweeps % 2 == 1)
        sweeps += 1
    _refuse_overflow(values)


def _bound(change, gamma):
    """How far values may be from the fixed point after a last sweep that moved them by `change`."""
    return float(change * gamma / (1 - gamma)) if gamma < 1 else np.inf


def _settled(change, values, gamma, tolerance):
    if (change if gamma == 1 else _bound(change, gamma)) <= tolerance:
        return True
    return change <= 4 * np.finfo(float).eps * np.abs(values).max()


def _enough_sweeps(change, gamma, tolerance):
    """By when a contraction that begins with `change` has settled, with time to spare; later only rounding moves."""
    if gamma in (0, 1) or not 0 < change < np.inf:
        return _MOST_SWEEPS
    return 100 + 3 * max(0, int(np.log(tolerance * (1 - gamma) / change) / np.log(gamma)))


def _refuse_overflow(values):
    if not np.isfinite(values).all():
        raise ValueError("the values grow beyond what a number can hold: the rewards are too large")


def _refuse_endless(gamma):
    if gamma == 1:
        raise ValueError(
            f"at gamma = 1 the values do not settle in {_MOST_SWEEPS} sweeps: some state never reaches an end"
        )
