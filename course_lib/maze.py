"""The mouse's world: a grid, the Gymnasium environment played on it, and the MDP it is."""

from collections import deque
from enum import IntEnum
from functools import cached_property

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec

from course_lib.mdp import MDP
from course_lib.validate import fraction, number, whole_number


class Tile(IntEnum):
    """What a cell of the grid holds. OCCUPIED is for pictures only: the cell the mouse is in."""

    OPEN, WALL, OCCUPIED, START, GOAL = range(5)


class Action(IntEnum):
    """The mouse's four moves."""

    UP, DOWN, LEFT, RIGHT = range(4)


LESSON_GRID = ((3, 0, 0, 0), (0, 0, 1, 0), (0, 0, 1, 0), (1, 0, 0, 4))

MOVES = np.array([[-1, 0], [1, 0], [0, -1], [0, 1]])  # (rows, columns) an action moves by
SIDES = np.array([[2, 3], [2, 3], [0, 1], [0, 1]])  # where a slip takes each action

_SYMBOLS = {Tile.OPEN: ".", Tile.WALL: "#", Tile.OCCUPIED: "m", Tile.START: "S", Tile.GOAL: "G"}
_COLOURS = {
    Tile.OPEN: (245, 245, 240),
    Tile.WALL: (60, 60, 70),
    Tile.OCCUPIED: (213, 94, 0),
    Tile.START: (200, 225, 240),
    Tile.GOAL: (240, 228, 66),
}
_CELL_PIXELS = 32


