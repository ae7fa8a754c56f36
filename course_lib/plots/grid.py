"""The maze and what is known about its cells: values, action values, arrows, where a move may lead."""

import numpy as np

from course_lib.maze import MOVES, Action, Tile
from course_lib.plots.board import (
    MOST_NUMBERS,
    acting_states,
    best_actions,
    board,
    draw_arrow,
    draw_best_actions,
    draw_cheese,
    draw_mouse,
    draw_tiles,
    label_rows_and_columns,
    number_cell,
    prepare,
    readable_on,
    short,
    square,
)
from course_lib.plots.picture import INK, PAPER, RED, SKY, Picture, new_figure


def maze(world, *, mouse=None, path=None, title=""):
    """The maze from above: start, goals, walls and the mouse; `path`: a list of states to draw as a trail."""
    figure, axes = board(world, title)
    draw_tiles(axes, world, fill=True)
    mouse = world.start if mouse is None and path is None else mouse
    if path is not None:
        rows, columns = np.divmod(np.asarray(path), world.columns)
        axes.plot(columns + 0.5, rows + 0.5, color=RED, linewidth=4, alpha=0.6, solid_capstyle="round")
        mouse = path[-1]
    draw_cheese(axes, world, beside=mouse)
    draw_mouse(axes, world, mouse)
    trail = "" if path is None else f" A trail leads through the states {', '.join(str(int(s)) for s in path)}."
    return Picture(figure, f"{title or 'The maze'}: {_words_for(world)}{trail}")


def values(
    world,
    state_values,
    *,
    q=None,
    policy=None,
    title="",
    label="value of the cell",
    span=None,
    signed=False,
    words=None,
):
    """A heat map of one number a state, and arrows: for the best actions of `q`, float[S, A], or a `policy`, int[S].

    Cells that are NaN stay empty. span: (lowest, highest) of the colours, so that pictures can be compared; signed:
    zero in the middle of the colours, for differences; words: a text alternative of your own, for numbers that another
    processor may round otherwise.
    """
    import seaborn

    state_values = np.asarray(state_values, dtype=float)
    shown = [s for s in acting_states(world) if not np.isnan(state_values[s])]
    low, high = span or (state_values[shown].min(), state_values[shown].max())
    if signed:
        low, high = -max(abs(low), abs(high)), max(abs(low), abs(high))
    colours = "PuOr" if signed else "viridis"
    few = world.columns <= MOST_NUMBERS
    empty = np.ones(world.grid.size, bool)
    empty[shown] = False
    figure, axes = board(world, title, legend_room=1.1)
    seaborn.heatmap(
        state_values.reshape(world.grid.shape), ax=axes, mask=empty.reshape(world.grid.shape), cmap=colours,
        vmin=low, vmax=high, square=True, linewidths=few * 1.5, linecolor=PAPER, cbar_kws={"label": label},
        xticklabels=False, yticklabels=False,
    )  # fmt: skip
    label_rows_and_columns(axes, world)
    draw_tiles(axes, world, fill=False)
    draw_cheese(axes, world)
    q = q if policy is None else np.eye(len(Action))[policy]
    if few:
        ink = readable_on(colours, low, high)
        for s in shown:
            row, column = divmod(s, world.columns)
            look = {"ha": "center", "va": "center", "fontsize": 11, "color": ink(state_values[s])}
            axes.text(column + 0.5, row + (0.5 if q is None else 0.24), short(state_values[s]), **look)
            number_cell(axes, world, s, ink(state_values[s]))
    if q is not None:
        draw_best_actions(axes, world, np.asarray(q, dtype=float), lift=0.15 if few else 0.0)
    return Picture(figure, f"{title or 'Values'}: {words or _words_for_values(world, state_values, shown, q)}")


