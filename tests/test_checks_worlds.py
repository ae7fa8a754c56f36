"""The maze between judge and learner: the record on one side, and what a mouse may know on the other."""

import copy
import pickle
from itertools import count

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from course_lib import Action, Maze, QAgent
from course_lib.checks.worlds import EnoughSteps, Watched, World

UP, DOWN, LEFT, RIGHT = range(4)
WIDE = [[0, 3, 0, 0, 0], [0, 1, 0, 1, 0], [0, 0, 0, 4, 0]]


def watched(grid=WIDE, **limits):
    return Watched(Maze(grid, wall_ends_episode=False), **limits)


def world_of(watched):
    return World(watched.rows, watched.columns, watched.answer)


def test_the_record_holds_every_reset_step_and_bump():
    judge = watched()
    mouse = world_of(judge)
    assert mouse.reset() == (1, {"bumped": False})
    assert mouse.step(DOWN) == (1, -1.0, False, False, {"bumped": True})
    assert mouse.step(Action.RIGHT) == (2, 0.0, False, False, {"bumped": False})
    mouse.reset()
    mouse.step(UP)
    first, second = judge.episodes
    assert (first.states, first.actions, first.rewards, first.bumps) == (
        [1, 1, 2],
        [DOWN, RIGHT],
        [-1.0, 0.0],
        [True, False],
    )
    assert list(first.steps()) == [(0, 1, DOWN, -1.0, 1, True), (1, 1, RIGHT, 0.0, 2, False)]
    assert (len(first), len(second), judge.steps) == (2, 1, 3)
    assert (first.began, second.began) == (0, 3)
    assert not first.over


def test_it_plays_by_the_rules_of_the_maze():
    maze, judge = Maze.random(5, 6, wall_ends_episode=False, seed=3), None
    judge = Watched(Maze.random(5, 6, wall_ends_episode=False, seed=3))
    assert judge.reset() == maze.reset()
    for action in np.random.default_rng(0).integers(4, size=200):
        answer = maze.step(action)
        assert judge.step(action) == answer
        if answer[2]:
            assert judge.reset() == maze.reset()


def test_the_cheese_terminates_and_a_deadly_bump_is_no_arrival():
    judge = watched()
    judge.reset()
    for action in (RIGHT, DOWN, DOWN, RIGHT):
        *_, terminated, truncated, _ = judge.step(action)
    assert (terminated, truncated) == (True, False)
    assert judge.episodes[0].reached_the_cheese
    strict = Watched(Maze(WIDE))
    strict.reset()
    strict.step(DOWN)
    assert strict.episodes[0].terminated
    assert not strict.episodes[0].reached_the_cheese


def test_the_clock_truncates_and_does_not_terminate():
    judge = watched(time_limit=3)
    judge.reset()
    assert [judge.step(UP)[2:4] for _ in range(3)] == [(False, False), (False, False), (False, True)]
    assert judge.episodes[0].truncated
    judge.reset()
    assert judge.step(UP)[2:4] == (False, False), "the clock begins anew"


def test_a_cheese_at_the_last_moment_counts():
    judge = watched(time_limit=4)
    judge.reset()
    for action in (RIGHT, DOWN, DOWN, RIGHT):
        *_, terminated, truncated, _ = judge.step(action)
    assert (terminated, truncated) == (True, False)


@pytest.mark.parametrize(("limits", "ended"), [({"time_limit": 1}, "truncated"), ({}, "terminated")])
def test_no_step_follows_the_end_but_it_is_remembered(limits, ended):
    judge = watched([[3, 4, 0]], **limits)
    judge.reset()
    judge.step(LEFT if limits else RIGHT)
    for _ in range(2):
        with pytest.raises(ValueError, match=f"over .{ended}"):
            judge.step(RIGHT)
    assert judge.stepped_after == ended
    assert judge.steps == 1
    judge.reset()
    judge.step(UP)
    assert judge.stepped_after == ended


def test_no_step_comes_before_the_first_reset():
    with pytest.raises(ValueError, match="not in the maze yet"):
        watched().step(UP)


@pytest.mark.parametrize("action", [-1, 4, 1.0, "UP", None, True, [1], np.array([1, 2]), Action, 10**500, float("nan")])
def test_a_strange_action_is_refused_and_not_recorded(action):
    judge = watched()
    judge.reset()
    if action is True:  # Python's own number 1
        judge.step(action)
        assert judge.episodes[0].actions == [1]
        return
    with pytest.raises(ValueError, match="an action is 0, 1, 2 or 3, got"):
        judge.step(action)
    assert (judge.steps, len(judge.episodes[0])) == (0, 0)


