"""The table as a dictionary while the mouse walks, copied back into the array when it has arrived."""

from collections import defaultdict

import numpy as np


def read(q_table):
    return {(s, a): float(q_table[s, a]) for s in range(len(q_table)) for a in range(4)}


def write(values, q_table):
    for (s, a), value in values.items():
        q_table[s, a] = value


def best_of(values, s):
    return max(values[s, a] for a in range(4))


def play(maze, q_table, rng, memory):
    values = read(q_table)
    s, info = maze.reset()
    steps = 0
    try:
        while True:
            a = memory.suggest(s, values, rng)
            s2, r, terminated, truncated, info = maze.step(a)
            steps += 1
            target = r
            if not terminated:
                target = r + 0.9 * best_of(values, s2)
            values[s, a] += 0.1 * (target - values[s, a])
            memory.note(s, a, s2)
            if terminated or truncated:
                return steps
            s = s2
    finally:
        write(values, q_table)


def greedy_or_not(options, s, values, rng):
    if rng.random() < 0.1:
        return options[int(rng.random() * len(options))]
    options = sorted(options, key=lambda a: values[s, a])
    return options[-1]


class Bumps:
    def __init__(self, maze):
        self.maze = maze
        self.result = {}

    def suggest(self, s, values, rng):
        row, column = self.maze.cell(s)
        edge = {0: row == 0, 1: row == self.maze.rows - 1, 2: column == 0, 3: column == self.maze.columns - 1}
        return greedy_or_not([a for a in range(4) if not edge[a] and self.result.get((s, a)) != s], s, values, rng)

    def note(self, s, a, s2):
        self.result[s, a] = s2


class Cells(Bumps):
    def __init__(self, maze):
        super().__init__(maze)
        self.seen = defaultdict(int)

    def suggest(self, s, values, rng):
        self.seen[s] += 1
        row, column = self.maze.cell(s)
        options = {}
        for a, (r, c) in enumerate([(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]):
            try:
                there = self.maze.state(r, c)
            except ValueError:  # no such cell
                continue
            if self.result.get((s, a)) != s:
                options[a] = self.seen[there]
        least = min(options.values())
        options = [a for a in options if options[a] == least]
        return greedy_or_not(options, s, values, rng)


def play_on(maze, q_table, rng):
    return play(maze, q_table, rng, Bumps(maze))


def play_remembering(maze, q_table, rng):
    return play(maze, q_table, rng, Cells(maze))


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.rows * maze.columns, 4))
    for n in range(max_episodes):
        play_remembering(maze, q_table, rng)
        values = read(q_table)
        s, info = eval_maze.reset()
        over = False
        while not over:
            s, r, terminated, truncated, info = eval_maze.step(max(range(4), key=lambda a: values[s, a]))
            over = terminated or truncated
        if r == 1.0:
            break
    return q_table, n + 1
