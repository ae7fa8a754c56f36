"""The loop of Q-learning, in the forms that lessons, markets and studies need.

A kernel calls only functions of its own file: numba decides by a file's date whether a stored kernel is still good.
Indexes are unsigned where it counts: numba tests any other for counting from the end.
"""

import numpy as np

from course_lib.kernels.compile import compiled, inlined

ZERO, ONE = np.uint32(0), np.uint32(1)


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
    num_actions, num_outcomes = np.uint64(world[0].shape[1]), np.uint64(world[0].shape[2])
    next_states, probability = world[0].reshape(-1).view(np.uint32), world[1].reshape(-1)
    rewards, terminal = world[2].reshape(-1), world[3].reshape(-1)
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
def q_learning_side_by_side(
    q_tables, visits, world, start, draw_always, generator, world_generator,
    gamma, alpha, alpha_power, epsilon, epsilon_decay, max_steps, returns, lengths, terminated,
):  # fmt: skip
    """`q_learning` of E agents, one after the other, without coming back to Python between them.

    generator = (the generator that all draw from, the memory it keeps its state in, uint64[4], and each agent's state,
    uint64[E, 4], which is put there before its turn and comes back after it); world_generator alike.
    """
    rng, state, states = generator
    world_rng, world_state, world_states = world_generator
    for i in range(len(q_tables)):
        state[:], world_state[:] = states[i], world_states[i]
        q_learning(
            q_tables[i], visits[i], world, start, draw_always, rng, world_rng,
            gamma, alpha, alpha_power, epsilon, epsilon_decay, max_steps, 2**62, np.zeros(4),
            returns[i], lengths[i], terminated[i],
        )  # fmt: skip
        states[i], world_states[i] = state, world_state


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
