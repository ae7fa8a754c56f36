"""How good tables of Q-values are in a maze, and what is the best that anybody can do there."""

import numpy as np

from course_lib.bellman import value_iteration
from course_lib.explore.worlds import with_rules
from course_lib.maze import Action, Tile
from course_lib.plots.board import ALIKE, best_actions


def returns_of(world, tables, gamma):
    """float64[N]: the expected discounted return from the start that the best actions of each table earn.

    Of equally good actions each is taken alike often; a gamma of 1 is taken for a hair less, so that walks without end
    have a return, too. tables: float64[N, S, A].
    """
    mdp, num_states = world.mdp, tables.shape[1]
    step = np.zeros((*tables.shape[1:], num_states))  # the chance to go on in s'
    states, actions = np.indices(mdp.next_state.shape)[:2]
    np.add.at(step, (states, actions, mdp.next_state), np.where(mdp.terminal, 0.0, mdp.probability))
    policies = _best(tables) / _best(tables).sum(axis=2, keepdims=True)
    earned = np.einsum("nsa,sa->ns", policies, mdp.R)
    ahead = min(gamma, 1 - 1e-6) * np.einsum("nsa,sat->nst", policies, step)
    return np.linalg.solve(np.eye(num_states) - ahead, earned[:, :, None])[:, world.start, 0]


def leads_straight(world, tables):
    """bool[N]: whether a table's best actions lead to a goal by a shortest way, where no move slips.

    Of equally good actions every one has to. tables: float64[N, S, A].
    """
    num_states, num_actions = tables.shape[1:]
    ahead, goals = world.mdp.next_state[:, :, 0], np.isin(world.mdp.next_state[:, :, 0], world.goals)
    to = np.zeros((num_states, num_actions, num_states), np.float32)  # a goal is left out: there the way is over
    states, actions = np.nonzero(~goals)
    to[states, actions, ahead[states, actions]] = 1
    best = _best(tables)
    here = np.zeros((len(tables), num_states), np.float32)
    here[:, world.start] = 1
    for _ in range(shortest_way(world)):
        here = np.minimum((here[:, :, None] * best).reshape(len(tables), -1) @ to.reshape(-1, num_states), 1)
    return ~here.any(axis=1)


def greedy_way(world, table):
    """Where the best actions lead from the start, as [(state, action)], and in words how that ends.

    Of equally good actions the first is followed; where all are alike nothing is known, and the way ends.
    """
    way, seen, state = [], set(), world.start
    while state not in world.goals:
        best = best_actions(table[state])
        if len(best) == len(Action):
            return way, f"in cell {state} all actions are alike to it"
        if state in seen:
            return way, f"it runs in a circle through cell {state}"
        seen.add(state)
        way.append((state, int(best[0])))
        ahead, over = int(world.mdp.next_state[state, best[0], 0]), world.mdp.terminal[state, best[0], 0]
        if over and ahead not in world.goals:
            return way, f"a bump in cell {state} ends it"
        state = ahead
    return way, "to the cheese"


def shortest_way(world):
    """Moves from the start to the nearest goal, where no move slips."""
    ahead, steps, reached = world.mdp.next_state[:, :, 0], 0, {world.start}
    while not reached & set(world.goals):
        reached |= {int(s) for state in reached for s in ahead[state]}
        steps += 1
    return steps


def _best(tables):
    return tables >= tables.max(axis=2, keepdims=True) - ALIKE


def solution(world, gamma):
    """The exact solution of what can be reached in a world; None where rewards may be gathered without end."""
    mdp = world.mdp
    if gamma == 1 and (mdp.reward[~mdp.terminal] > 0).any():
        return None
    return value_iteration(without_pockets(world).mdp, gamma)


def without_pockets(world, **changed):
    """The same maze with walls in the cells that cannot be reached, and so cannot be left; changed: its other rules."""
    ahead, reached = world.mdp.next_state[:, :, 0], {world.start}
    while not (further := {int(s) for state in reached for s in ahead[state]}) <= reached:
        reached |= further
    grid = world.grid.copy()
    shut = (grid.ravel() == Tile.OPEN) & ~np.isin(np.arange(grid.size), list(reached))
    grid[shut.reshape(grid.shape)] = Tile.WALL
    return with_rules(world, grid=grid, **changed)


def fewest_moves(world):
    """The least number of moves that leads to a goal, on average where moves slip; None where it is not known."""
    if not world.slip:
        return float(shortest_way(world))
    if world.wall_ends_episode:
        return None
    every_move = {"step_reward": -1.0, "wall_reward": -1.0, "goal_reward": -1.0, "cell_rewards": None}
    return -float(value_iteration(without_pockets(world, **every_move).mdp, 1.0).values[world.start])


def best_reward(world):
    """The best possible reward of an episode, on average; None where there is no end to it."""
    exact = solution(world, 1.0)
    return None if exact is None else float(exact.values[world.start])
