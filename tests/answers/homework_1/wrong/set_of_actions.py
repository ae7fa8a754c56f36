"""Subtracts sets, and chooses from one."""

import numpy as np

CHECK = "goes_on_after_a_bump"
SAYS = "it wants a list of actions"


def update(q_table, state, action, reward, next_state, terminated, gamma=0.9, alpha=0.1):
    target = reward
    if not terminated:
        target += gamma * q_table[next_state].max()
    q_table[state, action] += alpha * (target - q_table[state, action])


def choose(q_table, state, actions, rng, epsilon=0.1):
    if rng.random() < epsilon:
        return actions[int(rng.random() * len(actions))]
    best = max(q_table[state, action] for action in actions)
    return next(action for action in actions if q_table[state, action] == best)


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    bumped = set()
    steps = 0
    while True:
        actions = {0, 1, 2, 3} - {a for s, a in bumped if s == state}
        action = choose(q_table, state, actions, rng)
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        update(q_table, state, action, reward, next_state, terminated)
        if info["bumped"]:
            bumped.add((state, action))
        state = next_state
        if terminated or truncated:
            break
    return steps
