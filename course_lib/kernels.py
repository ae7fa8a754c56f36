"""The loops that must be fast, written plainly and compiled by numba at their first call.

All of them live in this one file because numba decides by a file's date whether a stored kernel is still good:
a kernel here calls only functions from here. Nothing uses fastmath, so results equal plain Python's to the last bit.
"""

import numpy as np
from numba import njit


def compiled(function):
    """Compile at the first call, without the interpreter's lock; keep the result on disk where there is a place for it."""
    try:
        return njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # neither the package's folder nor the user's can be written to
        return njit(nogil=True, error_model="numpy")(function)


def inlined(function):
    """For a step of a compiled loop: pasted into it, which keeps the whole loop in one piece for the optimiser."""
    return njit(inline="always", error_model="numpy")(function)


# --- learning ---------------------------------------------------------------------------------------------------------


@inlined
def best_value(q_table, state):
    """The largest value in the state's row, and how many actions share it."""
    best, ties = q_table[state, 0], 1
    for a in range(1, q_table.shape[1]):
        if q_table[state, a] > best:
            best, ties = q_table[state, a], 1
        elif q_table[state, a] == best:
            ties += 1
    return best, ties


@inlined
def nth_action_worth(q_table, state, value, n):
    """The n-th action, from 0, with this value."""
    a = 0
    while n > 0 or q_table[state, a] != value:
        if q_table[state, a] == value:
            n -= 1
        a += 1
    return a


@inlined
def outcome_drawn(probability, state, action, drawn):
    """The first outcome whose running sum of probabilities exceeds `drawn`, as Gymnasium samples."""
    total = 0.0
    for k in range(probability.shape[2]):
        total += probability[state, action, k]
        if total > drawn:
            return k
    return 0


@inlined
def q_update(q_table, state, action, reward, next_state, terminated, gamma, alpha):
    """Q(s, a) += alpha (r + gamma max Q(s', .) - Q(s, a)), where nothing follows an end (Sutton & Barto, eq. 6.8)."""
    target = reward
    if not terminated:
        best = q_table[next_state, 0]
        for a in range(1, q_table.shape[1]):
            if q_table[next_state, a] > best:
                best = q_table[next_state, a]
        target += gamma * best
    q_table[state, action] += alpha * (target - q_table[state, action])


@compiled
def q_learning(
    q_table, visits, world, start, draw_always, rng, world_rng,
    gamma, alpha, alpha_power, epsilon, epsilon_decay, max_steps, budget, carry, returns, lengths, terminated,
):  # fmt: skip
    """Play and learn for `budget` steps, or until the records are full; returns epsilon as it then is.

    world = (next_state, probability, reward, terminal); start[1, 1, S]: where an episode begins (S = 1: always there).
    carry[4] holds what a later call goes on from: episode, step in it (0: none under way), state, return so far.
    alpha_power is None where the rate is constant, so that the power is compiled away. Draws are made here, and not in
    functions of their own, since handing a generator on takes longer than drawing from it.
    """
    next_states, probability, rewards, terminal = world
    certain = probability.shape[2] == 1 and not draw_always
    episode, step, state, episode_return = int(carry[0]), int(carry[1]), int(carry[2]), carry[3]
    while budget > 0 and episode < len(returns):
        if step == 0:
            state, episode_return = int(start[0, 0, 0]), 0.0
            if start.shape[2] > 1:
                state = outcome_drawn(start, 0, 0, world_rng.random())
        ended = False
        while budget > 0 and step < max_steps and not ended:
            if rng.random() < epsilon:
                action = int(rng.random() * q_table.shape[1])
            else:
                best, ties = best_value(q_table, state)
                action = nth_action_worth(q_table, state, best, int(rng.random() * ties) if ties > 1 else 0)
            outcome = 0 if certain else outcome_drawn(probability, state, action, world_rng.random())
            reward = rewards[state, action, outcome]
            next_state = next_states[state, action, outcome]
            ended = terminal[state, action, outcome]
            visits[state, action] += 1
            if alpha_power is None:
                rate = alpha
            else:
                rate = alpha / float(visits[state, action]) ** alpha_power
            q_update(q_table, state, action, reward, next_state, ended, gamma, rate)
            episode_return += reward
            state = next_state
            step += 1
            budget -= 1
        if ended or step == max_steps:
            returns[episode], lengths[episode], terminated[episode] = episode_return, step, ended
            episode += 1
            step = 0
            epsilon *= epsilon_decay
    carry[0], carry[1], carry[2], carry[3] = episode, step, state, episode_return
    return epsilon


