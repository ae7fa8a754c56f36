"""Sketch, board and chart: what is drawn stands where it should, can be read, and holds nothing that could break it."""

import re
import xml.etree.ElementTree as ElementTree
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from course_lib import Action, Maze, value_iteration
from course_lib.explore import BellmanByHand, Transitions
from course_lib.explore.drawing.board import Board, place
from course_lib.explore.drawing.chart import Chart, log_ticks, ticks
from course_lib.explore.drawing.sketch import WIDTH, Sketch, shade, shades
from course_lib.plots.board import acting_states

NAMESPACE = "{http://www.w3.org/2000/svg}"
MAZES = [Maze(), Maze.random(3, 7, seed=1), Maze.random(9, 2, seed=0), Maze.random(30, 30, seed=2)]
each_maze = pytest.mark.parametrize("world", MAZES, ids=lambda world: f"{world.rows}x{world.columns}")


def elements(svg, kind):
    return list(ElementTree.fromstring(svg).iter(NAMESPACE + kind))


def texts(svg):
    return [(node.text, node) for node in elements(svg, "text")]


def luminance(colour):
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return float(np.dot((0.2126, 0.7152, 0.0722), linear))


@pytest.mark.parametrize("name", ["viridis", "PuOr"])
def test_numbers_on_every_shade_can_be_read(name):
    assert len(shades(name)) == 256
    for colour, ink in shades(name):
        light, dark = sorted((luminance(colour), luminance(ink)), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 4.5, colour


def test_shades_run_from_low_to_high_and_stop_there():
    assert shade(-5, 0, 1) == shade(0, 0, 1) == shades()[0]
    assert shade(7, 0, 1) == shade(1, 0, 1) == shades()[-1]
    assert shade(3, 3, 3) == shades()[127], "all alike: the middle, and no division by zero"


def test_text_is_escaped_and_the_picture_is_sound():
    sketch = Sketch(50)
    sketch.text(10, 10, "a < b & 'c'")
    sketch.rect(1.23456, 2.0, 3, 4, fill="red", stroke_width=2)
    svg = sketch.svg()
    assert texts(svg)[0][0] == "a < b & 'c'"
    assert 'x="1.23" y="2" width="3" height="4" fill="red" stroke-width="2"' in svg
    assert ElementTree.fromstring(svg).get("viewBox") == f"0 0 {WIDTH} 50"


@given(st.floats(-1e3, 1e3), st.floats(1e-2, 1e6))
def test_ticks_are_few_round_and_inside(low, length):
    high = low + length
    found = ticks(low, high)
    assert 1 <= len(found) <= 8
    assert all(low - 1e-6 * length <= tick <= high + 1e-6 * length for tick in found)
    if len(found) > 2:
        steps = np.diff(found)
        assert np.allclose(steps, steps[0], rtol=1e-6)
        mantissa = steps[0] / 10 ** np.floor(np.log10(steps[0]) + 1e-9)
        assert min(abs(mantissa - round_step) for round_step in (1, 2, 5, 10)) < 1e-6


def test_ticks_of_nothing_are_one():
    assert ticks(3, 3) == [3]
    assert ticks(0, 1) == [0, 0.2, 0.4, 0.6, 0.8, 1.0]


@given(st.floats(1e-6, 1e3), st.floats(1.5, 1e6))
def test_log_ticks_are_inside_and_grow(low, factor):
    found = log_ticks(low, low * factor)
    assert found == sorted(set(found))
    assert all(low * 0.998 <= tick <= low * factor * 1.002 for tick in found)
    assert len(found) <= 13


@each_maze
def test_every_cell_of_a_board_is_known_by_its_number_and_stands_in_its_place(world):
    board = Board(world, "Title")
    board.tiles()
    cells = {int(node.get("data-cell")): node for node in elements(board.svg(), "rect") if node.get("data-cell")}
    assert sorted(cells) == list(range(world.grid.size))
    height = float(ElementTree.fromstring(board.svg()).get("viewBox").split()[-1])
    for state, node in cells.items():
        x, y = (float(node.get(side)) + float(node.get("width")) / 2 for side in "xy")
        assert (x, y) == pytest.approx(board.middle(state), abs=0.02)
        assert 0 < x < WIDTH
        assert 0 < y < height
    right, below = board.middle(1)[0] - board.middle(0)[0], board.middle(world.columns)[1] - board.middle(0)[1]
    assert right == pytest.approx(below), "cells are squares"
    assert (right, below) > (0, 0)


@each_maze
def test_boards_are_sound_with_everything_drawn_on_them(world):
    solution = value_iteration(world.mdp, 0.9)
    board = Board(world, "Title <&>")
    board.values(solution.values, 0, 1)
    board.wedges(solution.q, 0, 1)
    board.walls()
    board.arrows(solution.q)
    board.frame(world.start)
    board.mouse(world.start)
    board.cheese()
    board.note(world.start, "start")
    ElementTree.fromstring(board.svg())
    assert "nan" not in board.svg()


def test_values_show_the_numbers_and_arrows_the_best_actions():
    world = Maze()
    solution = value_iteration(world.mdp, 0.9)
    board = Board(world, "")
    board.values(solution.values, 0, 1)
    written = [text for text, _ in texts(board.svg())]
    for value in ("0.59", "0.656", "0.729", "0.81", "0.9", "1"):
        assert value in written
    before = len(elements(board.svg(), "polygon"))
    board.arrows(np.zeros((16, 4)))
    assert len(elements(board.svg(), "polygon")) == before, "nothing is known, so no arrows"
    board.arrows(solution.q)
    ways = sum(int((row >= row.max() - 1e-9).sum()) for s, row in enumerate(solution.q) if world.grid.flat[s] in (0, 3))
    assert len(elements(board.svg(), "polygon")) - before == ways


@pytest.mark.parametrize("action", Action)
def test_arrows_point_the_way_the_action_moves(action):
    board = Board(Maze(), "")
    board.arrow(5, action)
    corners = [tuple(map(float, pair.split(","))) for pair in elements(board.svg(), "polygon")[0].get("points").split()]
    tip = corners[3]
    away = np.subtract(tip, board.middle(5))
    expected = {Action.UP: (0, -1), Action.DOWN: (0, 1), Action.LEFT: (-1, 0), Action.RIGHT: (1, 0)}[action]
    assert np.sign(np.round(away)).tolist() == list(expected)


def test_a_wedge_lies_on_the_side_that_its_action_leads_to():
    board = Board(Maze(), "")
    q = np.zeros((16, 4))
    q[5, Action.DOWN] = 0.7
    board.wedges(q, 0, 1)
    x, y = next((float(n.get("x")), float(n.get("y"))) for text, n in texts(board.svg()) if text == "0.70")
    assert x == pytest.approx(board.middle(5)[0], abs=1)
    assert y > board.middle(5)[1] + 10


def test_a_place_is_told_in_words():
    assert place(Maze(), 7) == "cell 7 (row 1, column 3)"


def test_a_chart_puts_numbers_where_they_belong():
    chart = Chart("Title", x=(0, 10), y=(0, 4), xlabel="x", ylabel="y")
    chart.line([0, 10], [0, 4])
    line = next(node for node in elements(chart.svg(), "polyline") if node.get("stroke-width") == "2")
    (left, bottom), (right, top) = (map(float, pair.split(",")) for pair in line.get("points").split())
    assert (left, bottom) == (pytest.approx(float(chart.across(0))), pytest.approx(chart.bottom))
    assert (right, top) == (pytest.approx(chart.right), pytest.approx(chart.top))
    assert float(chart.up(99)) == chart.top, "what is too high stands at the edge"
    assert float(chart.up(2)) == pytest.approx((chart.top + chart.bottom) / 2)


def test_a_log_axis_gives_equal_room_to_equal_factors():
    chart = Chart("Title", x=(0, 1), y=(1, 100), xlabel="x", ylabel="y", log=True)
    assert float(chart.up(10)) == pytest.approx((chart.top + chart.bottom) / 2)


def test_lines_are_told_apart_without_colour():
    chart = Chart("Title", x=(0, 1), y=(0, 1), xlabel="x", ylabel="y", legend=3)
    for which in range(3):
        chart.line([0, 1], [0, 1], which)
        chart.legend(f"line {which}", which)
    dashes = [
        node.get("stroke-dasharray") for node in elements(chart.svg(), "polyline") if node.get("stroke-width") == "2"
    ]
    assert len(set(dashes)) == 3


def boxes(svg):
    """[(text, left, top, right, bottom)], a little tighter than any font draws it."""
    for text, node in texts(svg):
        x, y, size = (float(node.get(name)) for name in ("x", "y", "font-size"))
        wide, share = 0.54 * size * len(text), {"start": 0, "middle": 0.5, "end": 1}[node.get("text-anchor")]
        yield text, x - share * wide, y - 0.36 * size, x + (1 - share) * wide, y + 0.36 * size


@pytest.mark.parametrize("side", range(4, 9))
def test_no_text_lies_on_another(side):
    world = Maze.random(side, side, seed=3, slip=0.25, wall_ends_episode=False)
    for explored in (Transitions(world), BellmanByHand(world)):
        if isinstance(explored, BellmanByHand):
            explored.press("solve")
        found = list(boxes(explored.view().panels[0].svg))
        for (one, *here), (other, *there) in combinations(found, 2):
            apart = here[2] <= there[0] or there[2] <= here[0] or here[3] <= there[1] or there[3] <= here[1]
            assert apart or one == other, (one, other)  # the chosen cell's number lies on a slip of paper, on itself


def arrows(svg):
    """The corners of every arrow, float64[7, 2]."""
    drawn = [node for node in elements(svg, "polygon") if node.get("stroke-width") == "0.9"]
    return [np.array([pair.split(",") for pair in node.get("points").split()], float) for node in drawn]


@pytest.mark.parametrize("slip", [0.0, 0.25])
@pytest.mark.parametrize("side", range(3, 9))
def test_no_arrow_touches_a_number(side, slip):
    world = Maze.random(side, side, seed=1, slip=slip, wall_ends_episode=False)
    by_hand = BellmanByHand(world)
    by_hand.press("solve")
    shown = [by_hand.view().panels[0].svg]
    for cell in (world.start, acting_states(world)[-1]):
        for action in Action:
            state = Transitions(world)
            state.choose(cell)
            state.turn("action", int(action))
            shown.append(state.view().panels[0].svg)
    for svg in shown:
        assert arrows(svg)
        for text, node in texts(svg):
            size, line = float(node.get("font-size")), float(node.get("y"))
            wide, middle = 0.54 * size * len(text) / 2, float(node.get("x"))
            for corners in arrows(svg) if node.get("text-anchor") == "middle" else ():
                (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
                beside = right < middle - wide or left > middle + wide
                assert beside or bottom + 0.45 < line - 0.73 * size or top - 0.45 > line, text


def test_text_is_large_enough_to_be_read():
    chart = Chart("Title", x=(0, 1), y=(0, 1), xlabel="x", ylabel="y", legend=1)
    chart.legend("line", 0)
    board = Board(Maze(), "Title")
    board.tiles()
    for svg in (chart.svg(), board.svg()):
        assert min(float(size) for size in re.findall(r'font-size="([^"]+)"', svg)) >= 11
