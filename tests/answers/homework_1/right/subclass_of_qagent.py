"""The course's own agent, made to remember: subclasses of QAgent that play one episode each."""

import numpy as np

from course_lib import Action, QAgent


class StubbornAgent(QAgent):
    """Tries another action after a bump."""

    def __init__(self, maze, q_table, rng):
        super().__init__(maze)
        self.q_table = q_table
        self.rng = rng

    def begin(self):
        self.state, _ = self.env.reset()
        self.bumped = np.zeros(self.q_table.shape, bool)

    def candidates(self):
        return np.flatnonzero(~self.bumped[self.state])

    def pick(self):
        actions = self.candidates()
        if self.rng.random() < self.epsilon:
            return self.rng.choice(actions)
        values = self.q_table[self.state, actions]
        return self.rng.choice(actions[values == values.max()])

    def notice(self, action, next_state, info):
        self.bumped[self.state, action] |= info["bumped"]

    def play(self):
        self.begin()
        for step in range(1, 1_000_000):
            action = self.pick()
            next_state, reward, terminated, truncated, info = self.env.step(action)
            self._learn(self.state, action, reward, next_state, terminated)
            self.notice(action, next_state, info)
            self.state = next_state
            if terminated or truncated:
                return step


class RememberingAgent(StubbornAgent):
    """Keeps to fresh cells; in a dead end it takes the way it has gone least often."""

    def begin(self):
        super().begin()
        self.times = np.zeros(len(self.q_table))
        self.times[self.state] = 1

    def beyond(self, action):
        row, column = self.env.cell(self.state)
        row += {Action.UP: -1, Action.DOWN: 1}.get(action, 0)
        column += {Action.LEFT: -1, Action.RIGHT: 1}.get(action, 0)
        inside = row in range(self.env.rows) and column in range(self.env.columns)
        return self.env.state(row, column) if inside else None

    def candidates(self):
        ahead = {a: self.beyond(a) for a in super().candidates()}
        open_ones = {a: self.times[cell] for a, cell in ahead.items() if cell is not None}
        return np.array([a for a, times in open_ones.items() if times == min(open_ones.values())])

    def notice(self, action, next_state, info):
        super().notice(action, next_state, info)
        self.times[next_state] += 1


def play_on(maze, q_table, rng):
    return StubbornAgent(maze, q_table, rng).play()


def play_remembering(maze, q_table, rng):
    return RememberingAgent(maze, q_table, rng).play()


def train(maze, eval_maze, rng, max_episodes):
    agent = QAgent(maze, seed=int(rng.integers(1000)))
    for episode in range(max_episodes):
        agent.train(1)
        state, _ = eval_maze.reset()
        terminated = truncated = False
        while not (terminated or truncated):
            state, reward, terminated, truncated, _ = eval_maze.step(agent.q_table[state].argmax())
        if terminated and reward > 0:
            break
    return agent.q_table, episode + 1
