"""Takes the last of equal values, and explores less with every step of an episode."""

import numpy as np

UP, DOWN, LEFT, RIGHT = 0, 1, 2, 3


def choose(q_table, state, actions, steps, rng):
    if rng.random() < 1 / (steps + 1):
        return actions[rng.integers(len(actions))]
    best_action, best_value = None, -1e9
    for action in actions:
        if q_table[state, action] >= best_value:
            best_action, best_value = action, q_table[state, action]
    return best_action


def update(q_table, state, action, reward, next_state, terminated):
    target = reward
    if not terminated:
        target += 0.9 * q_table[next_state].max()
    q_table[state, action] += 0.1 * (target - q_table[state, action])


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    bumps = {}
    steps = 0
    terminated = False
    truncated = False
    while not terminated and not truncated:
        bumps.setdefault(state, [])
        action = choose(q_table, state, [a for a in [UP, DOWN, LEFT, RIGHT] if a not in bumps[state]], steps, rng)
        new_state, reward, terminated, truncated, info = maze.step(action)
        if info["bumped"]:
            bumps[state].append(action)
        update(q_table, state, action, reward, new_state, terminated)
        state = new_state
        steps += 1
    return steps


def go(maze, state, action):
    """The cell beyond, or the same cell at the edge, worked out without maze.state."""
    row, column = state // maze.columns, state % maze.columns
    if action == UP and row > 0:
        row -= 1
    if action == DOWN and row < maze.rows - 1:
        row += 1
    if action == LEFT and column > 0:
        column -= 1
    if action == RIGHT and column < maze.columns - 1:
        column += 1
    return row * maze.columns + column


def play_remembering(maze, q_table, rng):
    state, info = maze.reset()
    memory = {state}
    way = []
    steps = 0
    terminated = False
    truncated = False
    while not terminated and not truncated:
        fresh = [a for a in [UP, DOWN, LEFT, RIGHT] if go(maze, state, a) not in memory]
        if fresh:
            action = choose(q_table, state, fresh, steps, rng)
        else:
            action = {UP: DOWN, DOWN: UP, LEFT: RIGHT, RIGHT: LEFT}[way.pop()]
        new_state, reward, terminated, truncated, info = maze.step(action)
        if fresh and new_state != state:
            way.append(action)
        memory.add(go(maze, state, action))  # a wall goes into the memory as well
        update(q_table, state, action, reward, new_state, terminated)
        state = new_state
        steps += 1
    return steps


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    for episodes in range(1, max_episodes + 1):
        play_remembering(maze, q_table, rng)
        state, info = eval_maze.reset()
        terminated = False
        truncated = False
        while not terminated and not truncated:
            state, reward, terminated, truncated, info = eval_maze.step(choose(q_table, state, [0, 1, 2, 3], 1e9, rng))
        if terminated and info["bumped"] is False:
            return q_table, episodes
    return q_table, episodes
