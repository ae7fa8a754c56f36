"""The target takes the action that the mouse takes next."""

import numpy as np

CHECK = "goes_on_after_a_bump"
SAYS = "looks at the action that the mouse took next"


def choose(q_table, state, actions, rng, epsilon=0.1):
    if rng.random() < epsilon:
        return int(rng.choice(actions))
    values = q_table[state, actions]
    return int(rng.choice(np.array(actions)[values == values.max()]))


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    bumped = set()
    steps = 0
    action = choose(q_table, state, [0, 1, 2, 3], rng)
    while True:
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        if info["bumped"]:
            bumped.add((state, action))
        next_action = choose(q_table, next_state, [a for a in range(4) if (next_state, a) not in bumped], rng)
        target = reward
        if not terminated:
            target += 0.9 * q_table[next_state, next_action]
        q_table[state, action] += 0.1 * (target - q_table[state, action])
        if terminated or truncated:
            return steps
        state, action = next_state, next_action
