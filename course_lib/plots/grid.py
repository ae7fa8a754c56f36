"""The maze and what is known about its cells: values, action values, arrows, where a move may lead."""

import numpy as np

from course_lib.maze import MOVES, Action, Tile
from course_lib.plots.picture import INK, ORANGE, PAPER, RED, SKY, YELLOW, Picture, new_figure

_ALIKE = 1e-9  # values this close are drawn as equal
_MOST_NUMBERS = 12  # columns up to which a cell has room for numbers
_WALL = "#4a4f57"


def maze(world, *, mouse=None, path=None, title=""):
    """The maze from above: start, goals, walls and the mouse; `path`: a list of states to draw as a trail."""
    figure, axes = _board(world, title)
    _draw_tiles(axes, world, fill=True)
    mouse = world.start if mouse is None and path is None else mouse
    if path is not None:
        rows, columns = np.divmod(np.asarray(path), world.columns)
        axes.plot(columns + 0.5, rows + 0.5, color=RED, linewidth=4, alpha=0.6, solid_capstyle="round")
        mouse = path[-1]
    _draw_cheese(axes, world, beside=mouse)
    _draw_mouse(axes, world, mouse)
    trail = "" if path is None else f" A trail leads through the states {', '.join(str(int(s)) for s in path)}."
    return Picture(figure, f"{title or 'The maze'}: {_words_for(world)}{trail}")


def values(world, state_values, *, q=None, policy=None, title="", label="value of the cell", span=None, signed=False):
    """A heat map of one number a state, and arrows: for the best actions of `q`, float[S, A], or a `policy`, int[S].

    Cells that are NaN stay empty. span: (lowest, highest) of the colours, so that pictures can be compared; signed:
    zero in the middle of the colours, for differences.
    """
    import seaborn

    state_values = np.asarray(state_values, dtype=float)
    shown = [s for s in _acting_states(world) if not np.isnan(state_values[s])]
    low, high = span or (state_values[shown].min(), state_values[shown].max())
    if signed:
        low, high = -max(abs(low), abs(high)), max(abs(low), abs(high))
    colours = "PuOr" if signed else "viridis"
    few = world.columns <= _MOST_NUMBERS
    empty = np.ones(world.grid.size, bool)
    empty[shown] = False
    figure, axes = _board(world, title, legend_room=1.1)
    seaborn.heatmap(
        state_values.reshape(world.grid.shape), ax=axes, mask=empty.reshape(world.grid.shape), cmap=colours,
        vmin=low, vmax=high, square=True, linewidths=few * 1.5, linecolor=PAPER, cbar_kws={"label": label},
        xticklabels=False, yticklabels=False,
    )  # fmt: skip
    _label_rows_and_columns(axes, world)
    _draw_tiles(axes, world, fill=False)
    _draw_cheese(axes, world)
    q = q if policy is None else np.eye(len(Action))[policy]
    if few:
        ink = _readable_on(colours, low, high)
        for s in shown:
            row, column = divmod(s, world.columns)
            look = {"ha": "center", "va": "center", "fontsize": 11, "color": ink(state_values[s])}
            axes.text(column + 0.5, row + (0.5 if q is None else 0.24), _short(state_values[s]), **look)
            _number_cell(axes, world, s, ink(state_values[s]))
    if q is not None:
        _draw_best_actions(axes, world, np.asarray(q, dtype=float), lift=0.15 if few else 0.0)
    return Picture(figure, f"{title or 'Values'}: {_words_for_values(world, state_values, shown, q)}")


def action_values(world, q, *, title="", span=None):
    """Four wedges a cell, one for each action, with its value; the best of a cell stand in a frame.

    span: (lowest, highest) of the colours, so that two pictures can be compared; by default those of `q`.
    """
    from matplotlib import colormaps, colors

    q = np.asarray(q, dtype=float)
    acting = _acting_states(world)
    low, high = span or (float(q[acting].min()), float(q[acting].max()))
    norm = colors.Normalize(low, high if high > low else low + 1)
    ink = _readable_on("viridis", low, high)
    figure, axes = _board(world, title, legend_room=1.1, cell=1.25)
    for s in acting:
        for a in Action:
            _draw_wedge(axes, world, s, a, q[s], colormaps["viridis"](norm(q[s, a])), ink(q[s, a]))
    axes.set_xlim(0, world.columns)
    axes.set_ylim(world.rows, 0)
    _draw_tiles(axes, world, fill=False)
    _draw_cheese(axes, world)
    scale = figure.colorbar(_mappable(norm), ax=axes, label="Q(s, a)", shrink=0.85)
    scale.outline.set_visible(False)
    return Picture(figure, f"{title or 'Action values'}: {_words_for_values(world, q.max(axis=1), acting, q)}")


