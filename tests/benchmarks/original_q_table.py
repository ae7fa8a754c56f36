"""The program of the original lesson, Qtable_maze.py, made to run again.

The only copy left is a scan that lost its indentation, a few lines and some underscores. What follows keeps the
program's own way of doing things: a table of nested lists, one `np.random.uniform()` a step, `np.random.choice` over
the actions, a random action wherever a row of the table sums to 0, the first of the best actions otherwise, and the
same order of everything. Three things differ from the page:

- printing (two lines a step) and drawing are left out. That favours this program: with them it is slower;
- a wall puts the mouse back, pays nothing and ends nothing. The page's text pays -1, its printed table holds no
  negative entry, and this is the world that the benchmark plays in;
- the goal ends an episode, the start does not: the page names both in a condition of which the scan lost a part.
"""

import numpy as np

ROW, COL = 0, 1
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
        return (0, 0), 0

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
            if (self.agent_row == self.goal_row) and (self.agent_col == self.goal_col):
                done = True
                r = 1
            else:
                self.agent_row, self.agent_col = prev_agent_row, prev_agent_col
        next_state = (self.agent_row, self.agent_col)
        state_number = self.agent_row * self.cols + self.agent_col
        return next_state, r, done, state_number

    def is_done(self, row, col):
        done = False
        if self.grid[row][col] == WALL or self.grid[row][col] == GOAL:
            done = True
        return done


class QAgent:
    def __init__(self, gamma=0.9, alpha=0.1, epsilon=0.1, num_episodes=500, maze=None):
        self.q_table = [[[0, 0, 0, 0] for c in range(maze.cols)] for r in range(maze.rows)]
        self.actions = [UP, DOWN, LEFT, RIGHT]
        self.maze = maze
        self.alpha = alpha
        self.gamma = gamma
        self.epsilon = epsilon
        self.num_episodes = num_episodes

    def train(self):
        for _episode in range(self.num_episodes):
            done = False
            state, _state_number = self.maze.reset()
            while not done:
                if (np.random.uniform() < self.epsilon) or (sum(self.q_table[state[ROW]][state[COL]]) == 0):  # noqa: NPY002
                    action = np.random.choice(self.actions)  # noqa: NPY002
                else:
                    actions = self.q_table[state[ROW]][state[COL]]
                    action = actions.index(max(actions))
                next_state, reward, done, _state_number = self.maze.step(action)
                current_q = self.q_table[state[ROW]][state[COL]][action]
                next_q = max(self.q_table[next_state[ROW]][next_state[COL]])
                self.q_table[state[ROW]][state[COL]][action] += self.alpha * (reward + self.gamma * next_q - current_q)
                state = next_state