class Maze(gymnasium.Env):
    """A mouse looks for cheese: a grid world with Discrete states and four actions.

    state = row * columns + column. A move into an open cell pays `step_reward`; into a goal `goal_reward`, and the
    episode terminates. The edge of the grid keeps the mouse where it is and pays `step_reward`. A wall keeps it where
    it is, pays `wall_reward`, and terminates the episode if `wall_ends_episode`. With probability `slip` a move goes
    to one of its two sides instead, half each. `cell_rewards`, float[rows, columns], is added to a move that enters a
    cell.

    `info["bumped"]` says whether a wall stopped the last move. Time limits are Gymnasium's `TimeLimit` wrapper.
    Raises `ValueError` for a ragged or empty grid, an unknown tile, no start or several, no goal or one that no path
    reaches, a `slip` outside [0, 1] and rewards that are not finite.
    """

    metadata = {"render_modes": ["ansi", "rgb_array"], "render_fps": 4}

    def __init__(
        self,
        grid=LESSON_GRID,
        *,
        slip=0.0,
        step_reward=0.0,
        wall_reward=-1.0,
        goal_reward=1.0,
        wall_ends_episode=True,
        cell_rewards=None,
        render_mode=None,
    ):
        self.grid = _checked_grid(grid)
        self.rows, self.columns = self.grid.shape
        self.start = int(np.flatnonzero(self.grid == Tile.START)[0])
        self.goals = tuple(int(s) for s in np.flatnonzero(self.grid == Tile.GOAL))
        _check_goals_reachable(self)
        self.slip = fraction("slip", slip)
        self.step_reward = number("step_reward", step_reward)
        self.wall_reward = number("wall_reward", wall_reward)
        self.goal_reward = number("goal_reward", goal_reward)
        self.wall_ends_episode = bool(wall_ends_episode)
        self.cell_rewards = _checked_cell_rewards(cell_rewards, self.grid.shape)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be None, 'ansi' or 'rgb_array', got {render_mode!r}")
        self.render_mode = render_mode
        rules = {"slip": slip, "step_reward": step_reward, "wall_reward": wall_reward, "goal_reward": goal_reward}
        rules |= {"wall_ends_episode": wall_ends_episode, "cell_rewards": cell_rewards, "grid": grid}
        self.spec = EnvSpec("course_lib/Maze-v0", entry_point="course_lib.maze:Maze", kwargs=rules)
        self.observation_space = gymnasium.spaces.Discrete(self.grid.size)
        self.action_space = gymnasium.spaces.Discrete(len(Action))
        self._state = None

    @classmethod
    def random(cls, rows, columns, *, walls=0.2, seed=0, **same):
        """A random maze from the top left corner to the bottom right one, always solvable.

        Each other cell is a wall with probability `walls`; if that leaves no way, a random path right and down is
        opened. The same `seed` gives the same maze. `same`: the arguments of `Maze`.
        """
        rows, columns = whole_number("rows", rows, at_least=1), whole_number("columns", columns, at_least=1)
        if rows * columns < 2:
            raise ValueError(f"a maze needs at least 2 cells, got {rows} x {columns}")
        rng = np.random.default_rng(whole_number("seed", seed))
        grid = (rng.random((rows, columns)) < fraction("walls", walls)).astype(np.int8) * Tile.WALL
        grid[0, 0], grid[-1, -1] = Tile.START, Tile.GOAL
        if not _reachable(grid)[-1, -1]:
            downs = rng.permutation(np.arange(rows + columns - 2) < rows - 1)
            path_rows, path_columns = np.cumsum(downs), np.cumsum(~downs)
            grid[path_rows[:-1], path_columns[:-1]] = Tile.OPEN
        return cls(grid, **same)

    def state(self, row, column):
        """The number of the cell in `row` and `column`, both from 0."""
        row = whole_number("row", row, below=self.rows)
        return row * self.columns + whole_number("column", column, below=self.columns)

    def cell(self, state):
        """The (row, column) of a state."""
        return divmod(whole_number("state", state, below=self.grid.size), self.columns)

    def cell_ahead(self, state, action):
        """The cell beside `state` in the direction of `action`, wall or not; at the edge `state` itself."""
        state = whole_number("state", state, below=self.grid.size)
        return int(self._cell_ahead[state, whole_number("action", action, below=len(Action))])

    def reset(self, *, seed=None, options=None):  # noqa: ARG002 (Gymnasium's signature)
        super().reset(seed=seed)
        self._state = self.start
        return self._state, {"bumped": False}

    def step(self, action):
        if self._state is None:
            raise ValueError("call reset() before step(): the mouse is not in the maze yet")
        action = whole_number("action", action, below=len(Action))
        mdp, state, outcome = self.mdp, self._state, 0
        if self.slip:
            drawn = self.np_random.random()
            outcome = int(np.argmax(np.cumsum(mdp.probability[state, action]) > drawn))
        direction = action if outcome == 0 else SIDES[action, outcome - 1]
        self._state = int(mdp.next_state[state, action, outcome])
        reward = float(mdp.reward[state, action, outcome])
        terminated = bool(mdp.terminal[state, action, outcome])
        bumped = bool(self._wall_ahead[state, direction])
        return self._state, reward, terminated, False, {"bumped": bumped}

    @cached_property
    def mdp(self):
        """This world as an `MDP`: 1 outcome a move, or 3 (as meant, to one side, to the other) where it is slippery.

        Walls and goals are states in which nothing more happens: every move ends there and pays 0.
        """
        next_state, reward, terminal = self._moves
        if not self.slip:
            outcomes = np.arange(len(Action))[:, None]
            probability = np.ones((self.grid.size, len(Action), 1))
        else:
            outcomes = np.column_stack([np.arange(len(Action)), SIDES])
            chances = [1 - self.slip, self.slip / 2, self.slip / 2]
            probability = np.broadcast_to(chances, (self.grid.size, len(Action), 3))
        return MDP(next_state[:, outcomes], probability, reward[:, outcomes], terminal[:, outcomes])

    @cached_property
    def _wall_ahead(self):
        """bool[S, 4]: whether moving that way from that cell runs into a wall."""
        return self.grid.ravel()[self._cell_ahead] == Tile.WALL

    @cached_property
    def _cell_ahead(self):
        """int32[S, 4]: the cell that way, the cell itself at the edge."""
        cells = np.pad(np.arange(self.grid.size, dtype=np.int32).reshape(self.grid.shape), 1, mode="edge")
        ways = (cells[:-2, 1:-1], cells[2:, 1:-1], cells[1:-1, :-2], cells[1:-1, 2:])  # in the order of Action
        return np.stack(ways, axis=-1).reshape(-1, len(Action))

    @property
    def _moves(self):
        """next_state, reward, terminal, each [S, 4]: what a move does when it goes the way that was meant."""
        here = np.arange(self.grid.size, dtype=np.int32)[:, None]
        tiles, wall = self.grid.ravel(), self._wall_ahead
        goal = tiles[self._cell_ahead] == Tile.GOAL
        next_state = np.where(wall, here, self._cell_ahead)
        reward = np.where(wall, self.wall_reward, np.where(goal, self.goal_reward, self.step_reward))
        reward += np.where(next_state != here, self.cell_rewards.ravel()[next_state], 0.0)
        terminal = goal | (wall & self.wall_ends_episode)
        over = np.isin(tiles, (Tile.WALL, Tile.GOAL))
        next_state[over], reward[over], terminal[over] = here[over], 0.0, True
        return next_state, reward, terminal

    def render(self):
        """The grid with the mouse in it: text ('ansi') or uint8[rows * 32, columns * 32, 3] ('rgb_array')."""
        if self.render_mode is None:
            gymnasium.logger.warn(
                "render() draws nothing without a render_mode: Maze(render_mode='ansi') or 'rgb_array'"
            )
            return None
        tiles = self.grid.copy()
        if self._state is not None:
            tiles.flat[self._state] = Tile.OCCUPIED
        if self.render_mode == "ansi":
            return "\n".join(" ".join(_SYMBOLS[tile] for tile in row) for row in tiles) + "\n"
        palette = np.array([_COLOURS[tile] for tile in Tile], np.uint8)
        return palette[tiles].repeat(_CELL_PIXELS, axis=0).repeat(_CELL_PIXELS, axis=1)


