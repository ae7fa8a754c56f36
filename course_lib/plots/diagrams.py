"""Ideas drawn: who talks to whom, which method for which problem, what a network is."""

from itertools import pairwise, product

import numpy as np

from course_lib.plots.picture import BLUE, FAINT, GREEN, INK, ORANGE, PINK, RED, SKY, Picture, new_figure


def agent_loop(*, agent="mouse", environment="maze"):
    """The agent-environment loop (after Sutton & Barto, 2nd ed., figure 3.1)."""
    figure, axes = _canvas(7.6, 3.0)
    _box(axes, 0.5, 0.76, 0.34, f"agent\n({agent})", SKY)
    _box(axes, 0.5, 0.22, 0.34, f"environment\n({environment})", ORANGE)
    _bend(axes, [(0.67, 0.76), (0.86, 0.76), (0.86, 0.22), (0.67, 0.22)], BLUE)
    _write(axes, 0.88, 0.5, "action: what it does", ha="left")
    _bend(axes, [(0.33, 0.22), (0.14, 0.22), (0.14, 0.76), (0.33, 0.76)], GREEN)
    _write(axes, 0.12, 0.5, "state: where it is\nreward: what it got", ha="right")
    alt = f"A loop: the agent ({agent}) sends an action to the environment ({environment});"
    return Picture(figure, f"{alt} the environment sends back a state and a reward.")


def method_chart():
    """Which kind of machine learning for which problem, by what is known and what it costs."""
    figure, axes = _canvas(8.0, 4.3)
    columns = ("small problem", "large problem: images, millions of states")
    rows = ("The answers\nare known:\nlearn from\nexamples.", "They are not:\nlearn from\nrewards.")
    cells = (
        ("classical machine learning", "little data, quick to train,\nless accurate", SKY),
        ("deep learning", "much data, slow to train,\nmore accurate", PINK),
        ("reinforcement learning", "a table, quick to train,\nexact for what it has seen", GREEN),
        ("deep reinforcement learning", "a network, slow to train,\nguesses what it has not seen", ORANGE),
    )
    for i, heading in enumerate(columns):
        _write(axes, 0.37 + 0.43 * i, 0.96, heading)
    for j, heading in enumerate(rows):
        _write(axes, 0.0, 0.68 - 0.46 * j, heading, ha="left")
    for k, (name, note, colour) in enumerate(cells):
        _box(axes, 0.37 + 0.43 * (k % 2), 0.68 - 0.46 * (k // 2), 0.41, name, colour, height=0.4, note=note)
    alt = (
        "A chart of four methods. Known answers, small problem: classical machine learning; known answers, large "
        "problem: deep learning; unknown answers, small problem: reinforcement learning; unknown answers, large "
        "problem: deep reinforcement learning."
    )
    return Picture(figure, alt)


def neural_network(layers=(4, 6, 3), names=("inputs", "hidden layer", "outputs")):
    """Nodes in layers, every weight a line: forward from left to right, backward from right to left."""
    figure, axes = _canvas(6.6, 3.4)
    rng = np.random.default_rng(0)
    across = np.linspace(0.16, 0.84, len(layers))
    apart = min(0.11, 0.72 / max(layers))
    thin = (apart / 0.11) ** 2  # many nodes stand closer, and are joined by finer lines
    places = [[(x, 0.5 + (i - (n - 1) / 2) * apart) for i in range(n)] for n, x in zip(layers, across, strict=True)]
    for here, there in pairwise(places):
        for (x, y), (x_next, y_next) in product(here, there):
            axes.plot([x, x_next], [y, y_next], color=FAINT, linewidth=(0.4 + 2 * rng.random()) * thin, zorder=1)
    for column, name in zip(places, names, strict=True):
        axes.scatter(*zip(*column, strict=True), s=190 * thin**0.7, color=SKY, edgecolor=INK, zorder=2)
        _write(axes, column[0][0], 0.08, name)
    _bend(axes, [(0.25, 0.93), (0.75, 0.93)], BLUE)
    _write(axes, 0.5, 0.98, "forward pass: numbers become an answer", fontsize=10)
    _bend(axes, [(0.75, 0.0), (0.25, 0.0)], RED)
    _write(axes, 0.5, -0.05, "backward pass: the error says how to change each weight", fontsize=10)
    axes.set_ylim(-0.09, 1.02)
    sizes = ", ".join(f"{name} {n}" for n, name in zip(layers, names, strict=True))
    return Picture(figure, f"A neural network, nodes in layers ({sizes}), each joined to all of the next by weights.")


def _write(axes, x, y, text, *, fontsize=11, ha="center", **look):
    axes.text(x, y, text, fontsize=fontsize, ha=ha, va="center", color=INK, **look)


def _canvas(width, height):
    figure, axes = new_figure(width, height)
    axes.set_xlim(0, 1.02)
    axes.set_ylim(0, 1)
    axes.axis("off")
    return figure, axes


def _box(axes, x, y, width, text, colour, *, height=0.3, note=""):
    from matplotlib.patches import FancyBboxPatch

    corner = (x - width / 2 + 0.02, y - height / 2 + 0.02)
    look = {"boxstyle": "round,pad=0.02", "facecolor": colour, "edgecolor": INK, "linewidth": 1.2, "alpha": 0.35}
    axes.add_patch(FancyBboxPatch(corner, width - 0.04, height - 0.04, **look))
    _write(axes, x, y + (0.08 if note else 0), text, fontweight="bold")
    _write(axes, x, y - 0.06, note, fontsize=9)


def _bend(axes, corners, colour):
    """A line through the corners with an arrow head at its end."""
    xs, ys = zip(*corners, strict=True)
    axes.plot(xs, ys, color=colour, linewidth=2.5, solid_joinstyle="round")
    look = {"arrowstyle": "-|>", "color": colour, "linewidth": 2.5, "mutation_scale": 20, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=corners[-1], xytext=corners[-2], arrowprops=look)
