"""The maze keeps its rules, as an environment and as an MDP alike."""

import copy
from collections import defaultdict

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import TimeLimit
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib import LESSON_GRID, Action, Maze, Tile

UP, DOWN, LEFT, RIGHT = range(4)
AHEAD = {UP: (-1, 0), DOWN: (1, 0), LEFT: (0, -1), RIGHT: (0, 1)}
SIDES = {UP: (LEFT, RIGHT), DOWN: (LEFT, RIGHT), LEFT: (UP, DOWN), RIGHT: (UP, DOWN)}
WIDE = [[0, 3, 0, 0, 0], [0, 1, 0, 1, 0], [0, 0, 0, 4, 0]]  # 3 rows, 5 columns


def world_by_the_rules(
    grid, *, slip=0.0, step_reward=0.0, wall_reward=-1.0, goal_reward=1.0, wall_ends_episode=True, cell_rewards=None
):
    """The maze as table[s][a] = [(probability, next state, reward, ends), …]: the rules read again, in plain Python."""
    grid = [[int(tile) for tile in row] for row in grid]
    rows, columns = len(grid), len(grid[0])

    def go(row, column, direction):
        here = row * columns + column
        if grid[row][column] in (1, 4):
            return here, 0.0, True
        to_row, to_column = row + AHEAD[direction][0], column + AHEAD[direction][1]
        if not (0 <= to_row < rows and 0 <= to_column < columns):
            return here, step_reward, False
        if grid[to_row][to_column] == 1:
            return here, wall_reward, wall_ends_episode
        extra = 0.0 if cell_rewards is None else cell_rewards[to_row][to_column]
        if grid[to_row][to_column] == 4:
            return to_row * columns + to_column, goal_reward + extra, True
        return to_row * columns + to_column, step_reward + extra, False

    def outcomes(row, column, action):
        ways = [(1 - slip, action), *((slip / 2, side) for side in SIDES[action])]
        return [(chance, *go(row, column, way)) for chance, way in ways if chance > 0]

    return [[outcomes(*divmod(s, columns), a) for a in range(4)] for s in range(rows * columns)]


def random_rules(seed):
    """The grid and the rules of a random maze, as keyword arguments of `Maze`."""
    rng = np.random.default_rng(seed)
    rows, columns = (int(n) for n in rng.integers(2, 9, 2))
    rules = {
        "slip": float(rng.choice([0.0, rng.uniform(0, 0.5)])),
        "step_reward": float(rng.choice([0.0, rng.uniform(-0.2, 0.1)])),
        "wall_reward": float(rng.uniform(-2, 0.2)),
        "goal_reward": float(rng.uniform(0.5, 2)),
        "wall_ends_episode": bool(rng.random() < 0.5),
        "cell_rewards": rng.uniform(-0.5, 0.5, (rows, columns)) if rng.random() < 0.3 else None,
    }
    grid = Maze.random(rows, columns, walls=float(rng.uniform(0, 0.4)), seed=seed).grid
    return {"grid": grid.tolist(), **rules}


def walk(maze, *actions):
    """The last answer of a walk from the start."""
    maze.reset(seed=0)
    for action in actions:
        answer = maze.step(action)
    return answer


def from_cell(maze, row, column, action):
    maze.reset(seed=0)
    maze._state = maze.state(row, column)
    return maze.step(action)


# --- the rules --------------------------------------------------------------------------------------------------------


def test_the_edge_keeps_the_mouse_pays_the_step_reward_and_ends_nothing():
    maze = Maze(step_reward=-0.25, wall_reward=-7.0)
    for action in (UP, LEFT):
        assert walk(maze, action) == (maze.start, -0.25, False, False, {"bumped": False})


@pytest.mark.parametrize("ends", [True, False])
def test_a_wall_keeps_the_mouse_pays_the_wall_reward_and_ends_the_episode_only_if_told(ends):
    maze = Maze(wall_reward=-7.0, step_reward=0.5, wall_ends_episode=ends)
    assert from_cell(maze, 1, 1, RIGHT) == (maze.state(1, 1), -7.0, ends, False, {"bumped": True})


def test_a_goal_pays_the_goal_reward_and_ends_the_episode():
    maze = Maze(goal_reward=5.0, step_reward=0.5)
    assert from_cell(maze, 3, 2, RIGHT) == (15, 5.0, True, False, {"bumped": False})


