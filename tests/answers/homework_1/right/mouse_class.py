"""A class of its own, whose attributes are the mouse's memory; both games are the same method with another rule."""

import numpy as np

MOVES = {0: (-1, 0), 1: (1, 0), 2: (0, -1), 3: (0, 1)}


class Mouse:
    gamma = 0.9
    alpha = 0.1
    epsilon = 0.1

    def __init__(self, maze, q_table, rng, remembers):
        self.maze = maze
        self.q = q_table
        self.rng = rng
        self.remembers = remembers
        self.known_walls = set()
        self.been = []
        self.trail = []

    def look(self, action):
        r, c = self.maze.cell(self.where)
        r, c = r + MOVES[action][0], c + MOVES[action][1]
        return (r, c) if 0 <= r < self.maze.rows and 0 <= c < self.maze.columns else "edge"

    def options(self):
        options = [a for a in MOVES if self.look(a) not in self.known_walls]
        if self.remembers:
            options = [a for a in options if self.look(a) != "edge" and self.look(a) not in self.been]
        return options

    def decide(self):
        options = self.options()
        if not options:
            self.trail.pop()
            return next(a for a in MOVES if self.look(a) == self.trail[-1])
        self.rng.shuffle(options)
        if self.rng.random() < self.epsilon:
            return options[0]
        return max(options, key=lambda a: self.q[self.where, a])

    def learn(self, action, reward, after, terminated):
        old = self.q[self.where, action]
        future = 0 if terminated else self.q[after].max()
        self.q[self.where, action] = (1 - self.alpha) * old + self.alpha * (reward + self.gamma * future)

    def live(self):
        self.where, _ = self.maze.reset()
        self.been.append(self.maze.cell(self.where))
        self.trail.append(self.maze.cell(self.where))
        age = 0
        alive = True
        while alive:
            action = self.decide()
            after, reward, terminated, truncated, info = self.maze.step(action)
            age += 1
            self.learn(action, reward, after, terminated)
            if info["bumped"]:
                self.known_walls.add(self.look(action))
            self.where = after
            cell = self.maze.cell(after)
            if cell not in self.been:
                self.been.append(cell)
                self.trail.append(cell)
            alive = not (terminated or truncated)
        return age


def play_on(maze, q_table, rng):
    return Mouse(maze, q_table, rng, remembers=False).live()


def play_remembering(maze, q_table, rng):
    return Mouse(maze, q_table, rng, remembers=True).live()


def passes_exam(eval_maze, q_table):
    state, _ = eval_maze.reset()
    terminated = truncated = False
    reward = 0
    while not terminated and not truncated:
        state, reward, terminated, truncated, _ = eval_maze.step(int(np.argmax(q_table[state])))
    return reward > 0


def train(maze, eval_maze, rng, max_episodes):
    q_table = np.zeros((maze.observation_space.n, maze.action_space.n))
    for number in range(1, max_episodes + 1):
        play_remembering(maze, q_table, rng)
        if passes_exam(eval_maze, q_table):
            return q_table, number
    return q_table, max_episodes
