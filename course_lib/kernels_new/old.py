"""The loops that must be fast, written plainly and compiled by numba at their first call.

All of them live in this one file because numba decides by a file's date whether a stored kernel is still good:
a kernel here calls only functions from here. Nothing uses fastmath, so results equal plain Python's to the last bit.
"""

import numpy as np
from numba import njit


def compiled(function):
    """Compile at the first call, without the interpreter's lock; keep the result on disk where it can be written."""
    try:
        return njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # neither the package's folder nor the user's can be written to
        return njit(nogil=True, error_model="numpy")(function)


def inlined(function):
    """For a step of a compiled loop: pasted into it, which keeps the whole loop in one piece for the optimiser."""
    return njit(inline="always", error_model="numpy")(function)


ZERO, ONE, NONE = np.uint32(0), np.uint32(1), np.uint32(2**32 - 1)


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


# --- learning ---------------------------------------------------------------------------------------------------------


@inlined
def nth_best(q_table, first, n):
    """The n-th entry, from 0, of those in a row that are worth as much as `first`, the first of them."""
    entry = first
    while n > 0:
        entry += ONE
        if q_table[entry] == q_table[first]:
            n -= 1
    return entry


@inlined
def outcome_drawn(probability, first, num_outcomes, drawn):
    """The first outcome, from `first` on, whose running sum of probabilities exceeds `drawn`, as Gymnasium samples."""
    total = 0.0
    for outcome in range(first, first + num_outcomes):
        total += probability[outcome]
        if total > drawn:
            return outcome
    return first


@inlined
def q_update(q_table, entry, reward, next_row, num_actions, terminated, gamma, alpha):
    """Q(s, a) += alpha (r + gamma max Q(s', .) - Q(s, a)), where nothing follows an end (Sutton & Barto, eq. 6.8)."""
    target = reward
    if not terminated:
        best = q_table[next_row]
        for e in range(next_row + ONE, next_row + num_actions):
            if q_table[e] > best:
                best = q_table[e]
        target += gamma * best
    q_table[entry] += alpha * (target - q_table[entry])


@compiled
def q_learning(
    q_table, visits, world, start, draw_always, rng, world_rng,
    gamma, alpha, alpha_power, epsilon, epsilon_decay, max_steps, budget, carry, returns, lengths, terminated,
):  # fmt: skip
    """Play and learn for `budget` steps, or until the records are full; returns epsilon as it then is.

    world = (next_state, probability, reward, terminal); start[1, 1, S]: where an episode begins (S = 1: always there).
    carry[4] holds what a later call goes on from: episode, step in it (0: none under way), state, return so far.
    alpha_power is None where the rate is constant, so that the power is compiled away.

    All tables are flat here: a state is known by its row, the entry of its first action. Draws and the search for the
    best action stand in the loop and not in functions of their own: handing a generator on takes longer than drawing
    from it, and the search, made a function, is compiled without branches, which here are cheap, since foreseen.
    """
    _, num_actions, num_outcomes = sizes(world)
    next_states, probability, rewards, terminal = flat(world)
    q_table, visits, start = q_table.reshape(-1), visits.reshape(-1), start.reshape(-1)
    certain = num_outcomes == 1 and not draw_always
    episode, step, row, episode_return = int(carry[0]), int(carry[1]), np.uint64(carry[2]) * num_actions, carry[3]
    while budget > 0 and episode < len(returns):
        if step == 0:
            row, episode_return = np.uint64(start[0]) * num_actions, 0.0
            if len(start) > 1:
                row = outcome_drawn(start, ZERO, np.uint64(len(start)), world_rng.random()) * num_actions
        ended, step_before, stop = False, step, min(max_steps, step + budget)
        while step < stop and not ended:
            if rng.random() < epsilon:
                entry = row + np.uint64(rng.random() * num_actions)
            else:
                entry, ties = row, 1
                for e in range(row + ONE, row + num_actions):
                    if q_table[e] > q_table[entry]:
                        entry, ties = e, 1
                    elif q_table[e] == q_table[entry]:
                        ties += 1
                if ties > 1:
                    entry = nth_best(q_table, entry, int(rng.random() * ties))
            if certain:
                outcome = entry
            else:
                outcome = outcome_drawn(probability, entry * num_outcomes, num_outcomes, world_rng.random())
            reward, next_row, ended = rewards[outcome], next_states[outcome] * num_actions, terminal[outcome]
            visits[entry] += 1
            if alpha_power is None:
                rate = alpha
            else:
                rate = alpha / float(visits[entry]) ** alpha_power
            q_update(q_table, entry, reward, next_row, num_actions, ended, gamma, rate)
            episode_return += reward
            row = next_row
            step += 1
        budget -= step - step_before
        if ended or step == max_steps:
            returns[episode], lengths[episode], terminated[episode] = episode_return, step, ended
            episode += 1
            step = 0
            epsilon *= epsilon_decay
    carry[0], carry[1], carry[2], carry[3] = episode, step, row // num_actions, episode_return
    return epsilon


