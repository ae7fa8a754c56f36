"""Sweeps through a known world, and news that spreads in it.

A kernel calls only functions of its own file: numba decides by a file's date whether a stored kernel is still good.
"""

import numpy as np

from course_lib.kernels.compile import compiled, inlined

ONE, NONE = np.uint32(1), np.uint32(2**32 - 1)


@inlined
def sizes(world):
    """How many states, actions and outcomes."""
    return np.uint64(world[0].shape[0]), np.uint64(world[0].shape[1]), np.uint64(world[0].shape[2])


@inlined
def flat(world):
    """The world's tables without their shape, so that one index serves them all.

    Indexes are unsigned, here and wherever it counts: numba tests any other for counting from the end.
    """
    next_state, probability, reward, terminal = world
    return next_state.reshape(-1).view(np.uint32), probability.reshape(-1), reward.reshape(-1), terminal.reshape(-1)


@inlined
def backup(tables, gamma, values, move, num_outcomes):
    """Σ_k probability (reward + gamma V(next_state)), what a move is worth; nothing follows an end."""
    next_state, probability, reward, terminal = tables
    worth = 0.0
    for outcome in range(move * num_outcomes, move * num_outcomes + num_outcomes):
        following = gamma * values[next_state[outcome]]
        worth += probability[outcome] * (reward[outcome] + (0.0 if terminal[outcome] else following))
    return worth


@compiled
def spread_news(world, gamma, values):
    """Raise `values` where every action has one outcome: a state that got better tells the states that lead to it.

    It starts from less than any state is worth, the least that a state pays at best, for ever, and goes first come,
    first served: in a maze the news runs outwards from the goal and each cell is written once. A move is numbered
    state * num_actions + action.
    """
    num_states, num_actions = len(values), np.uint32(world[0].shape[1])
    last_move_into = np.full(num_states, NONE)  # chains of the moves that lead into a state
    move_before = np.empty(num_states * num_actions, np.uint32)
    queue, queued = np.empty(num_states + 1, np.uint32), np.zeros(num_states, np.bool_)
    tail, least = first_news(world, gamma, 0.0, values, last_move_into, move_before, queue, queued)
    if least < 0.0 and gamma < 1.0:
        last_move_into[:], queued[:] = NONE, False
        tail, _ = first_news(world, gamma, least / (1.0 - gamma), values, last_move_into, move_before, queue, queued)
    reward, head = world[2].reshape(-1), 0
    patience = 8 * num_states  # enough for mazes; a world in which news runs in circles is left to the sweeps
    while head != tail and patience > 0:
        state = queue[head]
        head = (head + 1) if head < num_states else 0
        queued[state], patience = False, patience - 1
        discounted, move = gamma * values[state], last_move_into[state]
        while move != NONE:
            s = move // num_actions
            worth = reward[move] + discounted
            if worth > values[s] + 1e-15 * abs(values[s]):
                values[s] = worth
                if not queued[s]:
                    queue[tail], queued[s] = s, True
                    tail = (tail + 1) if tail < num_states else 0
            move = move_before[move]


@compiled
def first_news(world, gamma, guess, values, last_move_into, move_before, queue, queued):
    """Set all values to `guess`, queue the states whose first backup is better, and chain up the moves into each state.

    A state that no move leaves is worth what it is worth, at once. Returns how many states are queued, and the least
    that any other state pays at best.
    """
    num_states, num_actions, _ = sizes(world)
    next_state, _, reward, terminal = flat(world)
    tail, least = 0, np.inf
    for s in range(num_states):
        best, alone, pays, stuck = -np.inf, -np.inf, -np.inf, gamma < 1.0
        for move in range(s * num_actions, s * num_actions + num_actions):
            worth = reward[move]
            pays = max(pays, worth)
            if terminal[move]:
                alone = max(alone, worth)
            elif next_state[move] == s:
                alone = max(alone, worth / (1.0 - gamma))
                worth += gamma * guess
            else:
                move_before[move] = last_move_into[next_state[move]]
                last_move_into[next_state[move]] = move
                worth += gamma * guess
                stuck = False
            best = max(best, worth)
        least = least if stuck else min(least, pays)
        values[s] = alone if stuck else max(best, guess)
        if stuck or best > guess + 1e-15 * abs(guess):
            queue[tail], queued[s], tail = s, True, tail + 1
    return tail, least


@compiled
def sweep_best(world, gamma, values, policy, backwards):
    """Back up every state in place, first to last or last to first; store the best actions; the largest change."""
    num_states, num_actions, num_outcomes = sizes(world)
    tables, change = flat(world), 0.0
    for i in range(num_states):
        s = num_states - ONE - i if backwards else i
        row = s * num_actions
        best, chosen = -np.inf, row
        for move in range(row, row + num_actions):
            worth = backup(tables, gamma, values, move, num_outcomes)
            if worth > best:
                best, chosen = worth, move
        change = max(change, abs(best - values[s]))
        values[s], policy[s] = best, chosen - row
    return change


@compiled
def follow_policy(world, gamma, policy):
    """A policy's world as V(s) = gain[s] + Σ_k weight[s, k] V(next[s, k]), staying put already summed up."""
    next_state, probability, reward, terminal = world
    num_states, _, num_outcomes = next_state.shape
    gain, weight = np.zeros(num_states), np.zeros((num_states, num_outcomes))
    following = np.empty((num_states, num_outcomes), np.int32)
    for s in range(num_states):
        a, stay = policy[s], 0.0
        for k in range(num_outcomes):
            gain[s] += probability[s, a, k] * reward[s, a, k]
            following[s, k] = next_state[s, a, k]
            if not terminal[s, a, k]:
                weight[s, k] = gamma * probability[s, a, k]
                if following[s, k] == s:
                    stay += weight[s, k]
        if 0.0 < stay < 1.0:
            gain[s] /= 1.0 - stay
            for k in range(num_outcomes):
                weight[s, k] = 0.0 if following[s, k] == s else weight[s, k] / (1.0 - stay)
    return gain, weight, following


@compiled
def sweep_policy(gain, weight, following, values, backwards):
    """One sweep of a policy's own equations, in place; the largest change."""
    (num_states, num_outcomes), change = following.shape, 0.0
    for i in range(num_states):
        s = num_states - 1 - i if backwards else i
        worth = gain[s]
        for k in range(num_outcomes):
            worth += weight[s, k] * values[following[s, k]]
        change, values[s] = max(change, abs(worth - values[s])), worth
    return change


@compiled
def all_action_values(world, gamma, values, q, policy):
    """Write q[s, a] and its best actions, raise `values` to max_a q[s, a]; the largest change that made."""
    num_states, num_actions, num_outcomes = sizes(world)
    tables, q, change = flat(world), q.reshape(-1), 0.0
    for s in range(num_states):
        row = chosen = s * num_actions
        for move in range(row, row + num_actions):
            q[move] = backup(tables, gamma, values, move, num_outcomes)
            if q[move] > q[chosen]:
                chosen = move
        policy[s] = chosen - row
        change = max(change, abs(q[chosen] - values[s]))
    for s in range(num_states):
        values[s] = q[s * num_actions + np.uint64(policy[s])]
    return change
