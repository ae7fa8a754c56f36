"""A maze drawn from above: the board, what stands on it, and arrows for what to do."""

import numpy as np

from course_lib.maze import MOVES, Action, Tile
from course_lib.plots.picture import INK, ORANGE, PAPER, SKY, YELLOW, new_figure

ALIKE = 1e-9  # values this close are drawn as equal
MOST_NUMBERS = 12  # columns up to which a cell has room for numbers
WALL = "#4a4f57"


def board(world, title, *, legend_room=0.0, cell=0.95):
    cell = min(cell, 7.0 / world.columns, 7.0 / world.rows)
    figure, axes = new_figure(max(cell * world.columns, 2.2) + 0.8 + legend_room, cell * world.rows + 0.7)
    prepare(axes, world, title)
    return figure, axes


def prepare(axes, world, title):
    axes.set_xlim(0, world.columns)
    axes.set_ylim(world.rows, 0)
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=12, color=INK, loc="left", pad=8)
    axes.spines[:].set_visible(False)
    label_rows_and_columns(axes, world)


def label_rows_and_columns(axes, world):
    every = max(1, world.columns // 10, world.rows // 10)
    axes.set_xticks(np.arange(0, world.columns, every) + 0.5, np.arange(0, world.columns, every), rotation=0)
    axes.set_yticks(np.arange(0, world.rows, every) + 0.5, np.arange(0, world.rows, every), rotation=0)
    axes.set_xlabel("column", fontsize=10, color=INK)
    axes.set_ylabel("row", fontsize=10, color=INK)
    axes.tick_params(labelsize=10, length=0, colors=INK)


def square(column, row, **look):
    from matplotlib.patches import Rectangle

    return Rectangle((column + 0.02, row + 0.02), 0.96, 0.96, linewidth=0, **look)


def draw_tiles(axes, world, *, fill):
    """Walls always, hatched so that they do not speak by colour alone; open cells and their names where `fill`."""
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    if fill:
        axes.add_patch(Rectangle((0, 0), world.columns, world.rows, facecolor="#ececea", linewidth=0, zorder=0))
        axes.set_xticks(np.arange(world.columns + 1), minor=True)
        axes.set_yticks(np.arange(world.rows + 1), minor=True)
        axes.grid(which="minor", color=PAPER, linewidth=2 if world.columns <= MOST_NUMBERS else 0.3)
        axes.tick_params(which="minor", length=0)
    walls = [Rectangle((column, row), 1, 1) for row, column in np.argwhere(world.grid == Tile.WALL)]
    hatch = "///" if world.columns <= MOST_NUMBERS else None
    axes.add_collection(PatchCollection(walls, facecolor=WALL, edgecolor="#6a7079", hatch=hatch, linewidth=0, zorder=1))
    if hatch:
        draw_cell_rewards(axes, world)
    if fill and hatch:
        for s in range(world.grid.size):
            number_cell(axes, world, s, "white" if world.grid.flat[s] == Tile.WALL else INK)
        row, column = divmod(world.start, world.columns)
        axes.text(column + 0.5, row + 0.91, "start", fontsize=9, color=INK, ha="center", va="center")
        for goal in world.goals:
            row, column = divmod(goal, world.columns)
            axes.text(column + 0.5, row + 0.91, "goal", fontsize=9, color=INK, ha="center", va="center")


def draw_mouse(axes, world, state, *, small=False):
    from matplotlib.patches import Circle, Ellipse

    if state is None:
        return
    row, column = divmod(int(state), world.columns)
    x, y, size = column + 0.5, row + (0.46 if small else 0.5), 0.15 if small else 0.22
    for ear in (-1, 1):
        axes.add_patch(
            Circle((x + ear * size * 0.8, y - size * 0.8), size * 0.55, facecolor="#b9a7a0", edgecolor=INK, zorder=5)
        )
    axes.add_patch(Ellipse((x, y), size * 2.1, size * 1.9, facecolor="#8d7b74", edgecolor=INK, zorder=6))
    for eye in (-1, 1):
        axes.add_patch(Circle((x + eye * size * 0.4, y - size * 0.15), size * 0.13, facecolor=INK, zorder=7))
    axes.add_patch(
        Circle((x, y + size * 0.45), size * 0.17, facecolor="#f2b8c6", edgecolor=INK, linewidth=0.5, zorder=7)
    )


def draw_cheese(axes, world, beside=None):
    from matplotlib.patches import Circle, Polygon

    pays = {goal: world.goal_reward + world.cell_rewards.flat[goal] for goal in world.goals}
    for goal, pay in pays.items():
        if goal == beside:
            continue
        row, column = divmod(goal, world.columns)
        size = 0.35 + 0.65 * max(pay, 0) / max(*pays.values(), 1e-9)  # a better cheese is a larger one
        middle = np.array([column + 0.5, row + 0.5])
        corners = middle + size * np.array([(-0.3, 0.2), (0.3, 0.2), (0.3, -0.2)])
        axes.add_patch(Polygon(corners, facecolor=YELLOW, edgecolor=ORANGE, linewidth=1.5, zorder=4))
        for x, y, radius in ((0.16, 0.07, 0.05), (0.0, 0.13, 0.035), (0.23, -0.05, 0.03)):
            axes.add_patch(Circle(middle + size * np.array([x, y]), size * radius, facecolor=ORANGE, zorder=5))


def draw_cell_rewards(axes, world):
    """What entering a cell costs or pays beside the rest: dotted, with the number."""
    from matplotlib.patches import Rectangle

    for s in np.flatnonzero(world.cell_rewards):
        row, column = divmod(int(s), world.columns)
        if world.grid[row, column] not in (Tile.WALL, Tile.GOAL):
            axes.add_patch(
                Rectangle((column, row), 1, 1, fill=False, edgecolor=SKY, hatch="..", linewidth=0, zorder=1.5)
            )
            note = f"{world.cell_rewards.flat[s]:+.3g}"
            look = {"boxstyle": "round,pad=0.1", "facecolor": PAPER, "linewidth": 0, "alpha": 0.8}
            axes.text(
                column + 0.95, row + 0.88, note, fontsize=8, ha="right", va="center", color=INK, bbox=look, zorder=9
            )


def short(number):
    """Three digits, of which at most three behind the point; whole numbers from a thousand up."""
    return f"{number:,.0f}" if abs(number) >= 1000 else f"{round(float(number), 3):.3g}"


def acting_states(world):
    return np.flatnonzero(~np.isin(world.grid.ravel(), (Tile.WALL, Tile.GOAL)))


def best_actions(q_row):
    """Every action worth as much as the best one, up to rounding."""
    return np.flatnonzero(q_row >= q_row.max() - ALIKE * max(1.0, abs(q_row.max())))


def draw_best_actions(axes, world, q, lift):
    """An arrow for every best action of a cell; none where all are alike, since nothing is known there."""
    pairs = [(s, a) for s in acting_states(world) for a in best_actions(q[s]) if len(best_actions(q[s])) < len(Action)]
    if pairs:
        draw_arrow(axes, world, *zip(*pairs, strict=True), lift=lift)


def readable_on(colours, low, high):
    """A function from a value to black or white, whichever stands out more on the value's colour."""
    from matplotlib import colormaps
    from matplotlib.colors import Normalize

    shade, norm = colormaps[colours], Normalize(low, high if high > low else low + 1)

    def ink(value):
        linear = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in shade(norm(value))[:3])
        luminance = np.dot((0.2126, 0.7152, 0.0722), list(linear))  # as the W3C's contrast ratio has it
        return "black" if (luminance + 0.05) / 0.05 > 1.05 / (luminance + 0.05) else "white"

    return ink


def number_cell(axes, world, state, colour=INK):
    """The state's number, small, in the corner of its cell."""
    row, column = divmod(int(state), world.columns)
    axes.text(column + 0.06, row + 0.12, str(state), fontsize=7.5, color=colour, va="center", gid="state number")


def draw_arrow(axes, world, states, actions, *, lift=0.0, from_middle=0.06):
    """Arrows from the cells' middles the way the actions move: a row further down is a row further down the picture."""
    rows, columns = np.divmod(np.atleast_1d(states), world.columns)
    down, right = MOVES[np.atleast_1d(actions)].T
    width = 0.055 if world.columns <= MOST_NUMBERS else 0.1
    arrows = axes.quiver(
        columns + 0.5 + right * from_middle, rows + 0.5 + lift + down * from_middle, right * 0.26, down * 0.26,
        angles="xy", scale_units="xy", scale=1, units="xy", width=width,
        color="white", edgecolor=INK, linewidth=0.9, zorder=8,
    )  # fmt: skip
    arrows.set_gid("best actions")
    return arrows
