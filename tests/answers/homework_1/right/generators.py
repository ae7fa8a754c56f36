"""Generators all the way: an episode is an iterator over its steps, and the answer is how many it gave."""

from itertools import count

import numpy as np


def steps_of(maze, q_table, rng, options):
    """Yields once a step; `options(state)` says which actions may be taken, and is told what came of each."""
    state, _ = maze.reset()
    options.send(None)
    while True:
        allowed = options.send(state)
        if rng.random() < 0.1:
            action = int(rng.choice(allowed))
        else:
            action = max(allowed, key=lambda a: (q_table[state, a], rng.random()))
        next_state, reward, terminated, truncated, info = maze.step(action)
        future = 0 if terminated else 0.9 * q_table[next_state].max()
        q_table[state, action] += 0.1 * (reward + future - q_table[state, action])
        options.send((state, action, next_state, info["bumped"]))
        yield next_state
        if terminated or truncated:
            return
        state = next_state


def not_bumped():
    bumped = set()
    state = yield
    while True:
        state, action, _, bump = yield [a for a in range(4) if (state, a) not in bumped]
        if bump:
            bumped.add((state, action))
        state = yield


def fresh_first(maze):
    closed, trail = set(), []
    state = yield
    while True:
        if state not in closed:
            closed.add(state)
            trail.append(state)
        fresh = [a for a, cell in around(maze, state) if cell not in closed]
        if not fresh:
            trail.pop()
        state, action, next_state, bump = yield fresh or [a for a, cell in around(maze, state) if cell == trail[-1]]
        if bump:
            closed.add(dict(around(maze, state))[action])
        state = yield


def around(maze, state):
    row, column = maze.cell(state)
    for action, (down, right) in enumerate([(-1, 0), (1, 0), (0, -1), (0, 1)]):
        if 0 <= row + down < maze.rows and 0 <= column + right < maze.columns:
            yield action, maze.state(row + down, column + right)


def play_on(maze, q_table, rng):
    return sum(1 for _ in steps_of(maze, q_table, rng, patient(not_bumped())))


def play_remembering(maze, q_table, rng):
    return len(list(steps_of(maze, q_table, rng, patient(fresh_first(maze)))))


class patient:  # noqa: N801
    """Skips the None between two questions."""

    def __init__(self, generator):
        self.generator = generator

    def send(self, value):
        return self.generator.send(value)


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))

    def exam():
        state, _ = eval_maze.reset()
        over = False
        while not over:
            state, reward, terminated, truncated, _ = eval_maze.step(int(q_table[state].argmax()))
            yield reward
            over = terminated or truncated

    for number in count(1):
        play_remembering(maze, q_table, rng)
        if 1.0 in exam() or number == max_episodes:
            return q_table, number