def test_an_open_cell_and_the_start_pay_the_step_reward():
    maze = Maze(step_reward=0.5)
    assert walk(maze, RIGHT) == (1, 0.5, False, False, {"bumped": False})
    assert walk(maze, RIGHT, LEFT) == (0, 0.5, False, False, {"bumped": False})


def test_cell_rewards_are_added_when_a_cell_is_entered_and_never_otherwise():
    rewards = np.arange(16.0).reshape(4, 4)
    maze = Maze(step_reward=0.5, wall_reward=-1.0, goal_reward=2.0, cell_rewards=rewards)
    assert from_cell(maze, 1, 0, RIGHT)[1] == 0.5 + 5
    assert from_cell(maze, 3, 2, RIGHT)[1] == 2.0 + 15
    assert from_cell(maze, 0, 3, UP)[1] == 0.5, "an edge is not entered"
    assert from_cell(maze, 1, 1, RIGHT)[1] == -1.0, "a wall is not entered"


def test_a_wall_and_a_goal_keep_whoever_is_in_them_for_nothing():
    maze = Maze(step_reward=0.5, cell_rewards=np.ones((4, 4)), slip=0.3)
    for state in (6, 15):
        assert (maze.mdp.next_state[state] == state).all()
        assert (maze.mdp.reward[state] == 0).all()
        assert maze.mdp.terminal[state].all()


def test_a_slip_goes_to_either_side_half_of_the_time():
    maze = Maze([[3, 0, 0], [0, 0, 0], [0, 0, 4]], slip=0.3)
    maze.reset(seed=1)
    landed = defaultdict(int)
    for _ in range(20_000):
        maze._state = 4
        landed[maze.step(UP)[0]] += 1
    assert set(landed) == {1, 3, 5}
    assert abs(landed[1] / 20_000 - 0.7) < 0.02
    assert abs(landed[3] / 20_000 - 0.15) < 0.02
    assert abs(landed[5] / 20_000 - 0.15) < 0.02


def test_a_maze_that_always_slips_never_goes_straight_on():
    maze = Maze([[3, 0, 0], [0, 0, 0], [0, 0, 4]], slip=1.0)
    maze.reset(seed=1)
    landed = set()
    for _ in range(100):
        maze._state = 4
        landed.add(maze.step(RIGHT)[0])
    assert landed == {1, 7}


def test_bumped_tells_the_way_the_mouse_really_went():
    maze = Maze([[1, 0, 1], [3, 0, 0], [0, 0, 4]], slip=1.0, wall_ends_episode=False)
    maze.reset(seed=0)
    for _ in range(50):
        maze._state = 3
        state, _, _, _, info = maze.step(RIGHT)  # slips up into the wall, or down
        assert info["bumped"] == (state == 3)


# --- states -----------------------------------------------------------------------------------------------------------


def test_states_count_row_by_row_on_a_maze_that_is_not_square():
    maze = Maze(WIDE)
    assert (maze.rows, maze.columns, maze.observation_space.n, maze.action_space.n) == (3, 5, 15, 4)
    assert (maze.start, maze.goals) == (1, (13,))
    assert maze.state(2, 3) == 13
    assert [maze.state(*maze.cell(s)) for s in range(15)] == list(range(15))
    assert [maze.cell(s) for s in (0, 4, 5, 14)] == [(0, 0), (0, 4), (1, 0), (2, 4)]
    assert from_cell(maze, 1, 4, DOWN)[0] == 14
    assert from_cell(maze, 2, 1, RIGHT)[0] == 12


def test_names_and_numbers_of_tiles_and_actions():
    assert [tile.name for tile in Tile] == ["OPEN", "WALL", "OCCUPIED", "START", "GOAL"]
    assert [action.name for action in Action] == ["UP", "DOWN", "LEFT", "RIGHT"]
    assert list(Tile) == list(range(5))
    assert list(Action) == list(range(4))
    assert LESSON_GRID == ((3, 0, 0, 0), (0, 0, 1, 0), (0, 0, 1, 0), (1, 0, 0, 4))


def test_a_maze_may_have_several_goals():
    maze = Maze([[4, 3, 0], [0, 0, 4]])
    assert maze.goals == (0, 5)
    assert walk(maze, LEFT)[:3] == (0, 1.0, True)
    assert walk(maze, RIGHT, DOWN)[:3] == (5, 1.0, True)


