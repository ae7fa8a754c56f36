"""Pictures of networks and of many agents show the numbers that they are given, and no others."""

import numpy as np
import pytest
from test_plots import words_on_screen

from course_lib import Action, Maze, plots, value_iteration
from course_lib.plots.picture import BLUE, INK, ORANGE

NAMES = ["UP", "DOWN"]
LAYERS = [
    (np.array([[1.0, -2.0, 0.5], [0.25, 3.0, -1.0]]), np.array([0.0, 0.5, 0.0])),
    (np.array([[2.0, 0.0], [1.0, 1.0], [-4.0, 1.0]]), np.array([0.0, 0.125])),
]


def lines_between(picture, layer):
    """{(from node, to node): colour and width} of the lines that lead from one column of nodes to the next."""
    columns = {}
    for nodes in picture.figure.axes[0].collections:
        for x, y in nodes.get_offsets():
            columns.setdefault(round(x), []).append(y)
    found = {}
    for line in picture.figure.axes[0].lines:
        (x, _), (here, there) = line.get_data()
        if round(x) == layer:
            places = columns[layer].index(here), columns[layer + 1].index(there)
            found[places] = (line.get_color(), line.get_linewidth(), line.get_linestyle())
    return found


# --- one forward pass -------------------------------------------------------------------------------------------------


def test_a_forward_pass_shows_every_number_of_it():
    picture = plots.forward_pass(LAYERS, [1, 0], output_names=NAMES)
    shown = words_on_screen(picture)
    hidden = ["1.00", "0.00", "0.50"]  # 1 * [1, -2, 0.5] + [0, 0.5, 0], and what ReLU lets through
    outputs = ["0.00", "0.62"]  # 2 - 2 and 0.5 + 0.125
    headings = ["inputs", "hidden (ReLU)", "outputs"]
    assert sorted(shown) == sorted(["1", "0", *hidden, *outputs, "0", "1", *NAMES, *headings])
    assert "2 of 3 hidden nodes let something through" in picture.alt
    assert "UP 0.00, DOWN 0.62" in picture.alt


def test_the_best_output_is_bold():
    texts = plots.forward_pass(LAYERS, [1, 0]).figure.axes[0].texts
    assert [text.get_text() for text in texts if text.get_fontweight() == "bold"] == ["0.62"]


def test_lines_say_what_flows_and_no_line_leaves_a_silent_node():
    picture = plots.forward_pass(LAYERS, [1, 0])
    first, second = lines_between(picture, 0), lines_between(picture, 1)
    assert first.keys() == {(0, 0), (0, 1), (0, 2)}, "the second input is 0"
    assert [first[0, k][0] for k in range(3)] == [BLUE, ORANGE, BLUE]
    assert first[0, 1][1] > first[0, 0][1] > first[0, 2][1], "the more flows, the thicker"
    assert {style for colour, _, style in first.values() if colour == ORANGE} == {"--"}, "not by colour alone"
    assert second.keys() == {(0, 0), (2, 0), (2, 1)}
    assert second[2, 0][0] == ORANGE


def test_a_network_without_hidden_layers_can_be_drawn():
    picture = plots.forward_pass(LAYERS[:1], [0.5, -0.5])
    assert {"0.38", "-2.00", "0.75", "0.50", "-0.50"} <= set(words_on_screen(picture))


# --- many agents ------------------------------------------------------------------------------------------------------


def test_each_agent_has_its_dot_and_each_kind_its_median_and_note():
    results = {"plain": [1.0, 2.0, 9.0], "better": [3.0, 3.0, 4.0, 5.0]}
    notes = {"plain": "one of them", "better": "all of them"}
    picture = plots.seed_by_seed(results, truth=("worth", 3.5), notes=notes)
    axes = picture.figure.axes[0]
    dots = [np.sort(kind.get_offsets()[:, 0]).tolist() for kind in axes.collections]
    assert dots == [sorted(values) for values in results.values()]
    medians = [line.get_xdata()[0] for line in axes.lines if line.get_color() == INK]
    assert medians == [2.0, 3.5]
    assert {"one of them", "all of them", "worth: 3.5"} <= set(words_on_screen(picture))
    assert [label.get_text() for label in axes.get_yticklabels()] == ["plain", "better"]
    assert "plain: median 2.00, 1.00 to 9.00" in picture.alt


