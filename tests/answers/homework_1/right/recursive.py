"""A search by recursion: each cell explores what is fresh around it, then steps back to the one that called it.

The recursion is as deep as the way from the start is long, never as deep as the episode: the longest way has fewer
cells than the maze. A game of task 1 could be a thousand steps deep, so there is a loop there.
"""

import numpy as np


def learn(q_table, state, action, reward, next_state, terminated):
    best_next = 0.0 if terminated else max(q_table[next_state])
    q_table[state][action] += 0.1 * (reward + 0.9 * best_next - q_table[state][action])


def pick(q_table, state, actions, rng):
    actions = rng.permutation(actions)
    if rng.random() < 0.1:
        return int(actions[0])
    return int(actions[np.argmax(q_table[state, actions])])


def play_on(maze, q_table, rng):
    state, _ = maze.reset()
    tried = {}
    steps = 0
    over = False
    while not over:
        left = sorted({0, 1, 2, 3} - tried.get(state, set()))
        action = pick(q_table, state, left, rng)
        next_state, reward, terminated, truncated, info = maze.step(action)
        if info["bumped"]:
            tried.setdefault(state, set()).add(action)
        learn(q_table, state, action, reward, next_state, terminated)
        state = next_state
        steps += 1
        over = terminated or truncated
    return steps


def play_remembering(maze, q_table, rng):
    closed = set()
    steps = 0
    back_of = {0: 1, 1: 0, 2: 3, 3: 2}

    def inside(state):
        row, column = maze.cell(state)
        ways = [(0, row - 1, column), (1, row + 1, column), (2, row, column - 1), (3, row, column + 1)]
        return {a: (r, c) for a, r, c in ways if 0 <= r < maze.rows and 0 <= c < maze.columns}

    def take(state, action):
        nonlocal steps
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        learn(q_table, state, action, reward, next_state, terminated)
        return next_state, terminated or truncated

    def explore(state):
        """Whether the episode is over."""
        closed.add(maze.cell(state))
        ways = inside(state)
        while fresh := [a for a, cell in ways.items() if cell not in closed]:
            action = pick(q_table, state, fresh, rng)
            next_state, over = take(state, action)
            if over:
                return True
            if next_state == state:
                closed.add(ways[action])
                continue
            if explore(next_state):
                return True
            _, over = take(next_state, back_of[action])
            if over:
                return True
        return False

    start, _ = maze.reset()
    explore(start)
    return steps


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))

    def arrived(state):
        state, reward, terminated, truncated, _ = eval_maze.step(int(q_table[state].argmax()))
        return reward == 1 if terminated or truncated else arrived(state)

    def go_on(number):
        play_remembering(maze, q_table, rng)
        state, _ = eval_maze.reset()
        return number if number == max_episodes or arrived(state) else go_on(number + 1)

    return q_table, go_on(1)
