"""Be the mouse: what is felt, what is seen of the maze, and which walks are kept."""

import json

import numpy as np
import pytest

from course_lib import Action, Maze
from course_lib.explore.mouse import KEPT_IN, BlindMaze, kept_walks

BEST = ["right", "right", "right", "down", "down", "down"]


def walked(moves, **settings):
    mouse = BlindMaze(**settings)
    for move in moves:
        mouse.press(move)
    return mouse


def panel(mouse, name):
    return next(panel for panel in mouse.view().panels if panel.name == name)


def test_the_shortest_walk_pays_one_and_leads_back_to_the_start():
    mouse = walked(BEST)
    assert (mouse.returns, mouse.lengths) == ([1.0], [6])
    assert (mouse.cell, mouse.moves, mouse.reward) == (0, 0, 0.0)
    assert "cheese! (+1)" in mouse.message
    assert "Walk 1: 6 moves, reward +1" in mouse.message


def test_a_bump_costs_one_and_the_walk_goes_on():
    mouse = walked(["down", "right", "right"])
    assert (mouse.cell, mouse.reward, mouse.returns) == (5, -1.0, [])
    assert "ouch, a wall (−1)" in mouse.message
    assert walked(["up"]).message.startswith("Move 1, up: the edge of the maze")
    assert walked(["up", "up"]).message != walked(["up"]).message, "what is said again is not heard"


def test_it_is_the_maze_step_by_step():
    rng = np.random.default_rng(3)
    world = Maze.random(5, 4, seed=2, wall_ends_episode=False, step_reward=-0.1)
    mouse, there = BlindMaze(world), Maze.random(5, 4, seed=2, wall_ends_episode=False, step_reward=-0.1)
    state, total, moves = there.reset()[0], 0.0, 0
    for _ in range(400):
        action = Action(int(rng.integers(4)))
        state, reward, terminated, _, _ = there.step(action)
        total, moves = total + reward, moves + 1
        mouse.arrow(action)
        if terminated:
            assert (mouse.returns[-1], mouse.lengths[-1]) == (pytest.approx(total), moves)
            state, total, moves = there.reset()[0], 0.0, 0
        assert (mouse.cell, mouse.moves, mouse.reward) == (state, moves, pytest.approx(total))
    assert len(mouse.returns) > 1


def test_a_strict_maze_ends_the_walk_at_a_wall():
    mouse = walked(["down", "right", "right"], maze=Maze())
    assert (mouse.returns, mouse.cell) == ([-1.0], 0)
    assert "The walk is over" in mouse.message


def test_only_what_was_felt_is_seen():
    mouse = BlindMaze()
    assert np.flatnonzero(mouse.seen).tolist() == [0]
    drawn = panel(mouse, "map").svg
    assert "slanted)" not in drawn
    assert "polygon" not in drawn, "the cheese is not shown before it was found"
    assert drawn.count(">?<") == 15
    for move in ("down", "right", "right"):
        mouse.press(move)
    assert np.flatnonzero(mouse.seen).tolist() == [0, 4, 5, 6]
    drawn = panel(mouse, "map")
    assert drawn.svg.count("url(#slanted)") == 1
    assert drawn.svg.count(">?<") == 12
    assert "Known floor: cells 0, 4, 5. Known walls: 6." in drawn.words
    assert "polygon" in panel(walked(BEST), "map").svg


def test_who_slips_does_not_see_the_wall_ahead():
    """It is not known whether the wall was ahead or at the side."""
    mouse = BlindMaze(Maze(wall_ends_episode=False, slip=0.5))
    for move in ["down", "right", "right", "down"] * 30:
        mouse.press(move)
    assert sum(mouse.returns) + mouse.reward < len(mouse.returns), "it did bump"
    assert not mouse.seen[mouse.maze.grid.ravel() == 1].any()


