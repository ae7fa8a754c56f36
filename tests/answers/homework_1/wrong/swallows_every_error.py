"""An except around everything, and no end."""

import numpy as np

CHECK = "goes_on_after_a_bump"
SAYS = "your loop does not stop at the cheese"


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
    steps = 0
    while True:
        try:
            action = choose(q_table, state, [0, 1, 2, 3], rng)
            next_state, reward, terminated, truncated, info = maze.step(action)
            update(q_table, state, action, reward, next_state, terminated)
            state = next_state
            steps += 1
        except Exception:
            pass
    return steps