def transition(world, state, action, *, counts=None, title=""):
    """T(s, a, s'), where `action` in `state` may lead, drawn on the maze; beside it `counts`, int[S], if given."""
    chances = world.mdp.T[state, action]
    name = Action(action).name.lower()
    reached = [int(s) for s in np.flatnonzero(chances)]
    drawn = [(chances, title or f"T(s = {state}, a = {name}, s')")]
    if counts is not None:
        total = int(np.sum(counts))
        drawn.append((np.asarray(counts) / total, f"how often in {total:,} tries"))
    figure, axes = new_figure(0.95 * world.columns * len(drawn) + 0.8, 0.95 * world.rows + 0.7, columns=len(drawn))
    for panel, (share, heading) in zip(np.atleast_1d(axes), drawn, strict=True):
        _prepare(panel, world, heading)
        _draw_tiles(panel, world, fill=True)
        for s in np.flatnonzero(share):
            row, column = divmod(int(s), world.columns)
            panel.add_patch(_square(column, row, facecolor=SKY, alpha=0.25 + 0.75 * float(share[s])))
            panel.text(column + 0.94, row + 0.14, f"{share[s]:.3g}", ha="right", va="center", color=INK, fontsize=11)
        _draw_cheese(panel, world)
        _draw_mouse(panel, world, state, small=True)
        _draw_arrow(panel, world, state, action, from_middle=0.2)
    words = ", ".join(f"state {s} with probability {chances[s]:.3g}" for s in reached)
    tries = (
        ""
        if counts is None
        else f" In {total:,} tries: " + ", ".join(f"state {s} {counts[s]:,} times" for s in reached) + "."
    )
    return Picture(figure, f"Action {name} in state {state} leads to {words}.{tries}")


def _board(world, title, *, legend_room=0.0, cell=0.95):
    cell = min(cell, 7.0 / world.columns, 7.0 / world.rows)
    figure, axes = new_figure(max(cell * world.columns, 2.2) + 0.8 + legend_room, cell * world.rows + 0.7)
    _prepare(axes, world, title)
    return figure, axes


def _prepare(axes, world, title):
    axes.set_xlim(0, world.columns)
    axes.set_ylim(world.rows, 0)
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=12, color=INK, loc="left", pad=8)
    axes.spines[:].set_visible(False)
    _label_rows_and_columns(axes, world)


def _label_rows_and_columns(axes, world):
    every = max(1, world.columns // 10, world.rows // 10)
    axes.set_xticks(np.arange(0, world.columns, every) + 0.5, np.arange(0, world.columns, every), rotation=0)
    axes.set_yticks(np.arange(0, world.rows, every) + 0.5, np.arange(0, world.rows, every), rotation=0)
    axes.set_xlabel("column", fontsize=10, color=INK)
    axes.set_ylabel("row", fontsize=10, color=INK)
    axes.tick_params(labelsize=10, length=0, colors=INK)


def _square(column, row, **look):
    from matplotlib.patches import Rectangle

    return Rectangle((column + 0.02, row + 0.02), 0.96, 0.96, linewidth=0, **look)


def _draw_tiles(axes, world, *, fill):
    """Walls always, hatched so that they do not speak by colour alone; open cells and their names where `fill`."""
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    if fill:
        axes.add_patch(Rectangle((0, 0), world.columns, world.rows, facecolor="#ececea", linewidth=0, zorder=0))
        axes.set_xticks(np.arange(world.columns + 1), minor=True)
        axes.set_yticks(np.arange(world.rows + 1), minor=True)
        axes.grid(which="minor", color=PAPER, linewidth=2 if world.columns <= _MOST_NUMBERS else 0.3)
        axes.tick_params(which="minor", length=0)
    walls = [Rectangle((column, row), 1, 1) for row, column in np.argwhere(world.grid == Tile.WALL)]
    hatch = "///" if world.columns <= _MOST_NUMBERS else None
    axes.add_collection(
        PatchCollection(walls, facecolor=_WALL, edgecolor="#6a7079", hatch=hatch, linewidth=0, zorder=1)
    )
    if hatch:
        _draw_cell_rewards(axes, world)
    if fill and hatch:
        for s in range(world.grid.size):
            _number_cell(axes, world, s, "white" if world.grid.flat[s] == Tile.WALL else INK)
        row, column = divmod(world.start, world.columns)
        axes.text(column + 0.5, row + 0.91, "start", fontsize=9, color=INK, ha="center", va="center")
        for goal in world.goals:
            row, column = divmod(goal, world.columns)
            axes.text(column + 0.5, row + 0.91, "goal", fontsize=9, color=INK, ha="center", va="center")


def _draw_mouse(axes, world, state, *, small=False):
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


def _draw_cheese(axes, world, beside=None):
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


def _draw_cell_rewards(axes, world):
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


def _short(number):
    """Three digits, of which at most three behind the point; whole numbers from a thousand up."""
    return f"{number:,.0f}" if abs(number) >= 1000 else f"{round(float(number), 3):.3g}"


def _acting_states(world):
    return np.flatnonzero(~np.isin(world.grid.ravel(), (Tile.WALL, Tile.GOAL)))


def best_actions(q_row):
    """Every action worth as much as the best one, up to rounding."""
    return np.flatnonzero(q_row >= q_row.max() - _ALIKE * max(1.0, abs(q_row.max())))


def _draw_best_actions(axes, world, q, lift):
    """An arrow for every best action of a cell; none where all are alike, since nothing is known there."""
    pairs = [(s, a) for s in _acting_states(world) for a in best_actions(q[s]) if len(best_actions(q[s])) < len(Action)]
    if pairs:
        _draw_arrow(axes, world, *zip(*pairs, strict=True), lift=lift)


def _readable_on(colours, low, high):
    """A function from a value to black or white, whichever stands out more on the value's colour."""
    from matplotlib import colormaps
    from matplotlib.colors import Normalize

    shade, norm = colormaps[colours], Normalize(low, high if high > low else low + 1)

    def ink(value):
        linear = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in shade(norm(value))[:3])
        luminance = np.dot((0.2126, 0.7152, 0.0722), list(linear))  # as the W3C's contrast ratio has it
        return "black" if (luminance + 0.05) / 0.05 > 1.05 / (luminance + 0.05) else "white"

    return ink


