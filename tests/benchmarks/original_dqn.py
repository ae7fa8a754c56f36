"""The program of the original lesson, DBQ_maze.py, made to run again.

    python tests/benchmarks/original_dqn.py                            # Keras on torch
    KERAS_BACKEND=tensorflow python tests/benchmarks/original_dqn.py   # on TensorFlow, the program's own backend

Run like this it says how many steps a second it makes. It needs Keras 3 with one of the two, and not `course_lib`.

The program's own way of doing things is kept: two or three calls of `predict` and one of `fit` a step, each with one
row of the identity matrix; targets from terminal states too; the start ends an episode like a wall; exploration decays
as an episode begins. The page's scan lost its indentation and some underscores. Two things differ from it:

- `InputLayer` takes `batch_shape`: Keras 3 no longer knows `batch_input_shape`;
- printing (a line a step, and the progress bar of every `predict`) and drawing are left out. That favours this program.
"""

import os

os.environ.setdefault("KERAS_BACKEND", "torch")

import numpy as np
from keras.backend import backend
from keras.layers import Dense, InputLayer
from keras.models import Sequential
from keras.utils import set_random_seed
from measure import seconds

BACKEND = backend()
OPEN, WALL, OCCUPIED, START, GOAL = range(5)
UP, DOWN, LEFT, RIGHT = range(4)

GRID = [[3, 0, 0, 0], [0, 0, 1, 0], [0, 0, 1, 0], [1, 0, 0, 4]]


class Maze:
    def __init__(self, grid, start_row, start_col, goal_row, goal_col):
        self.grid = grid
        self.rows = len(grid)
        self.cols = len(grid[0])
        self.start_row = start_row
        self.start_col = start_col
        self.goal_row = goal_row
        self.goal_col = goal_col
        self.agent_row = 0
        self.agent_col = 0

    def reset(self):
        self.agent_row = 0
        self.agent_col = 0
        return self.agent_row * self.rows + self.agent_col

    def observation_space(self):
        return self.rows * self.cols

    def step(self, action):
        done = False
        r = 0
        prev_agent_row, prev_agent_col = self.agent_row, self.agent_col
        if action == UP:
            self.agent_row = max(self.agent_row - 1, 0)
        if action == DOWN:
            self.agent_row = min(self.agent_row + 1, self.rows - 1)
        if action == LEFT:
            self.agent_col = max(self.agent_col - 1, 0)
        if action == RIGHT:
            self.agent_col = min(self.agent_col + 1, self.cols - 1)
        if self.is_done(self.agent_row, self.agent_col):
            done = True
            if (self.agent_row == self.goal_row) and (self.agent_col == self.goal_col):
                r = 1
            else:
                self.agent_row, self.agent_col = prev_agent_row, prev_agent_col
        next_state = self.agent_row * self.rows + self.agent_col
        return r, done, next_state

    def is_done(self, row, col):
        return self.grid[row][col] == START or self.grid[row][col] == WALL or self.grid[row][col] == GOAL


class DBQAgent:
    def __init__(self, discount_factor=0.95, eps=0.5, eps_decay_factor=0.999, num_episodes=500, maze=None):
        self.actions = [UP, DOWN, LEFT, RIGHT]
        self.maze = maze
        self.discount_factor = discount_factor
        self.eps = eps
        self.eps_decay_factor = eps_decay_factor
        self.num_episodes = num_episodes
        self.model = Sequential()
        self.model.add(InputLayer(batch_shape=(1, self.maze.observation_space())))
        self.model.add(Dense(20, activation="relu"))
        self.model.add(Dense(len(self.actions), activation="linear"))
        self.model.compile(loss="mse", optimizer="adam", metrics=["mae"])

    def train(self):
        action = 0
        for _i in range(self.num_episodes):
            state = self.maze.reset()
            self.eps *= self.eps_decay_factor
            done = False
            while not done:
                if np.random.random() < self.eps:  # noqa: NPY002
                    action = np.random.randint(0, len(self.actions))  # noqa: NPY002
                else:
                    action = np.argmax(self.predict(state))
                reward, done, new_state = self.maze.step(action)
                predict = self.predict(new_state)
                target = reward + self.discount_factor * np.max(predict)
                target_vector = self.predict(state)[0]
                target_vector[action] = target
                self.model.fit(
                    np.identity(self.maze.observation_space())[state : state + 1],
                    target_vector.reshape(-1, len(self.actions)),
                    epochs=1,
                    verbose=0,
                )
                state = new_state

    def predict(self, state):
        """The call that the page writes out four times."""
        return self.model.predict(np.identity(self.maze.observation_space())[state : state + 1], verbose=0)


class CountingMaze(Maze):
    """The same, with a count of its steps."""

    steps = 0

    def step(self, action):
        self.steps += 1
        return super().step(action)


def seconds_a_step(num_episodes):
    """How long a step takes; and the agent, whose first episode, in which Keras compiles the model, is not counted."""
    set_random_seed(0)
    agent = DBQAgent(num_episodes=1, maze=CountingMaze(GRID, 0, 0, 3, 3))
    agent.train()
    before, agent.num_episodes = agent.maze.steps, num_episodes
    taken = seconds(agent.train)
    return taken / (agent.maze.steps - before), agent


def q_values(agent):
    """What the program's network says of every state, float[states, actions]."""
    return np.concatenate([agent.predict(state) for state in range(agent.maze.observation_space())])


def main(num_episodes=40):
    step, agent = seconds_a_step(num_episodes)
    print(f"Keras on {BACKEND}: {1000 * step:.1f} ms a step, {1 / step:.1f} steps a second")


if __name__ == "__main__":
    main()
