"""Masks instead of sets: every cell's four neighbours are worked out once, and -1 stands for the edge."""

import numpy as np


def neighbours(maze):
    cells = np.arange(maze.rows * maze.columns).reshape(maze.rows, maze.columns)
    around = np.pad(cells, 1, constant_values=-1)
    return np.stack([around[:-2, 1:-1], around[2:, 1:-1], around[1:-1, :-2], around[1:-1, 2:]], axis=-1).reshape(-1, 4)


def pick(values, allowed, rng):
    if rng.random() < 0.1:
        return rng.choice(np.flatnonzero(allowed))
    masked = np.where(allowed, values, -np.inf)
    return rng.choice(np.flatnonzero(masked == masked.max()))


def learn(q, s, a, r, s2, done):
    q[s, a] += 0.1 * (r + 0.9 * q[s2].max() * (not done) - q[s, a])


def play_on(maze, q_table, rng):
    allowed = np.ones(q_table.shape, bool)
    s, _ = maze.reset()
    steps, over = np.int64(0), False
    while not over:
        a = pick(q_table[s], allowed[s], rng)
        s2, r, terminated, truncated, info = maze.step(a)
        allowed[s, a] &= not info["bumped"]
        learn(q_table, s, a, r, s2, terminated)
        s, over = s2, terminated or truncated
        steps += 1
    return steps


def play_remembering(maze, q_table, rng):
    ahead = neighbours(maze)
    visited = np.zeros(len(ahead) + 1, bool)
    visited[-1] = True  # index -1: the edge
    wall = np.zeros(len(ahead) + 1, bool)
    came_from = np.full(len(ahead), -1)
    s, _ = maze.reset()
    visited[s] = True
    steps, over = 0, False
    while not over:
        fresh = ~visited[ahead[s]] & ~wall[ahead[s]]
        a = pick(q_table[s], fresh, rng) if fresh.any() else np.flatnonzero(ahead[s] == came_from[s])[0]
        s2, r, terminated, truncated, info = maze.step(a)
        learn(q_table, s, a, r, s2, terminated)
        if info["bumped"]:
            wall[ahead[s, a]] = True
        elif not visited[s2]:
            came_from[s2] = s
            visited[s2] = True
        s, over = s2, terminated or truncated
        steps += 1
    return np.int32(steps)


def walk(maze, q_table):
    policy = q_table.argmax(1)
    s, info = maze.reset()
    terminated = truncated = False
    while not (terminated | truncated):
        s, _, terminated, truncated, info = maze.step(policy[s])
    return terminated & (not info["bumped"])


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    for episodes in np.arange(1, max_episodes + 1):
        play_remembering(maze, q_table, rng)
        if walk(eval_maze, q_table):
            break
    return [q_table, episodes]