@pytest.mark.parametrize("action", [2, np.int64(2), np.uint8(2), Action.LEFT])
def test_an_action_may_be_any_whole_number(action):
    judge = watched()
    judge.reset()
    assert judge.step(action)[0] == 0
    assert type(judge.episodes[0].actions[0]) is int


def test_steps_and_resets_have_a_limit_that_except_exception_lets_pass():
    judge = watched(max_steps=5)
    judge.reset()
    for _ in range(5):
        judge.step(UP)
    assert judge.exhausted
    with pytest.raises(EnoughSteps):
        judge.step(UP)
    assert not issubclass(EnoughSteps, Exception)
    judge = watched(max_steps=5)
    for _ in range(5):
        judge.reset()
    with pytest.raises(EnoughSteps):
        judge.reset()
    assert judge.exhausted


def test_a_loop_that_lets_every_error_pass_comes_to_an_end():
    judge = watched()
    for _ in range(1000):
        with pytest.raises(ValueError, match="an action is"):
            judge.step("up")
    with pytest.raises(EnoughSteps):
        judge.step("up")


def test_resets_without_a_step_are_no_episodes_that_were_played():
    judge = watched()
    judge.reset()
    judge.reset()
    judge.step(UP)
    judge.reset()
    assert judge.played == [judge.episodes[1]]


def test_worlds_that_share_a_clock_know_what_came_first():
    clock = count()
    one, other = watched(clock=clock), watched(clock=clock)
    one.reset()
    one.step(UP)
    other.reset()
    one.reset()
    assert (one.episodes[0].began, other.episodes[0].began, one.episodes[1].began) == (0, 2, 3)


def test_a_world_asks_for_nothing_but_reset_and_step():
    judge = watched()
    for name in ("maze", "answer", "__class__", "episodes"):
        with pytest.raises(ValueError, match="a maze has no"):
            judge.answer(name)


# --- the learner's side -----------------------------------------------------------------------------------------------


def test_a_world_counts_its_cells_as_the_maze_does():
    world, maze = world_of(watched()), Maze(WIDE)
    assert (world.rows, world.columns) == (maze.rows, maze.columns)
    assert (world.observation_space, world.action_space) == (maze.observation_space, maze.action_space)
    for state in range(15):
        assert world.cell(state) == maze.cell(state)
        assert world.state(*maze.cell(state)) == state


@pytest.mark.parametrize("cell", [(-1, 0), (0, -1), (3, 0), (0, 5), (0.5, 0), ("0", 0)])
def test_a_cell_that_is_not_there_raises_what_the_maze_raises(cell):
    for place in (world_of(watched()), Maze(WIDE)):
        with pytest.raises(ValueError, match="must be"):
            place.state(*cell)
    for state in (-1, 15, 1.5):
        with pytest.raises(ValueError, match="must be"):
            world_of(watched()).cell(state)


@pytest.mark.parametrize("name", ["grid", "start", "goals", "mdp", "_state", "slip"])
def test_a_mouse_has_no_map(name):
    with pytest.raises(AttributeError):
        getattr(world_of(watched()), name)


def test_asking_for_the_map_is_answered_in_words():
    with pytest.raises(AttributeError, match="this maze shows no 'grid': a mouse has no map"):
        world_of(watched()).grid  # noqa: B018
    with pytest.raises(AttributeError, match="a maze has no 'cheese'"):
        world_of(watched()).cheese  # noqa: B018


def test_there_is_one_mouse_in_one_place():
    world = world_of(watched())
    for way in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="cannot be copied"):
            way(world)


@pytest.mark.filterwarnings("error")
def test_gymnasium_finds_no_fault_with_it():
    check_env(world_of(watched(time_limit=10_000)), skip_render_check=True)


def test_the_courses_own_agent_can_train_in_it():
    judge = watched()
    agent = QAgent(world_of(judge), seed=0)
    history = agent.train(30)
    assert len(judge.played) == 30
    assert history.episode_length.tolist() == [len(episode) for episode in judge.played]
    assert agent.test(100).terminated


def test_wrappers_of_gymnasium_work_around_it():
    world = gymnasium.wrappers.TimeLimit(world_of(watched()), 2)
    world.reset(seed=3)
    assert [world.step(UP)[3] for _ in range(2)] == [False, True]
