"""Pictures say what is true: arrows point where actions move, wedges lie on the right side, words hold the numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib import Action, Maze, plots, value_iteration
from course_lib.plots.board import best_actions


def acting_states(maze):
    return [s for s in range(maze.grid.size) if not maze.mdp.terminal[s].all() or s == maze.start]


def arrows(picture):
    """(state, action) of every arrow drawn, read off the picture in screen directions: right is +x, up is +y."""
    axes = picture.figure.axes[0]
    picture.figure.canvas.draw()
    columns = round(axes.get_xlim()[1])
    found = []
    for quiver in (c for c in axes.collections if c.get_gid() == "best actions"):
        tails = np.column_stack([quiver.X, quiver.Y])
        heads = tails + np.column_stack([quiver.U, quiver.V])
        for tail, head in zip(tails, heads, strict=True):
            dx, dy = axes.transData.transform(head) - axes.transData.transform(tail)
            if abs(dx) > abs(dy):
                action = Action.RIGHT if dx > 0 else Action.LEFT
            else:
                action = Action.UP if dy > 0 else Action.DOWN
            found.append((int(tail[1]) * columns + int(tail[0]), action))
    return found


def words_on_screen(picture):
    picture.figure.canvas.draw()
    return [text.get_text() for axes in picture.figure.axes for text in axes.texts if text.get_gid() != "state number"]


@pytest.mark.parametrize("action", Action)
def test_an_arrow_points_where_its_action_moves(action):
    maze = Maze([[3, 0, 0], [0, 0, 0], [0, 0, 4]])
    q = np.zeros((9, 4))
    q[4, action] = 1.0
    assert arrows(plots.values(maze, q.max(axis=1), q=q)) == [(4, action)]
    before_row, before_column = maze.cell(4)
    after_row, after_column = maze.cell(int(maze.mdp.next_state[4, action, 0]))
    moves = {Action.UP: (-1, 0), Action.DOWN: (1, 0), Action.LEFT: (0, -1), Action.RIGHT: (0, 1)}
    assert (after_row - before_row, after_column - before_column) == moves[action]


@settings(max_examples=15, deadline=None)
@given(rows=st.integers(2, 5), columns=st.integers(2, 5), seed=st.integers(0, 1000))
def test_every_best_action_has_its_arrow_and_no_other(rows, columns, seed):
    maze = Maze.random(rows, columns, seed=seed, wall_ends_episode=False, wall_reward=0.0)
    q = value_iteration(maze.mdp, 0.9).q
    expected = {
        (s, Action(a))
        for s in acting_states(maze)
        if maze.grid.flat[s] in (0, 3) and len(best_actions(q[s])) < 4
        for a in best_actions(q[s])
    }
    assert set(arrows(plots.values(maze, q.max(axis=1), q=q))) == expected


@pytest.mark.parametrize("action", Action)
def test_a_wedge_lies_on_the_side_its_action_moves_to(action):
    maze = Maze([[3, 0, 0], [0, 0, 0], [0, 0, 4]])
    picture = plots.action_values(maze, np.arange(36.0).reshape(9, 4))
    axes = picture.figure.axes[0]
    picture.figure.canvas.draw()
    wedge = next(patch for patch in axes.patches if patch.get_gid() == f"wedge 4 {int(action)}")
    offset = axes.transData.transform(wedge.get_xy()[:3].mean(axis=0)) - axes.transData.transform((1.5, 1.5))
    towards = {Action.UP: (0, 1), Action.DOWN: (0, -1), Action.LEFT: (-1, 0), Action.RIGHT: (1, 0)}[action]
    assert offset / np.linalg.norm(offset) == pytest.approx(towards, abs=1e-6)


def test_wedges_carry_the_numbers_of_the_table():
    maze = Maze([[3, 0], [0, 4]])
    q = np.round(np.random.default_rng(0).random((4, 4)), 2)
    shown = words_on_screen(plots.action_values(maze, q))
    assert sorted(shown) == sorted(f"{value:.2f}" for value in q[:3].ravel())


def test_a_heat_map_shows_every_value_except_walls_and_goals():
    maze = Maze()
    shown = words_on_screen(plots.values(maze, np.arange(16) / 100))
    assert sorted(shown) == sorted(f"{s / 100:.3g}" for s in range(16) if s not in (6, 10, 12, 15))


def test_numbers_stand_out_on_their_colours():
    maze = Maze([[3, 0, 0, 0], [0, 0, 0, 4]])
    picture = plots.values(maze, np.linspace(0, 1, 8))
    axes = picture.figure.axes[0]
    picture.figure.canvas.draw()
    cells = axes.collections[0].get_facecolors()
    shown = [text for text in axes.texts if text.get_gid() != "state number"]
    assert len(shown) == 7
    for text in shown:
        column, row = (int(place) for place in text.get_position())
        levels = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in cells[row * 4 + column][:3]]
        luminance = np.dot([0.2126, 0.7152, 0.0722], levels)
        contrast = (luminance + 0.05) / 0.05 if text.get_color() == "black" else 1.05 / (luminance + 0.05)
        assert contrast >= 4.5


def test_a_policy_is_drawn_as_it_is():
    maze = Maze([[3, 0, 0], [0, 0, 0], [0, 0, 4]])
    policy = np.array([3, 1, 1, 0, 2, 1, 3, 3, 0])
    assert dict(arrows(plots.values(maze, np.zeros(9), policy=policy))) == dict(enumerate(map(Action, policy[:8])))


def test_differences_have_zero_in_the_middle_of_the_colours():
    mesh = plots.values(Maze([[3, 0], [0, 4]]), [-2.0, 0.5, 1.0, 0.0], signed=True).figure.axes[0].collections[0]
    assert mesh.get_clim() == (-2.0, 2.0)


def test_cells_without_a_number_stay_empty():
    shown = words_on_screen(plots.values(Maze([[3, 0], [0, 4]]), [0.25, np.nan, 0.5, 0.0]))
    assert sorted(shown) == ["0.25", "0.5"]


def test_a_cell_that_costs_says_so():
    maze = Maze([[3, 0], [0, 4]], cell_rewards=[[0, -0.3], [0, 0]])
    assert "-0.3" in words_on_screen(plots.maze(maze))


def test_a_transition_shows_each_probability_in_its_cell():
    maze = Maze(slip=0.2)
    picture = plots.transition(maze, 5, Action.RIGHT)
    axes = picture.figure.axes[0]
    numbers = {
        (int(text.get_position()[1]), int(text.get_position()[0])): text.get_text()
        for text in axes.texts
        if text.get_text() not in ("start", "goal") and text.get_gid() != "state number"
    }
    assert numbers == {(0, 1): "0.1", (1, 1): "0.8", (2, 1): "0.1"}
    assert "state 5 with probability 0.8" in picture.alt


def test_a_learning_curve_draws_the_band_it_names():
    runs = np.random.default_rng(0).normal(size=(200, 30))
    picture = plots.learning_curves({"agents": runs}, band=(10, 90))
    axes = picture.figure.axes[0]
    assert axes.lines[0].get_ydata() == pytest.approx(np.median(runs, axis=0))
    edge = axes.collections[0].get_paths()[0].vertices[:, 1]
    assert edge.min() == pytest.approx(np.percentile(runs, 10, axis=0).min())
    assert edge.max() == pytest.approx(np.percentile(runs, 90, axis=0).max())
    assert any("10 % to 90 %" in text for text in words_on_screen(picture))
    assert "10 to 90 % band" in picture.alt


def test_the_contraction_picture_draws_the_bound():
    picture = plots.contraction({"sweeps": [2.0, 1.0, 0.25]}, 0.5)
    assert picture.figure.axes[0].lines[0].get_ydata() == pytest.approx([2.0, 1.0, 0.5])


@pytest.mark.parametrize(
    "picture",
    [
        plots.agent_loop(),
        plots.method_chart(),
        plots.neural_network(),
        plots.maze(Maze(), path=[0, 1, 2]),
        plots.values(Maze.random(30, 40, seed=0), np.linspace(0, 1, 1200)),
    ],
    ids=["loop", "chart", "network", "maze", "large maze"],
)
def test_every_picture_shows_itself_with_its_words(picture):
    shown = picture._repr_mimebundle_()
    assert picture.png().startswith(b"\x89PNG")
    assert len(shown["text/html"]) < 250_000
    assert shown["text/plain"] == f"Picture: {picture.alt}"
    assert 'src="data:image/png;base64,' in shown["text/html"]


def test_words_are_escaped_in_html():
    picture = plots.maze(Maze(), title='a "quoted" <title>')
    assert 'alt="a &quot;quoted&quot; &lt;title&gt;:' in picture._repr_mimebundle_()["text/html"]


def test_no_picture_touches_pyplot():
    import sys

    plots.maze(Maze())
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or pyplot.get_fignums() == []