def test_a_click_moves_to_the_next_cell_only():
    mouse = BlindMaze()
    mouse.choose(1)
    assert (mouse.cell, mouse.moves) == (1, 1)
    mouse.choose(1)
    assert (mouse.cell, mouse.moves, mouse.message) == (1, 1, "You are in cell 1. Now the arrow keys work.")
    for far in (3, 4, 15):
        mouse.choose(far)
        assert (mouse.cell, mouse.moves) == (1, 1)
        assert "no single move" in mouse.message


def test_the_curve_shows_every_walk_in_words_and_as_a_point():
    mouse = walked([*BEST, "up", *BEST])
    curve = panel(mouse, "curve")
    assert "walk 1: 6 moves, reward +1; walk 2: 7 moves, reward +1." in curve.words
    assert curve.svg.count("<circle") - 1 - 1 == 2, "beside that of the legend, and that of the hatching"
    assert ">+1<" in curve.svg
    assert "No walk is finished yet" in panel(BlindMaze(), "curve").words


def test_forgetting_begins_anew():
    mouse = walked([*BEST, "right", "forget"])
    fresh = BlindMaze()
    assert mouse.view() == fresh.view()
    assert mouse.view().control("forget").idle
    assert not walked(["up"]).view().control("forget").idle


def test_walks_are_kept_for_lesson_3(tmp_path):
    path = tmp_path / KEPT_IN
    assert kept_walks(path) is None
    walked(["right"], keep=path)
    assert not path.exists(), "no walk is finished"
    walked([*BEST, "up", *BEST], keep=path)
    returns, lengths = kept_walks(path)
    assert returns.tolist() == [1.0, 1.0]
    assert lengths.tolist() == [6, 7]


@pytest.mark.parametrize(
    "content",
    ["", "[]", "null", "{}", '{"returns": [1], "lengths": []}', '{"returns": [], "lengths": []}',
     '{"returns": ["a"], "lengths": [3]}', '{"returns": [NaN], "lengths": [3]}', '{"returns": [1], "lengths": [0]}',
     '{"returns": [1], "lengths": [2.5]}', '{"returns": 1, "lengths": 1}', "\xff"],
)  # fmt: skip
def test_a_foreign_file_is_no_walk(tmp_path, content):
    path = tmp_path / KEPT_IN
    path.write_text(content, encoding="latin-1")
    assert kept_walks(path) is None


def test_walks_that_cannot_be_kept_are_said_and_cost_nothing(tmp_path):
    mouse = walked(BEST, keep=tmp_path / "nowhere" / KEPT_IN)
    assert mouse.returns == [1.0]
    assert "could not be kept" in mouse.message


def test_the_file_is_plain_json(tmp_path):
    path = tmp_path / KEPT_IN
    walked(BEST, keep=path)
    assert json.loads(path.read_text()) == {"returns": [1.0], "lengths": [6]}


def test_running_the_cell_again_forgets_no_walk(tmp_path):
    path = tmp_path / KEPT_IN
    walked([*BEST, "up", *BEST], keep=path)
    walked(["down", "up", *BEST], keep=path)
    assert kept_walks(path)[1].tolist() == [6, 7, 8]
    walked(["forget", *BEST], keep=path)
    assert kept_walks(path)[1].tolist() == [6], "until everything is forgotten"


def test_two_mice_in_one_maze_do_not_meet():
    maze = Maze(wall_ends_episode=False)
    one, other = BlindMaze(maze), BlindMaze(maze)
    one.press("down")
    other.press("right")
    assert (one.cell, other.cell) == (4, 1)


@pytest.mark.parametrize("cell", [16, -1, "5", 1.5])
def test_what_is_no_cell_is_refused(cell):
    with pytest.raises(ValueError, match="cell must be"):
        BlindMaze().choose(cell)


def test_unknown_buttons_are_refused():
    mouse = BlindMaze()
    with pytest.raises(ValueError, match=r"up, down, left, right and forget, got 'jump'"):
        mouse.press("jump")
    assert mouse.moves == 0


@pytest.mark.parametrize("world", ["maze", 4, Maze.random(21, 3)])
def test_other_worlds_are_refused(world):
    with pytest.raises(ValueError, match=r"a Maze is needed|at most 20 rows"):
        BlindMaze(world)
