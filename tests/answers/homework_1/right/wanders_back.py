"""In a dead end it wanders at random until something fresh is beside it; and it keeps the step limit of lesson 3."""

import random

import numpy as np

from course_lib import Action


def choose(q_table, state, epsilon, rng, allowed):
    if rng.random() < epsilon:
        return Action(rng.choice(allowed))
    top = max(q_table[state][a] for a in allowed)
    return Action(random.choice([a for a in allowed if q_table[state][a] == top]))


def update(q_table, state, action, reward, next_state, terminated, gamma, alpha):
    target = reward
    if not terminated:
        target += gamma * q_table[next_state].max()
    q_table[state, action] += alpha * (target - q_table[state, action])


def play_on(maze, q_table, rng, epsilon=0.1, gamma=0.9, alpha=0.1, max_steps=1000):
    state, _ = maze.reset()
    walls = []
    for step in range(max_steps):
        allowed = [a for a in Action if (state, a) not in walls]
        action = choose(q_table, state, epsilon, rng, allowed)
        next_state, reward, terminated, truncated, info = maze.step(action)
        update(q_table, state, action, reward, next_state, terminated, gamma, alpha)
        if info["bumped"]:
            walls.append((state, action))
        state = next_state
        if terminated or truncated:
            break
    return step + 1


def play_remembering(maze, q_table, rng, epsilon=0.1, gamma=0.9, alpha=0.1, max_steps=1000):
    state, _ = maze.reset()
    walls = []
    visited = [state]
    for step in range(max_steps):
        fresh = []
        row, column = maze.cell(state)
        if row > 0 and maze.state(row - 1, column) not in visited:
            fresh.append(Action.UP)
        if row < maze.rows - 1 and maze.state(row + 1, column) not in visited:
            fresh.append(Action.DOWN)
        if column > 0 and maze.state(row, column - 1) not in visited:
            fresh.append(Action.LEFT)
        if column < maze.columns - 1 and maze.state(row, column + 1) not in visited:
            fresh.append(Action.RIGHT)
        fresh = [a for a in fresh if (state, a) not in walls]
        if fresh:
            action = choose(q_table, state, epsilon, rng, fresh)
        else:
            action = Action(rng.integers(4))
        next_state, reward, terminated, truncated, info = maze.step(action)
        update(q_table, state, action, reward, next_state, terminated, gamma, alpha)
        if info["bumped"]:
            walls.append((state, action))
        visited.append(next_state)
        state = next_state
        if terminated or truncated:
            break
    return step + 1


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    for episode in range(max_episodes):
        play_remembering(maze, q_table, rng)
        state, _ = eval_maze.reset()
        for step in range(1000):
            state, reward, terminated, truncated, info = eval_maze.step(Action(q_table[state].argmax()))
            if terminated or truncated:
                break
        if reward == 1:
            return q_table, episode + 1
    return q_table, max_episodes