def _checked_grid(grid):
    """`grid` as a read-only int8[rows, columns] with exactly one start and at least one goal, or a `ValueError`."""
    try:
        lengths = {len(row) for row in grid}
    except TypeError:
        raise ValueError(f"grid must be rows of tiles, such as LESSON_GRID, got {grid!r}") from None
    if lengths in (set(), {0}):
        raise ValueError("grid is empty: it needs at least a start and a goal")
    if len(lengths) > 1:
        raise ValueError(f"every row of the grid must be as long as the others, got rows of {sorted(lengths)} tiles")
    tiles = np.array(grid)
    if tiles.ndim != 2 or not np.issubdtype(tiles.dtype, np.integer):
        raise ValueError(f"tiles must be whole numbers, got {tiles.dtype} of shape {tiles.shape}")
    unknown = np.setdiff1d(tiles, list(Tile))
    if unknown.size:
        raise ValueError(f"unknown tile {unknown[0]}: a grid holds 0 (open), 1 (wall), 3 (start) and 4 (goal)")
    if (tiles == Tile.OCCUPIED).any():
        raise ValueError("tile 2 (occupied) is for pictures: the mouse begins on the start, tile 3")
    starts = int((tiles == Tile.START).sum())
    if starts != 1:
        raise ValueError(f"a grid needs exactly one start (tile 3), got {starts}")
    if not (tiles == Tile.GOAL).any():
        raise ValueError("a grid needs at least one goal (tile 4), got none")
    tiles = tiles.astype(np.int8)
    tiles.flags.writeable = False
    return tiles


def _checked_cell_rewards(cell_rewards, shape):
    if cell_rewards is None:
        return np.zeros(shape)
    try:
        rewards = np.array(cell_rewards, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"cell_rewards must be numbers of shape {shape}, got {cell_rewards!r}") from None
    if rewards.shape != shape:
        raise ValueError(f"cell_rewards must have the grid's shape {shape}, got {rewards.shape}")
    if not np.isfinite(rewards).all():
        raise ValueError("cell_rewards must be finite, got NaN or infinity")
    return rewards


def _reachable(grid):
    """bool[rows, columns]: the cells a mouse can enter from the start; it goes no further than a goal."""
    columns = grid.shape[1] + 2
    tiles = np.pad(grid, 1, constant_values=Tile.WALL).ravel().tolist()  # a wall all around spares the edge tests
    seen = [tile == Tile.WALL for tile in tiles]
    frontier = deque([tiles.index(Tile.START)])
    seen[frontier[0]] = True
    found = list(frontier)
    while frontier:
        cell = frontier.popleft()
        for neighbour in (cell - columns, cell + columns, cell - 1, cell + 1):
            if not seen[neighbour]:
                seen[neighbour] = True
                found.append(neighbour)
                if tiles[neighbour] != Tile.GOAL:
                    frontier.append(neighbour)
    reached = np.zeros(len(tiles), bool)
    reached[found] = True
    return reached.reshape(-1, columns)[1:-1, 1:-1]


def _check_goals_reachable(maze):
    reached = _reachable(maze.grid).ravel()
    for goal in maze.goals:
        if not reached[goal]:
            row, column = divmod(goal, maze.columns)
            raise ValueError(f"no path leads from the start to the goal in row {row}, column {column}")