def test_dots_of_one_kind_do_not_stray_into_another():
    rows = plots.seed_by_seed({"a": np.zeros(500), "b": np.zeros(500)}).figure.axes[0].collections
    assert rows[0].get_offsets()[:, 1].max() < rows[1].get_offsets()[:, 1].min()


def test_counts_are_drawn_where_they_were_made():
    picture = plots.counts({"plain": [1, 5, 9], "better": [7, 8, 10]}, [100, 200, 400], 10)
    lines = picture.figure.axes[0].lines
    assert [list(line.get_ydata()) for line in lines] == [[1, 5, 9], [7, 8, 10]]
    assert all(list(line.get_xdata()) == [100, 200, 400] for line in lines)
    assert "plain: 1, 5, 9; better: 7, 8, 10" in picture.alt


def test_a_learning_curve_can_stand_at_other_places_than_one_by_one():
    picture = plots.learning_curves({"a": [[1.0, 2.0], [3.0, 4.0]]}, at=[100, 500])
    assert list(picture.figure.axes[0].lines[0].get_xdata()) == [100, 500]


def test_words_of_ones_own_take_the_place_of_the_numbers():
    maze, q = Maze(), np.zeros((16, 4))
    for picture in (
        plots.values(maze, q[:, 0], words="as I say"),
        plots.action_values(maze, q, words="as I say"),
        plots.stages(maze, {"now": q}, words="as I say"),
        plots.forward_pass(LAYERS, [1, 0], words="as I say"),
        plots.seed_by_seed({"a": [1.0]}, words="as I say"),
        plots.counts({"a": [1]}, [1], 1, words="as I say"),
        plots.learning_curves({"a": [[1.0]]}, words="as I say"),
        plots.cart_pole({"now": (0.1, 0, 0.1, 0)}, words="as I say"),
    ):
        assert picture.alt.endswith("as I say")


# --- stages, and a pole -----------------------------------------------------------------------------------------------


def test_stages_show_each_table_on_a_board_of_its_own():
    maze = Maze([[3, 0], [0, 4]], wall_ends_episode=False)
    best = value_iteration(maze.mdp, 0.5).q
    picture = plots.stages(maze, {"early": best / 2, "late": best})
    boards = picture.figure.axes[:2]
    assert [board.get_title(loc="left") for board in boards] == ["early", "late"]
    numbers = [sorted(text.get_text() for text in board.texts if text.get_gid() != "state number") for board in boards]
    assert numbers == [["0.25", "0.5", "0.5"], ["0.5", "1", "1"]]
    arrows = [next(c for c in board.collections if c.get_gid() == "best actions") for board in boards]
    assert all(len(quiver.U) == 4 for quiver in arrows), "two in the start, one in each cell beside the goal"


def test_stages_share_their_colours():
    maze = Maze([[3, 0], [0, 4]])
    low, high = np.zeros((4, 4)), np.ones((4, 4))
    boards = plots.stages(maze, {"low": low, "high": high}).figure.axes[:2]
    colours = [board.patches[0].get_facecolor() for board in boards]
    assert colours[0] != colours[1]


@pytest.mark.parametrize(("angle", "side"), [(0.15, 1), (-0.15, -1)])
def test_the_pole_leans_to_the_side_of_its_angle(angle, side):
    axes = plots.cart_pole({"now": (1.0, 0.0, angle, 0.0)}).figure.axes[0]
    foot, tip = (np.array(points) for points in zip(*axes.lines[-1].get_data(), strict=True))
    assert np.sign(tip[0] - foot[0]) == side
    assert foot[0] == 1.0
    assert np.linalg.norm(tip - foot) == pytest.approx(1.0)


@pytest.mark.parametrize(("moment", "over"), [((0, 0, 0, 0), False), ((2.5, 0, 0, 0), True), ((0, 0, -0.22, 0), True)])
def test_a_fallen_pole_and_a_cart_off_its_track_are_said_to_be_over(moment, over):
    assert (", over" in plots.cart_pole({"now": moment}).alt) == over


def test_every_action_has_its_name_in_a_network_of_the_maze():
    layers = [(np.ones((16, 4)), np.arange(4.0))]
    shown = words_on_screen(plots.forward_pass(layers, np.eye(16)[3], output_names=[a.name for a in Action]))
    assert [name for name in shown if name.isalpha() and name.isupper()] == ["UP", "DOWN", "LEFT", "RIGHT"]
