"""The checks of homework 1: what they read from a walk, and that no mouse, however odd, confuses them."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib import Action, Maze, Tile
from course_lib.checks import homework_1
from course_lib.checks.check import NotYet
from course_lib.checks.homework_1 import learning, mazes, task_3
from course_lib.checks.homework_1.memory import Choices, NeedlessReturn, needless_returns, open_fresh_actions
from course_lib.checks.homework_1.training import Training
from course_lib.checks.homework_1.walks import check_arrived, check_one_whole_episode
from course_lib.checks.learner import Returned
from course_lib.checks.plain import plain
from course_lib.checks.worlds import Watched, World

CHECKS = [getattr(homework_1, name) for name in homework_1.__all__]
RIGHT = Path(__file__).with_name("answers") / "homework_1" / "right"
REFERENCE = runpy.run_path(str(RIGHT / "from_the_lesson.py"))
UP, DOWN, LEFT, RIGHTWARDS = range(4)

seeds = st.integers(0, 2**32 - 1)


def random_maze(rng):
    rows, columns = (int(n) for n in rng.integers(2, 7, 2))
    return Maze.random(
        rows, columns, walls=float(rng.uniform(0, 0.5)), seed=int(rng.integers(1000)), wall_ends_episode=False
    )


def watched_walk(maze, actions):
    """A watched world in which these actions were taken, up to the end of the episode."""
    world = Watched(maze)
    world.reset()
    for action in actions:
        if not world.episodes[0].over:
            world.step(action)
    return world


def world_of(watched):
    return World(watched.rows, watched.columns, watched.answer)


# --- what a walk shows ------------------------------------------------------------------------------------------------


def fresh_cells_beside(maze, cell, been):
    """The definition, read again: cells of the maze beside this one, no walls, in which the mouse has not been."""
    row, column = cell
    beside = [(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]
    inside = [(r, c) for r, c in beside if 0 <= r < maze.rows and 0 <= c < maze.columns]
    return [cell for cell in inside if maze.grid[cell] != Tile.WALL and cell not in been]


@settings(derandomize=True, deadline=None, max_examples=200)
@given(seeds)
def test_needless_returns_are_what_their_definition_says(seed):
    rng = np.random.default_rng(seed)
    maze = random_maze(rng)
    episode = watched_walk(maze, rng.integers(4, size=40)).episodes[0]
    cells = [maze.cell(state) for state in episode.states]
    returns, choices, dead_ends = [], [], []
    for t in range(len(episode)):
        been = cells[: t + 1]
        fresh = fresh_cells_beside(maze, cells[t], been)
        assert len(open_fresh_actions(maze, episode, t)) == len(fresh)
        if not fresh:
            dead_ends.append(t)
            continue
        choices.append(t)
        if cells[t + 1] in been and not episode.bumps[t]:
            returns.append(t)
    assert needless_returns(maze, episode) == (returns, choices, dead_ends[0] if dead_ends else None)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds)
def test_choices_add_up(seed):
    rng = np.random.default_rng(seed)
    total, number = Choices(None, []), 0
    for _ in range(3):
        maze = random_maze(rng)
        episodes = watched_walk(maze, rng.integers(4, size=30)).episodes
        total.add(Choices(maze, episodes))
        number += len(needless_returns(maze, episodes[0])[1])
        before = Choices(maze, episodes, only_before_dead_ends=True)
        assert {step.t for step in before.returns} <= {step.t for step in Choices(maze, episodes).returns}
    assert total.number == number
    assert 0 <= total.share <= 1
    if total.returns:
        with pytest.raises(NotYet, match=f"step {total.returns[0].t + 1}: {total.returns[0].action.name} from row"):
            total.say()
    else:
        total.say()


def needless(here, there, before=9, start=0):
    return NeedlessReturn(Maze([[3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4]]), 3, here, there, before, start, Action.LEFT)


@pytest.mark.parametrize(
    ("returns", "number", "words"),
    [
        ([needless(5, 5)] * 3, 10, "beyond the edge"),
        ([needless(5, 5)], 10, "only a few steps ignore the memory"),
        ([needless(1, 0)] * 3, 10, "the start is missing from your mouse's memory: "),
        ([needless(1, 0)] * 2, 10, "the start is missing from your mouse's memory, or the random step"),
        ([needless(1, 0), needless(5, 5), needless(3, 4)], 100, "only a few steps ignore the memory"),
        ([needless(1, 0), needless(5, 5), needless(3, 4)], 10, "no memory of the cells it came through"),
        ([needless(1, 0), needless(3, 4)] * 3, 100, "remembers the last cells only"),
        ([needless(1, 0), needless(3, 4), needless(3, 9)] * 3, 10, "no memory of the cells it came through"),
    ],
)
def test_needless_returns_are_explained_by_all_of_them(returns, number, words):
    choices = Choices(None, [])
    choices.returns, choices.number = returns, number
    with pytest.raises(NotYet) as finding:
        choices.say()
    assert words in finding.value.likely
    with pytest.raises(NotYet) as finding:
        choices.say("another cause.")
    assert finding.value.likely == "another cause."


def test_one_walk_that_ends_at_its_first_bump_may_do_so_by_chance():
    grid = [[3, 0, 0, 1], [0, 0, 0, 4]]
    at_bump, elsewhere = (watched_walk(Maze(grid, wall_ends_episode=False), [RIGHTWARDS] * steps) for steps in (3, 2))
    with pytest.raises(NotYet, match="after a bump"):
        check_one_whole_episode(at_bump)
    with pytest.raises(NotYet) as finding:
        check_one_whole_episode(at_bump, elsewhere)
    assert "stops before the world says" in finding.value.likely


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((3, 3), None),
        ((3.0, 3), None),
        ((None, None), "ends without `return`"),
        ((2, 2), "the index of the last step"),
        ((2, 1), "something else than the number"),
        ((True, True), "something else than the number"),
        (("3", "3"), "something else than the number"),
    ],
)
def test_what_a_mouse_counted_is_explained_by_all_its_walks(values, words):
    worlds = [watched_walk(Maze([[3, 0, 0, 4]], wall_ends_episode=False), [RIGHTWARDS] * 3) for _ in values]
    played = [(world, Returned(value, ())) for world, value in zip(worlds, values, strict=True)]
    if words is None:
        learning.check_steps(played)
        return
    with pytest.raises(NotYet) as finding:
        learning.check_steps(played)
    assert words in finding.value.likely


def test_true_is_no_number_of_steps():
    world = watched_walk(Maze([[3, 4]], wall_ends_episode=False), [RIGHTWARDS])
    with pytest.raises(NotYet, match="True after 1 steps"):
        learning.check_steps([(world, Returned(True, ()))])


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.integers(2, 7), seeds)
def test_the_reference_mouse_gets_through_any_labyrinth_without_a_needless_return(rooms, seed):
    maze = mazes.labyrinth(rooms, seed)
    world = Watched(maze)
    table = mazes.random_table(maze, seed)
    before = table.copy()
    steps = REFERENCE["play_remembering"](world_of(world), table, np.random.default_rng(seed))
    check_arrived(world)
    assert not Choices(maze, world.episodes).returns
    assert steps == world.steps
    np.testing.assert_allclose(learning.learned(before, maze, world.episodes), table, atol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(seeds)
def test_the_reference_mouse_never_bumps_twice_and_ends_where_the_world_ends(seed):
    rng = np.random.default_rng(seed)
    maze = random_maze(rng)
    world = Watched(maze)
    REFERENCE["play_on"](world_of(world), mazes.random_table(maze, seed), rng)
    check_one_whole_episode(world)
    bumps = [(state, action) for _, state, action, _, _, bumped in world.episodes[0].steps() if bumped]
    assert len(bumps) == len(set(bumps))


# --- what a walk teaches ----------------------------------------------------------------------------------------------


def test_each_mistaken_rule_teaches_something_else():
    maze = Maze([[3, 0, 1], [1, 0, 0], [0, 0, 4]], wall_ends_episode=False)
    # A bump, an edge, a dead end and the way back, another bump, the cheese.
    world = watched_walk(
        maze, [DOWN, UP, RIGHTWARDS, RIGHTWARDS, DOWN, DOWN, LEFT, UP, RIGHTWARDS, UP, RIGHTWARDS, DOWN]
    )
    assert world.episodes[0].reached_the_cheese
    before = mazes.random_table(maze, 0)
    tables = {rule: learning.learned(before, maze, world.episodes, rule) for rule in learning._LEARNED_INSTEAD}
    tables["Q-learning"] = learning.learned(before, maze, world.episodes)
    for rule, table in tables.items():
        for other in tables:
            assert rule == other or not learning.same(table, tables[other]), (rule, other)


def test_what_should_be_learned_is_learned_by_the_update_of_lesson_3():
    maze = mazes.bumpy_mazes(1)[2]
    world = watched_walk(maze, np.random.default_rng(0).integers(4, size=300))
    table = mazes.random_table(maze, 0)
    expected = learning.learned(table, maze, world.episodes)
    for t, state, action, reward, next_state, _ in world.episodes[0].steps():
        terminated = world.episodes[0].terminated and t == len(world.episodes[0]) - 1
        REFERENCE["update"](table, state, action, reward, next_state, terminated)
    np.testing.assert_allclose(expected, table, atol=1e-12)


# --- mazes made for the purpose ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_a_labyrinth_has_one_way_between_any_two_cells(seed):
    maze = mazes.labyrinth(4, seed)
    open_cells = {maze.cell(int(state)) for state in np.flatnonzero(maze.grid != Tile.WALL)}
    joined = sum((r + 1, c) in open_cells for r, c in open_cells) + sum((r, c + 1) in open_cells for r, c in open_cells)
    reached, waiting = {(0, 0)}, [(0, 0)]
    while waiting:
        for cell in fresh_cells_beside(maze, waiting.pop(), reached):
            reached.add(cell)
            waiting.append(cell)
    assert reached == open_cells
    assert joined == len(open_cells) - 1, "a tree"
    assert maze.grid[-1, -1] == Tile.GOAL


@pytest.mark.parametrize("seed", range(20))
def test_a_corridor_lures_away_from_the_cheese(seed):
    maze, table = mazes.corridor(seed)
    assert 1 in (maze.rows, maze.columns)
    best = int(table[maze.start].argmax())
    there = mazes.ahead(maze, maze.start, best)
    assert abs(there - maze.goals[0]) > abs(maze.start - maze.goals[0])
    assert (table.argmax(axis=1) == best).all()


def test_corridors_lead_all_four_ways():
    assert {int(mazes.corridor(seed)[1][0].argmax()) for seed in range(40)} == {0, 1, 2, 3}


def test_a_table_that_loves_walls_wants_to_bump_wherever_it_can():
    for maze in mazes.bumpy_mazes(3):
        table = mazes.table_that_loves_walls(maze, 0)
        for state in np.flatnonzero(maze.grid != Tile.WALL):
            walls = [
                a
                for a in Action
                if (cell := mazes.ahead(maze, int(state), a)) is not None and mazes.is_wall(maze, cell)
            ]
            assert [a for a in Action if table[state, a] == 1] == walls


def test_a_map_shows_the_mouse():
    maze = Maze([[3, 1], [0, 4]])
    assert mazes.map_of(maze).startswith("S #\n. G\nS start, G cheese, # wall\n")
    assert mazes.map_of(maze, 2).startswith("S #\nM G\nS start, G cheese, # wall, M the mouse\n")
    assert mazes.place(maze, 2) == "row 1, column 0"


@pytest.mark.parametrize("seed", range(5))
def test_another_seed_means_other_mazes(seed):
    first, second = (
        [maze.grid.tobytes() for maze in mazes.bumpy_mazes(seed + i)[1:]]
        + [mazes.labyrinth(5, seed + i).grid.tobytes()]
        for i in (0, 1)
    )
    assert all(one != other for one, other in zip(first, second, strict=True))


# --- odd mice ---------------------------------------------------------------------------------------------------------


def chaos(seed):
    """A function that does anything: resets, steps and errors at random, breaks its arguments, returns something."""
    rng = np.random.default_rng(seed)

    def play(*arguments):
        worlds = [argument for argument in arguments if isinstance(argument, World)]
        table = next((argument for argument in arguments if isinstance(argument, np.ndarray)), np.zeros((2, 2)))
        for _ in range(rng.integers(60)):
            world = worlds[rng.integers(len(worlds))]
            match rng.integers(12):
                case 0 | 1:
                    world.reset()
                case 2 if rng.random() < 0.2:
                    raise [ValueError, IndexError, NotImplementedError, SystemExit, KeyError][rng.integers(5)]("chaos")
                case 3 if rng.random() < 0.2:
                    table[rng.integers(len(table))] = [np.nan, np.inf, 1e300, -5][rng.integers(4)]
                case 4 if rng.random() < 0.1:
                    table.resize((3, 5), refcheck=False)
                case _:
                    try:
                        world.step(rng.integers(4) if rng.random() < 0.99 else "up")
                    except ValueError:
                        if rng.random() < 0.5:
                            raise
        values = [None, 3, -1, 2.5, True, table, (table, 3), (3, table), [table], ((1, 2), 3), "done", (table, np.nan)]
        return values[rng.integers(len(values))]

    return play


@settings(derandomize=True, deadline=None, max_examples=60)
@given(seeds)
def test_no_mouse_confuses_a_check(seed):
    for check in CHECKS:
        verdict = check(chaos(seed), seed=seed % 5)
        assert not verdict.passed
        assert "check itself" not in repr(verdict), verdict
        verdict.html()


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)
def test_the_same_seed_gives_the_same_verdict(check):
    for seed in range(3):
        assert check(chaos(seed), seed=seed) == check(chaos(seed), seed=seed)


@pytest.mark.parametrize(
    "value",
    [
        (np.zeros((4, 4)), 2),
        ([[0.0] * 4] * 4, 2),
        [np.zeros((4, 4)), np.int64(2)],
        (np.zeros((4, 4)), 2.0),
    ],
    ids=["array", "list of lists", "in a list", "float"],
)
def test_a_table_and_a_number_in_any_form(value):
    table, number = Training(None, None, plain(value), 10).returned()
    assert table.shape == (4, 4)
    assert number == 2


def test_what_is_no_table_and_number_has_no_number():
    assert Training(None, None, None, 10).number is None


def test_a_mouse_that_tests_before_it_trains_may_be_lucky():
    grid = [[3, 0, 4]]
    exam = watched_walk(Maze(grid), [RIGHTWARDS, RIGHTWARDS])
    lucky = Training(Watched(Maze(grid, wall_ends_episode=False)), exam, (np.zeros((3, 4)), 0), 10)
    task_3._check_it_trained_and_tested(lucky)
    unlucky = Training(lucky.world, watched_walk(Maze(grid), [LEFT]), lucky.value, 10)
    with pytest.raises(NotYet, match="no episode in `maze`"):
        task_3._check_it_trained_and_tested(unlucky)


def test_a_fault_in_a_later_episode_is_a_fault_and_no_memory():
    calls = []

    def slow_from_the_third_call_on(maze, q_table, rng):
        calls.append(1)
        while len(calls) > 2:
            pass
        return REFERENCE["play_remembering"](maze, q_table, rng)

    verdict = homework_1.keeps_to_fresh_cells(slow_from_the_third_call_on, time_limit=0.3)
    assert "still running after 0.3 seconds" in verdict.rows[0].came
    assert "memory" not in verdict.rows[0].likely


def test_a_mouse_that_gives_up_after_1000_steps_as_in_lesson_3_may_do_so_in_a_large_maze_only():
    world = watched_walk(mazes.labyrinth(5, 0), [UP] * 1000)
    world.episodes[0].truncated = False  # its own limit, not the clock's
    check_arrived(world, lesson_limit_will_do=True)
    with pytest.raises(NotYet, match="no cheese after 1000 steps"):
        check_arrived(world)