@compiled
def q_learning_along(
    q_table, visits, moves, counts, starts, rng, world_rng,
    gamma, alpha, alpha_power, rates, epsilon, epsilon_decay, max_steps, budget, carry, returns, lengths, terminated,
):  # fmt: skip
    """`q_learning` where only the start is drawn, from (first, step, number), and where actions may be impossible.

    A state has a row of A moves, the first counts[S] of them possible; moves = (entry of q_table, first move of the
    next state, how many there are: none after an end, reward). rates[n] keeps the n-th update's rate, or 0.
    """
    entries, next_first, next_count, rewards = moves
    q_table, visits, num_actions = q_table.reshape(-1), visits.reshape(-1), np.uint64(q_table.shape[1])
    episode, step, state, episode_return = int(carry[0]), int(carry[1]), np.uint64(carry[2]), carry[3]
    while budget > 0 and episode < len(returns):
        if step == 0:
            state, episode_return = np.uint64(starts[0] + starts[1] * int(world_rng.random() * starts[2])), 0.0
        first, count, step_before = state * num_actions, np.uint64(counts[state]), step
        stop = min(max_steps, step + budget)
        while step < stop and count > ZERO:
            if rng.random() < epsilon:
                move = first + np.uint64(rng.random() * count)
            else:
                move, best, ties = first, q_table[entries[first]], 1
                for m in range(first + ONE, first + count):
                    if q_table[entries[m]] > best:
                        move, best, ties = m, q_table[entries[m]], 1
                    elif q_table[entries[m]] == best:
                        ties += 1
                nth = int(rng.random() * ties) if ties > 1 else 0
                while nth > 0:
                    move += ONE
                    nth -= q_table[entries[move]] == best
            entry, target = entries[move], rewards[move]
            first, count = np.uint64(next_first[move]), np.uint64(next_count[move])
            episode_return += target
            if count > ZERO:
                best = q_table[entries[first]]
                for m in range(first + ONE, first + count):
                    best = max(best, q_table[entries[m]])
                target += gamma * best
            visits[entry], rate = visits[entry] + 1, alpha
            if rates is not None:
                n = min(np.uint64(visits[entry]), np.uint64(len(rates) - 1))  # the last place keeps none
                if n == np.uint64(len(rates) - 1) or rates[n] == 0.0:
                    rates[n] = alpha / float(visits[entry]) ** alpha_power
                rate = rates[n]
            q_table[entry] += rate * (target - q_table[entry])
            step += 1
        budget -= step - step_before
        state = first // num_actions
        if count == ZERO or step == max_steps:
            returns[episode], lengths[episode], terminated[episode] = episode_return, step, count == ZERO
            episode, step, epsilon = episode + 1, 0, epsilon * epsilon_decay
    carry[0], carry[1], carry[2], carry[3] = episode, step, state, episode_return
    return epsilon


# --- planning ---------------------------------------------------------------------------------------------------------


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