def action_values(world, q, *, title="", span=None, words=None):
    """Four wedges a cell, one for each action, with its value; the best of a cell stand in a frame.

    span: (lowest, highest) of the colours, so that two pictures can be compared; by default those of `q`. words: a text
    alternative of your own, as in `values`.
    """
    from matplotlib import colormaps, colors

    q = np.asarray(q, dtype=float)
    acting = acting_states(world)
    low, high = span or (float(q[acting].min()), float(q[acting].max()))
    norm = colors.Normalize(low, high if high > low else low + 1)
    ink = readable_on("viridis", low, high)
    figure, axes = board(world, title, legend_room=1.1, cell=1.25)
    for s in acting:
        for a in Action:
            _draw_wedge(axes, world, s, a, q[s], colormaps["viridis"](norm(q[s, a])), ink(q[s, a]))
    axes.set_xlim(0, world.columns)
    axes.set_ylim(world.rows, 0)
    draw_tiles(axes, world, fill=False)
    draw_cheese(axes, world)
    scale = figure.colorbar(_mappable(norm), ax=axes, label="Q(s, a)", shrink=0.85)
    scale.outline.set_visible(False)
    words = words or _words_for_values(world, q.max(axis=1), acting, q)
    return Picture(figure, f"{title or 'Action values'}: {words}")


def stages(world, tables, *, title="", span=None, words=None):
    """What is known about every cell at several times, side by side: max_a q[s, a] and arrows for the best actions.

    tables: {heading: float[S, A]}; span and words as in `values`, by default the colours of all tables together.
    """
    from matplotlib import colormaps, colors

    best = {heading: np.asarray(q, dtype=float).max(axis=1) for heading, q in tables.items()}
    shown = acting_states(world)
    low, high = span or (min(v[shown].min() for v in best.values()), max(v[shown].max() for v in best.values()))
    norm, ink = colors.Normalize(low, high if high > low else low + 1), readable_on("viridis", low, high)
    figure, panels = new_figure(2.7 * len(tables) + 0.9, 2.7 * world.rows / world.columns + 0.9, columns=len(tables))
    panels = np.atleast_1d(panels)
    for axes, (heading, q) in zip(panels, tables.items(), strict=True):
        prepare(axes, world, heading)
        for s in shown:
            row, column = divmod(int(s), world.columns)
            value = best[heading][s]
            axes.add_patch(square(column, row, facecolor=colormaps["viridis"](norm(value))))
            if world.columns <= MOST_NUMBERS:
                look = {"ha": "center", "va": "center", "fontsize": 9, "color": ink(value)}
                axes.text(column + 0.5, row + 0.26, short(value), **look)
        draw_tiles(axes, world, fill=False)
        draw_cheese(axes, world)
        draw_best_actions(axes, world, np.asarray(q, dtype=float), lift=0.15)
    if title:
        figure.suptitle(title, fontsize=12, color=INK, x=0.01, ha="left")
    scale = figure.colorbar(_mappable(norm), ax=list(panels), label="value of the cell", shrink=0.8)
    scale.outline.set_visible(False)
    if words is None:
        words = " ".join(f"{h}: {_words_for_values(world, best[h], shown, np.asarray(q))}" for h, q in tables.items())
    return Picture(figure, f"{title or 'Values in time'}: {words}")


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
        prepare(panel, world, heading)
        draw_tiles(panel, world, fill=True)
        for s in np.flatnonzero(share):
            row, column = divmod(int(s), world.columns)
            panel.add_patch(square(column, row, facecolor=SKY, alpha=0.25 + 0.75 * float(share[s])))
            panel.text(column + 0.94, row + 0.14, f"{share[s]:.3g}", ha="right", va="center", color=INK, fontsize=11)
        draw_cheese(panel, world)
        draw_mouse(panel, world, state, small=True)
        draw_arrow(panel, world, state, action, from_middle=0.2)
    words = ", ".join(f"state {s} with probability {chances[s]:.3g}" for s in reached)
    tries = (
        ""
        if counts is None
        else f" In {total:,} tries: " + ", ".join(f"state {s} {counts[s]:,} times" for s in reached) + "."
    )
    return Picture(figure, f"Action {name} in state {state} leads to {words}.{tries}")


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
    if world.columns <= MOST_NUMBERS:
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
    words = f"from {short(low)} to {short(high)}, highest in state {highest},"
    words += f" the start {short(state_values[world.start])}."
    if q is None:
        return words
    names = " or ".join(Action(a).name.lower() for a in best_actions(np.asarray(q)[world.start]))
    return f"{words} Arrows in the start: {names}."