def test_the_grid_is_a_copy_that_cannot_be_written():
    grid = np.array(LESSON_GRID)
    maze = Maze(grid)
    grid[0, 1] = Tile.WALL
    assert maze.grid[0, 1] == Tile.OPEN
    with pytest.raises(ValueError, match="read-only"):
        maze.grid[0, 1] = Tile.WALL


# --- the environment and the MDP --------------------------------------------------------------------------------------


def merged(outcomes):
    """{(next state, reward, ends): probability} of the outcomes that can happen."""
    chances = defaultdict(float)
    for chance, next_state, reward, ends in outcomes:
        if chance > 0:
            chances[int(next_state), float(reward), bool(ends)] += float(chance)
    return dict(chances)


@pytest.mark.parametrize("seed", range(30))
def test_the_mdp_is_what_the_rules_say(seed):
    rules = random_rules(seed)
    mdp, table = Maze(**rules).mdp, world_by_the_rules(**rules)
    for s in range(mdp.num_states):
        for a in range(4):
            row = zip(mdp.probability[s, a], mdp.next_state[s, a], mdp.reward[s, a], mdp.terminal[s, a], strict=True)
            assert merged(row) == pytest.approx(merged(table[s][a]))


@pytest.mark.parametrize("seed", range(30))
def test_every_step_is_a_draw_from_the_mdp(seed):
    maze = Maze(**random_rules(seed))
    mdp = maze.mdp
    maze.reset(seed=seed)
    for s in range(mdp.num_states):
        for a in range(4):
            drawn = copy.deepcopy(maze.np_random).random()
            k = int(np.flatnonzero(np.cumsum(mdp.probability[s, a]) > drawn)[0])
            maze._state = s
            state, reward, terminated, truncated, _ = maze.step(a)
            assert (state, reward) == (mdp.next_state[s, a, k], mdp.reward[s, a, k])
            assert (terminated, truncated) == (mdp.terminal[s, a, k], False)


def test_a_maze_that_does_not_slip_draws_nothing():
    maze = Maze()
    maze.reset(seed=3)
    before = maze.np_random.bit_generator.state
    maze.step(RIGHT)
    assert maze.np_random.bit_generator.state == before


def stroll(maze, seed, steps=60):
    """A walk with fixed actions, through as many episodes as it takes."""
    maze.reset(seed=seed)
    trail = []
    for action in np.random.default_rng(0).integers(0, 4, steps):
        state, reward, terminated, _, _ = maze.step(action)
        trail.append((state, reward, terminated))
        if terminated:
            maze.reset()
    return trail


def test_the_seed_of_reset_decides_everything():
    maze = Maze(slip=0.5)
    first = stroll(maze, 7)
    assert stroll(maze, 7) == first
    assert stroll(Maze(slip=0.5), 7) == first
    assert any(stroll(maze, seed) != first for seed in range(5))


def test_reset_puts_the_mouse_on_the_start():
    maze = Maze(WIDE)
    assert maze.reset(seed=0) == (1, {"bumped": False})
    maze.step(LEFT)
    assert maze.reset() == (1, {"bumped": False})


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "make",
    [
        lambda: Maze(),
        lambda: Maze(slip=0.3, render_mode="ansi"),
        lambda: Maze.random(3, 5, slip=0.1, render_mode="rgb_array"),
        lambda: gymnasium.make("course_lib/Maze-v0").unwrapped,
        lambda: gymnasium.make("course_lib/Maze-v0", slip=0.2, render_mode="rgb_array").unwrapped,
    ],
)
def test_gymnasium_finds_no_fault_with_it(make):
    check_env(make())


def test_a_time_limit_truncates_and_does_not_terminate():
    env = TimeLimit(Maze(), 3)
    env.reset(seed=0)
    assert [env.step(UP)[2:4] for _ in range(3)] == [(False, False), (False, False), (False, True)]


def test_the_registered_maze_has_a_time_limit_and_takes_the_rules():
    env = gymnasium.make("course_lib/Maze-v0", grid=WIDE, slip=0.25)
    assert env.spec.max_episode_steps == 1000
    assert (env.unwrapped.slip, env.unwrapped.grid.tolist()) == (0.25, WIDE)


def test_a_spec_makes_the_same_maze_again():
    maze = Maze(WIDE, slip=0.25, step_reward=-0.5, cell_rewards=np.ones((3, 5)))
    again = gymnasium.make(maze.spec).unwrapped
    for name in ("next_state", "probability", "reward", "terminal"):
        np.testing.assert_array_equal(getattr(again.mdp, name), getattr(maze.mdp, name))


