"""Lesson 3's functions, with what is new added to them; the way back is a list of cells."""

import numpy as np


def update(q_table, state, action, reward, next_state, terminated, gamma=0.9, alpha=0.1):
    target = reward
    if not terminated:
        target += gamma * q_table[next_state].max()
    q_table[state, action] += alpha * (target - q_table[state, action])


def choose_among(q_table, state, actions, epsilon, rng):
    if rng.random() < epsilon:
        return int(rng.choice(actions))
    values = [q_table[state, a] for a in actions]
    best = [a for a, value in zip(actions, values) if value == max(values)]
    return int(rng.choice(best))


def play_on(maze, q_table, rng):
    bumped = set()
    steps = 0
    state, info = maze.reset()
    while True:
        left = [a for a in range(4) if (state, a) not in bumped]
        action = choose_among(q_table, state, left, 0.1, rng)
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        if info["bumped"]:
            bumped.add((state, action))
        update(q_table, state, action, reward, next_state, terminated)
        state = next_state
        if terminated or truncated:
            return steps


def cell_ahead(maze, state, action):
    row, column = maze.cell(state)
    if action == 0:
        row -= 1
    elif action == 1:
        row += 1
    elif action == 2:
        column -= 1
    else:
        column += 1
    if row < 0 or row >= maze.rows or column < 0 or column >= maze.columns:
        return None
    return maze.state(row, column)


def play_remembering(maze, q_table, rng):
    state, info = maze.reset()
    visited = {state}
    walls = set()
    path = [state]
    steps = 0
    while True:
        fresh = []
        for a in range(4):
            cell = cell_ahead(maze, state, a)
            if cell is not None and cell not in visited and cell not in walls:
                fresh.append(a)
        if fresh:
            action = choose_among(q_table, state, fresh, 0.1, rng)
        else:
            path.pop()
            back = path[-1]
            action = [a for a in range(4) if cell_ahead(maze, state, a) == back][0]
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        update(q_table, state, action, reward, next_state, terminated)
        if info["bumped"]:
            walls.add(cell_ahead(maze, state, action))
        elif next_state not in visited:
            visited.add(next_state)
            path.append(next_state)
        state = next_state
        if terminated or truncated:
            return steps


def arrives(eval_maze, q_table):
    state, info = eval_maze.reset()
    while True:
        state, reward, terminated, truncated, info = eval_maze.step(q_table[state].argmax())
        if terminated:
            return reward == 1
        if truncated:
            return False


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    episodes = 0
    while episodes < max_episodes:
        play_remembering(maze, q_table, rng)
        episodes += 1
        if arrives(eval_maze, q_table):
            break
    return q_table, episodes
