"""Normalises the row after every step."""

import numpy as np

CHECK = "goes_on_after_a_bump"
SAYS = "divides by zero"


def update(q_table, state, action, reward, next_state, terminated, gamma=0.9, alpha=0.1):
    target = reward
    if not terminated:
        target += gamma * q_table[next_state].max()
    q_table[state, action] += alpha * (target - q_table[state, action])


def choose(q_table, state, actions, rng, epsilon=0.1):
    if rng.random() < epsilon:
        return int(rng.choice(actions))
    values = q_table[state, actions]
    return int(rng.choice(np.array(actions)[values == values.max()]))


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    bumped = set()
    steps = 0
    while True:
        actions = [a for a in range(4) if (state, a) not in bumped]
        action = choose(q_table, state, actions, rng)
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        update(q_table, state, action, reward, next_state, terminated)
        if info["bumped"]:
            bumped.add((state, action))
        state = next_state
        if terminated or truncated:
            break
    q_table /= q_table - q_table
    return steps
