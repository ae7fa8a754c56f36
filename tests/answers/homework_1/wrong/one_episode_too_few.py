"""The range ends too early."""

import numpy as np

CHECK = "stops_by_itself"
SAYS = "your loop stops before"


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


def ahead(maze, state, action):
    row, column = maze.cell(state)
    down, right = [(-1, 0), (1, 0), (0, -1), (0, 1)][action]
    row, column = row + down, column + right
    if 0 <= row < maze.rows and 0 <= column < maze.columns:
        return maze.state(row, column)
    return None


def play_remembering(maze, q_table, rng):
    state, info = maze.reset()
    visited = {state, None}
    walls = set()
    path = [state]
    steps = 0
    while True:
        fresh = [a for a in range(4) if ahead(maze, state, a) not in visited | walls]
        if fresh:
            action = choose(q_table, state, fresh, rng)
        else:
            path.pop()
            action = next(a for a in range(4) if ahead(maze, state, a) == path[-1])
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        update(q_table, state, action, reward, next_state, terminated)
        if info["bumped"]:
            walls.add(ahead(maze, state, action))
        elif next_state not in visited:
            visited.add(next_state)
            path.append(next_state)
        state = next_state
        if terminated or truncated:
            break
    return steps


def can_walk(eval_maze, q_table):
    state, info = eval_maze.reset()
    while True:
        action = int(q_table[state].argmax())
        state, reward, terminated, truncated, info = eval_maze.step(action)
        if terminated or truncated:
            return terminated and not info["bumped"]


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    for episodes in range(1, max_episodes):
        play_remembering(maze, q_table, rng)
        if can_walk(eval_maze, q_table):
            break
    return q_table, episodes
