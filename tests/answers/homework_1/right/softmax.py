"""Explores by chances that grow with the values (softmax) instead of by epsilon."""

import numpy as np


def draw(values, actions, rng, heat=0.05):
    weights = np.exp((values[actions] - values[actions].max()) / heat)
    return int(rng.choice(actions, p=weights / weights.sum()))


def learn(q_table, state, action, reward, next_state, terminated):
    target = reward if terminated else reward + 0.9 * np.max(q_table[next_state])
    q_table[state, action] = q_table[state, action] + 0.1 * (target - q_table[state, action])


def play_on(maze, q_table, rng):
    state, _ = maze.reset()
    possible = {}
    for steps in range(1, 10**9):
        actions = possible.setdefault(state, [0, 1, 2, 3])
        action = draw(q_table[state], actions, rng)
        next_state, reward, terminated, truncated, info = maze.step(action)
        learn(q_table, state, action, reward, next_state, terminated)
        if info["bumped"]:
            actions.remove(action)
        state = next_state
        if terminated or truncated:
            break
    return steps


def ways(maze, state):
    row, column = maze.cell(state)
    result = {}
    if row > 0:
        result[0] = maze.state(row - 1, column)
    if row < maze.rows - 1:
        result[1] = maze.state(row + 1, column)
    if column > 0:
        result[2] = maze.state(row, column - 1)
    if column < maze.columns - 1:
        result[3] = maze.state(row, column + 1)
    return result


def play_remembering(maze, q_table, rng):
    state, _ = maze.reset()
    visited, walls, steps = [state], [], 0
    while True:
        around = ways(maze, state)
        fresh = [a for a in around if around[a] not in visited + walls]
        known = [a for a in around if around[a] in visited]
        if fresh:
            action = draw(q_table[state], fresh, rng)
        else:  # back at random, but rather to where it was not lately
            ages = [len(visited) - visited.index(around[a]) for a in known]
            action = known[ages.index(max(ages))] if rng.random() < 0.5 else int(rng.choice(known))
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        learn(q_table, state, action, reward, next_state, terminated)
        (walls if info["bumped"] else visited).append(around[action])
        state = next_state
        if terminated or truncated:
            return steps


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    for episode in range(max_episodes):
        play_remembering(maze, q_table, rng)
        state, info = eval_maze.reset()
        for _ in range(maze.rows * maze.columns):  # no shortest way is longer
            state, _, terminated, truncated, info = eval_maze.step(int(np.argmax(q_table[state])))
            if terminated or truncated:
                break
        if terminated and not info["bumped"]:
            return q_table, episode + 1
    return q_table, max_episodes
