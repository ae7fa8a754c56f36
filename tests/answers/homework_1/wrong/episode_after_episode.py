"""Plays for ever, in another loop around the right one."""

import numpy as np

CHECK = "goes_on_after_a_bump"
SAYS = "plays episode after episode"


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
    steps = 0
    while True:
        state, info = maze.reset()
        over = False
        while not over:
            action = choose(q_table, state, [0, 1, 2, 3], rng)
            next_state, reward, terminated, truncated, info = maze.step(action)
            steps += 1
            update(q_table, state, action, reward, next_state, terminated)
            state = next_state
            over = terminated or truncated
    return steps
