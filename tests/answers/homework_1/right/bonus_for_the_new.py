"""No dice at all: a bonus for actions that were seldom tried in this episode does the exploring (as UCB does)."""

import math

import numpy as np


def with_bonus(q_table, tried, state, actions):
    total = 1 + sum(tried[state])

    def score(action):
        return q_table[state, action] + 0.5 * math.sqrt(math.log(total) / (1 + tried[state][action]))

    return max(actions, key=score)


def learn(q_table, state, action, reward, next_state, terminated):
    q_table[state, action] *= 0.9
    q_table[state, action] += 0.1 * reward
    if not terminated:
        # the old value of this very entry may be the best one of next_state, if the mouse stayed where it was
        row = q_table[next_state].copy()
        if next_state == state:
            row[action] = (q_table[state, action] - 0.1 * reward) / 0.9
        q_table[state, action] += 0.1 * 0.9 * row.max()


def play_on(maze, q_table, rng):
    tried = [[0] * 4 for _ in q_table]
    walls = set()
    state, _ = maze.reset()
    steps = 0
    while True:
        action = with_bonus(q_table, tried, state, [a for a in rng.permutation(4).tolist() if (state, a) not in walls])
        tried[state][action] += 1
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        learn(q_table, state, action, reward, next_state, terminated)
        if info["bumped"]:
            walls.add((state, action))
        if terminated or truncated:
            return steps
        state = next_state


def play_remembering(maze, q_table, rng):
    tried = [[0] * 4 for _ in q_table]
    state, _ = maze.reset()
    visited, walls = {maze.cell(state)}, set()
    steps = 0
    while True:
        row, column = maze.cell(state)
        around = {0: (row - 1, column), 1: (row + 1, column), 2: (row, column - 1), 3: (row, column + 1)}
        around = {
            a: (r, c)
            for a, (r, c) in around.items()
            if 0 <= r <= maze.rows - 1 and 0 <= c <= maze.columns - 1 and (r, c) not in walls
        }
        fresh = [a for a, cell in around.items() if cell not in visited]
        if fresh:
            action = with_bonus(q_table, tried, state, fresh)
        else:
            action = min(around, key=lambda a: tried[state][a])
        tried[state][action] += 1
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        learn(q_table, state, action, reward, next_state, terminated)
        if info["bumped"]:
            walls.add(around[action])
        else:
            visited.add(maze.cell(next_state))
        if terminated or truncated:
            return steps
        state = next_state


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    episodes = 0
    can_walk = False
    while not can_walk and episodes < max_episodes:
        play_on(maze, q_table, rng)
        episodes += 1
        state, info = eval_maze.reset()
        done = False
        while not done:
            state, reward, terminated, truncated, info = eval_maze.step(np.argmax(q_table[state]))
            done = terminated or truncated
        can_walk = terminated and reward > 0
    return q_table, episodes