def test_several_mazes_run_as_one_vector():
    envs = gymnasium.make_vec("course_lib/Maze-v0", num_envs=3, vectorization_mode="sync")
    states, _ = envs.reset(seed=0)
    assert states.tolist() == [0, 0, 0]
    assert envs.step(np.array([RIGHT, DOWN, UP]))[0].tolist() == [1, 4, 0]


# --- random mazes -----------------------------------------------------------------------------------------------------


def goal_can_be_reached(grid):
    rows, columns = grid.shape
    seen, waiting = {(0, 0)}, [(0, 0)]
    while waiting:
        row, column = waiting.pop()
        for down, right in AHEAD.values():
            cell = row + down, column + right
            if 0 <= cell[0] < rows and 0 <= cell[1] < columns and cell not in seen and grid[cell] != Tile.WALL:
                seen.add(cell)
                waiting.append(cell)
    return (rows - 1, columns - 1) in seen


@settings(derandomize=True, deadline=None, max_examples=200)
@given(st.integers(1, 12), st.integers(2, 12), st.floats(0, 1), st.integers(0, 2**32), st.booleans())
def test_a_random_maze_can_always_be_solved(rows, columns, walls, seed, upright):
    rows, columns = (columns, rows) if upright else (rows, columns)
    maze = Maze.random(rows, columns, walls=walls, seed=seed)
    assert maze.grid.shape == (rows, columns)
    assert (maze.start, maze.goals) == (0, (rows * columns - 1,))
    assert goal_can_be_reached(maze.grid)


@pytest.mark.parametrize("seed", range(20))
def test_a_random_maze_of_walls_only_has_one_path(seed):
    grid = Maze.random(6, 9, walls=1.0, seed=seed).grid
    assert (grid != Tile.WALL).sum() == 6 + 9 - 1
    assert goal_can_be_reached(grid)


def test_a_random_maze_without_walls_has_none():
    assert not (Maze.random(6, 9, walls=0.0).grid == Tile.WALL).any()


def test_the_same_seed_gives_the_same_random_maze_and_another_one_another():
    grids = [Maze.random(8, 8, seed=seed).grid.tobytes() for seed in range(10)]
    assert [Maze.random(8, 8, seed=seed).grid.tobytes() for seed in range(10)] == grids
    assert len(set(grids)) == 10


def test_about_as_many_cells_are_walls_as_asked_for():
    assert abs((Maze.random(100, 100, walls=0.3, seed=0).grid == Tile.WALL).mean() - 0.3) < 0.03


def test_a_random_maze_takes_the_rules_of_a_maze():
    maze = Maze.random(4, 4, slip=0.5, wall_reward=-3.0, wall_ends_episode=False)
    assert (maze.slip, maze.wall_reward, maze.wall_ends_episode) == (0.5, -3.0, False)


# --- pictures ---------------------------------------------------------------------------------------------------------


def test_ansi_is_the_grid_with_the_mouse_in_it():
    maze = Maze(render_mode="ansi")
    assert maze.render() == "S . . .\n. . # .\n. . # .\n# . . G\n"
    maze.reset(seed=0)
    assert maze.render() == "m . . .\n. . # .\n. . # .\n# . . G\n"
    maze.step(RIGHT)
    assert maze.render() == "S m . .\n. . # .\n. . # .\n# . . G\n"


def test_rgb_array_gives_every_kind_of_tile_its_colour():
    maze = Maze(WIDE, render_mode="rgb_array")
    maze.reset(seed=0)
    maze.step(RIGHT)
    picture = maze.render()
    assert (picture.shape, picture.dtype) == ((96, 160, 3), np.uint8)
    cells = picture.reshape(3, 32, 5, 32, 3).swapaxes(1, 2)
    colours = cells[:, :, 0, 0]
    assert (cells == colours[:, :, None, None]).all(), "a cell has one colour"
    kinds = maze.grid.copy()
    kinds[0, 2] = Tile.OCCUPIED
    colour_of = {int(kind): {tuple(c) for c in colours[kinds == kind].tolist()} for kind in np.unique(kinds)}
    assert all(len(found) == 1 for found in colour_of.values())
    assert len(set.union(*colour_of.values())) == 5


def test_without_a_render_mode_nothing_is_drawn_and_a_warning_says_so():
    with pytest.warns(UserWarning, match="render_mode"):
        assert Maze().render() is None