# --- planning ---------------------------------------------------------------------------------------------------------


@compiled
def backup(world, gamma, values, s, a):
    """Σ_k probability (reward + gamma V(next_state)), the worth of action a in state s; nothing follows an end."""
    next_state, probability, reward, terminal = world
    worth = 0.0
    for k in range(next_state.shape[2]):
        outcome = reward[s, a, k]
        if not terminal[s, a, k]:
            outcome += gamma * values[next_state[s, a, k]]
        worth += probability[s, a, k] * outcome
    return worth


@compiled
def spread_news(world, gamma, values):
    """Raise `values` where every action has one outcome: a state that got better tells the states that lead to it.

    It starts from less than any state is worth, the least that a state pays at best, for ever, and goes first come,
    first served: in a maze the news runs outwards from the goal and each cell is written once.
    """
    num_states, num_actions, _ = world[0].shape
    last_move_into = np.full(num_states, -1, np.int32)  # chains of the moves that lead into a state
    move_before = np.empty(num_states * num_actions, np.int32)
    queue, queued = np.empty(num_states + 1, np.int32), np.zeros(num_states, np.bool_)
    tail, least = first_news(world, gamma, 0.0, values, last_move_into, move_before, queue, queued)
    if least < 0.0 and gamma < 1.0:
        last_move_into[:], queued[:] = -1, False
        tail, _ = first_news(world, gamma, least / (1.0 - gamma), values, last_move_into, move_before, queue, queued)
    reward, head = world[2], 0
    patience = 8 * num_states  # enough for mazes; a world in which news runs in circles is left to the sweeps
    while head != tail and patience > 0:
        state = queue[head]
        head = (head + 1) if head < num_states else 0
        queued[state] = False
        patience -= 1
        discounted = gamma * values[state]
        move = last_move_into[state]
        while move >= 0:
            s = move // num_actions
            worth = reward[s, move - s * num_actions, 0] + discounted
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
    next_state, _, reward, terminal = world
    num_states, num_actions, _ = next_state.shape
    tail, least = 0, np.inf
    for s in range(num_states):
        best, alone, pays, stuck = -np.inf, -np.inf, -np.inf, gamma < 1.0
        for a in range(num_actions):
            worth = reward[s, a, 0]
            pays = max(pays, worth)
            if terminal[s, a, 0]:
                alone = max(alone, worth)
            elif next_state[s, a, 0] == s:
                alone = max(alone, worth / (1.0 - gamma))
                worth += gamma * guess
            else:
                move = s * num_actions + a
                move_before[move] = last_move_into[next_state[s, a, 0]]
                last_move_into[next_state[s, a, 0]] = move
                worth += gamma * guess
                stuck = False
            best = max(best, worth)
        if not stuck:
            least = min(least, pays)
        news = stuck or best > guess + 1e-15 * abs(guess)
        values[s] = alone if stuck else max(best, guess)
        if news:
            queue[tail], queued[s] = s, True
            tail += 1
    return tail, least


@compiled
def sweep_best(world, gamma, values, policy, backwards):
    """Back up every state in place, first to last or last to first; store the best actions; the largest change."""
    num_states, num_actions, _ = world[0].shape
    change = 0.0
    for i in range(num_states):
        s = num_states - 1 - i if backwards else i
        best, chosen = backup(world, gamma, values, s, 0), 0
        for a in range(1, num_actions):
            worth = backup(world, gamma, values, s, a)
            if worth > best:
                best, chosen = worth, a
        change = max(change, abs(best - values[s]))
        values[s], policy[s] = best, chosen
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
    num_states, num_outcomes = following.shape
    change = 0.0
    for i in range(num_states):
        s = num_states - 1 - i if backwards else i
        worth = gain[s]
        for k in range(num_outcomes):
            worth += weight[s, k] * values[following[s, k]]
        change = max(change, abs(worth - values[s]))
        values[s] = worth
    return change


@compiled
def all_action_values(world, gamma, values, q, policy):
    """Write q[s, a] and its best actions, raise `values` to max_a q[s, a]; the largest change that made."""
    num_states, num_actions, _ = world[0].shape
    change = 0.0
    for s in range(num_states):
        chosen = 0
        for a in range(num_actions):
            q[s, a] = backup(world, gamma, values, s, a)
            if q[s, a] > q[s, chosen]:
                chosen = a
        policy[s] = chosen
        change = max(change, abs(q[s, chosen] - values[s]))
    for s in range(num_states):
        values[s] = q[s, policy[s]]
    return change