def _number_cell(axes, world, state, colour=INK):
    """The state's number, small, in the corner of its cell."""
    row, column = divmod(int(state), world.columns)
    axes.text(column + 0.06, row + 0.12, str(state), fontsize=7.5, color=colour, va="center", gid="state number")


def _draw_arrow(axes, world, states, actions, *, lift=0.0, from_middle=0.06):
    """Arrows from the cells' middles the way the actions move: a row further down is a row further down the picture."""
    rows, columns = np.divmod(np.atleast_1d(states), world.columns)
    down, right = MOVES[np.atleast_1d(actions)].T
    width = 0.055 if world.columns <= _MOST_NUMBERS else 0.1
    arrows = axes.quiver(
        columns + 0.5 + right * from_middle, rows + 0.5 + lift + down * from_middle, right * 0.26, down * 0.26,
        angles="xy", scale_units="xy", scale=1, units="xy", width=width,
        color="white", edgecolor=INK, linewidth=0.9, zorder=8,
    )  # fmt: skip
    arrows.set_gid("best actions")
    return arrows


def _draw_wedge(axes, world, s, a, row_values, colour, ink):
    from matplotlib.patches import Polygon

    row, column = divmod(int(s), world.columns)
    middle = np.array([column + 0.5, row + 0.5])
    down, right = MOVES[a]
    towards, across = np.array([right, down]) * 0.5, np.array([down, right]) * 0.5
    best = a in best_actions(row_values) and len(best_actions(row_values)) < len(Action)
    corners = [middle, middle + towards - across, middle + towards + across]
    wedge = Polygon(corners, facecolor=colour, edgecolor=PAPER, linewidth=1, zorder=2)
    wedge.set_gid(f"wedge {int(s)} {int(a)}")
    axes.add_patch(wedge)
    if best:
        inner = middle * 0.08 + np.array(corners) * 0.92 + towards * 0.02
        axes.add_patch(Polygon(inner, fill=False, edgecolor=RED, linewidth=2.2, zorder=3))
    if world.columns <= _MOST_NUMBERS:
        x, y = middle + towards * 0.62
        axes.text(
            x, y, f"{row_values[a]:.2f}", ha="center", va="center", fontsize=9, zorder=6,
            color=ink, fontweight="bold" if best else "normal",
        )  # fmt: skip


def _mappable(norm):
    from matplotlib.cm import ScalarMappable

    return ScalarMappable(norm, "viridis")


def _words_for(world):
    walls = [int(s) for s in np.flatnonzero(world.grid == Tile.WALL)]
    shown = "walls in states " + ", ".join(map(str, walls[:12])) + (" and more" if len(walls) > 12 else "")
    goals = ", ".join(map(str, world.goals))
    size = f"{world.rows} × {world.columns} cells"
    return f"{size}, start in state {world.start}, goal in state {goals}, {shown if walls else 'no walls'}."


def _words_for_values(world, state_values, shown, q):
    low, high = float(state_values[shown].min()), float(state_values[shown].max())
    highest = shown[state_values[shown].argmax()]
    words = f"from {_short(low)} to {_short(high)}, highest in state {highest},"
    words += f" the start {_short(state_values[world.start])}."
    if q is None:
        return words
    names = " or ".join(Action(a).name.lower() for a in best_actions(np.asarray(q)[world.start]))
    return f"{words} Arrows in the start: {names}."
