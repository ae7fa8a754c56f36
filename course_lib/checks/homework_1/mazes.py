"""Mazes and tables made for the purpose, and what lies where in them."""

import numpy as np

from course_lib.bellman import value_iteration
from course_lib.maze import LESSON_GRID, MOVES, Action, Maze, Tile


def bumpy_mazes(seed):
    """Mazes with many walls, in which a bump ends nothing: the lesson's, and larger ones."""
    shapes = ((4, 4), (5, 7), (6, 6))
    return [Maze(LESSON_GRID, wall_ends_episode=False)] + [
        Maze.random(*shape, walls=0.35, seed=1000 * seed + i, wall_ends_episode=False) for i, shape in enumerate(shapes)
    ]


def corridor(seed):
    """A dead end on one side of the start, the cheese on the other; and a table that loves the dead end.

    It is so short that even a mouse which wanders at random gets out within 1000 steps, but for once in 10^5.
    """
    rng = np.random.default_rng(seed)
    left, right = rng.integers(4, 7), rng.integers(2, 4)
    grid = np.zeros((1, left + 1 + right), int)
    grid[0, left], grid[0, -1], lure = Tile.START, Tile.GOAL, Action.LEFT
    if rng.random() < 0.5:
        grid, lure = grid[:, ::-1], Action.RIGHT
    if rng.random() < 0.5:
        grid, lure = grid.T, {Action.LEFT: Action.UP, Action.RIGHT: Action.DOWN}[lure]
    maze = Maze(grid.tolist(), wall_ends_episode=False)
    table = np.zeros((maze.rows * maze.columns, len(Action)))
    table[:, lure] = 1.0
    return maze, table


def labyrinth(rooms, seed):
    """A maze of (2 rooms - 1)^2 cells with one way between any two rooms, so that every wrong turn is a dead end."""
    rng = np.random.default_rng(seed)
    size = 2 * rooms - 1
    grid = np.full((size, size), Tile.WALL)
    path = [(0, 0)]
    grid[0, 0] = Tile.OPEN
    while path:
        row, column = path[-1]
        ways = [(row + 2 * down, column + 2 * right) for down, right in MOVES]
        ways = [(r, c) for r, c in ways if 0 <= r < size and 0 <= c < size and grid[r, c] == Tile.WALL]
        if not ways:
            path.pop()
            continue
        r, c = ways[rng.integers(len(ways))]
        grid[r, c] = grid[(row + r) // 2, (column + c) // 2] = Tile.OPEN
        path.append((r, c))
    grid[0, 0], grid[-1, -1] = Tile.START, Tile.GOAL
    return Maze(grid.tolist(), wall_ends_episode=False)


def staircase(steps):
    """A corridor that goes right and down in turns: each of them is needed in one cell and bumps in the next."""
    grid = np.full((steps + 1, steps + 1), Tile.WALL)
    for i in range(steps):
        grid[i, i] = grid[i, i + 1] = Tile.OPEN
    grid[0, 0], grid[-1, -1] = Tile.START, Tile.GOAL
    return Maze(grid.tolist(), wall_ends_episode=False)


def table_that_knows_the_way(maze):
    """The exact action values, as lesson 2 computes them."""
    return value_iteration(maze.mdp, 0.9).q


def blank(maze):
    return np.zeros((maze.rows * maze.columns, len(Action)))


def table_that_loves_walls(maze, seed):
    """A table of small random values, and 1 for every action that runs into a wall."""
    table = random_table(maze, seed)
    for state in range(len(table)):
        for action in Action:
            cell = ahead(maze, state, action)
            if cell is not None and is_wall(maze, cell):
                table[state, action] = 1.0
    return table


def table_that_turns_back(maze, seed):
    """A table of small random values, and about 1 for every action that leads up or left, towards the start."""
    table = random_table(maze, seed)
    table[:, [Action.UP, Action.LEFT]] += 1.0
    return table


def random_table(maze, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.1, 0.4, size=blank(maze).shape)


def ahead(maze, state, action):
    """The cell that way, or None at the edge."""
    row, column = maze.cell(state)
    row, column = row + int(MOVES[action][0]), column + int(MOVES[action][1])
    return maze.state(row, column) if 0 <= row < maze.rows and 0 <= column < maze.columns else None


def is_wall(maze, state):
    return maze.grid[maze.cell(state)] == Tile.WALL


def place(maze, state):
    row, column = maze.cell(state)
    return f"row {row}, column {column}"


def map_of(maze, mouse=None):
    """The maze as text, the mouse where it was when something went wrong."""
    tiles = [list(row) for row in np.array([".", "#", "?", "S", "G"])[maze.grid]]
    legend = "S start, G cheese, # wall"
    if mouse is not None:
        row, column = maze.cell(mouse)
        legend += ", M the mouse" if tiles[row][column] != "S" else ", M the mouse, on the start"
        tiles[row][column] = "M"
    return "\n".join([" ".join(row) for row in tiles] + [legend, "rows and columns count from 0"])
