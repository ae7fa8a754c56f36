"""A network looked at: its numbers on one forward pass, and what many trained ones say."""

import numpy as np

from course_lib.plots.picture import (
    BLUE,
    INK,
    ORANGE,
    PALETTE,
    RED,
    Picture,
    dress,
    new_figure,
)


def forward_pass(layers, inputs, *, input_names=None, output_names=None, title="", words=None):
    """One forward pass through a small network, every node with its number; lines are weight times what comes in.

    layers        [(weights float[n, m], biases float[m]), …], ReLU between them
    inputs        float[n]
    input_names   names of the inputs, by default their numbers; output_names likewise
    words         a text alternative of your own, where another processor may round the numbers otherwise
    """
    activations = [np.asarray(inputs, dtype=float)]
    for i, (weights, biases) in enumerate(layers):
        fed = activations[-1] @ weights + biases
        activations.append(np.maximum(fed, 0) if i < len(layers) - 1 else fed)
    most = max(len(column) for column in activations)
    figure, axes = new_figure(7.4, max(3.2, 0.3 * most + 0.9))
    axes.axis("off")
    axes.set_title(title, fontsize=12, color=INK, loc="left", pad=8)
    places = [0.5 + ((len(column) - 1) / 2 - np.arange(len(column))) / most for column in activations]
    for i, (weights, _) in enumerate(layers):
        _draw_weights(axes, i, places[i], places[i + 1], activations[i][:, None] * weights)
    for i, column in enumerate(activations):
        _draw_nodes(axes, i, places[i], column, last=i == len(layers))
    for i, names, side in ((0, input_names, -1), (len(layers), output_names, 1)):
        for place, name in zip(places[i], names or range(len(places[i])), strict=True):
            axes.text(
                i + side * 0.1, place, name, ha="left" if side > 0 else "right", va="center", fontsize=10, color=INK
            )
    headings = ["inputs", *["hidden (ReLU)"] * (len(layers) - 1), "outputs"]
    for i, heading in enumerate(headings):
        axes.text(i, 1.03, heading, ha="center", va="center", fontsize=10, color=INK)
    axes.set_xlim(-0.35, len(layers) + 0.4)
    axes.set_ylim(-0.02, 1.06)
    if words is None:
        shown = [str(name) for name in output_names or range(len(activations[-1]))]
        said = ", ".join(f"{name} {value:.2f}" for name, value in zip(shown, activations[-1], strict=True))
        silent = sum(int((column == 0).sum()) for column in activations[1:-1])
        hidden = sum(len(column) for column in activations[1:-1])
        words = f"{hidden - silent} of {hidden} hidden nodes let something through; the outputs are {said}."
    return Picture(figure, f"{title or 'A forward pass'}: {words}")


def _draw_weights(axes, i, here, there, flows):
    """Lines for what flows from layer i to the next: blue adds, orange and dashed takes away, the more the thicker."""
    largest = np.abs(flows).max() or 1.0
    for (j, k), flow in np.ndenumerate(flows):
        if abs(flow) > 0.02 * largest:
            axes.plot(
                [i, i + 1], [here[j], there[k]], color=BLUE if flow > 0 else ORANGE,
                linestyle="-" if flow > 0 else "--", linewidth=0.3 + 2.2 * abs(flow) / largest, alpha=0.75, zorder=1,
            )  # fmt: skip


def _draw_nodes(axes, i, places, values, *, last):
    from matplotlib import colormaps

    largest = np.abs(values).max() or 1.0
    for place, value in zip(places, values, strict=True):
        shade = colormaps["Blues" if value >= 0 else "Oranges"](0.08 + 0.5 * abs(value) / largest)
        axes.scatter([i], [place], s=430, color=[shade], edgecolor=INK, linewidth=0.8, zorder=2)
        text = f"{value:.0f}" if i == 0 and value in (0, 1) else f"{value:.2f}"
        bold = "bold" if last and value == values.max() else "normal"
        axes.text(i, place, text, ha="center", va="center", fontsize=7.5, color=INK, fontweight=bold, zorder=3)


def seed_by_seed(results, *, xlabel="", truth=None, title="", notes=None, words=None):
    """One dot an agent, one row a kind of agent, and a line at the median; results: {label: float[agents]}.

    truth: (words, number) to compare with, or None; notes: {label: words} for the right margin; words: a text
    alternative of your own, where another processor may round the numbers otherwise.
    """
    figure, axes = new_figure(7.4, 0.62 * len(results) + 1.5)
    rng, said = np.random.default_rng(0), []
    for i, (label, values) in enumerate(results.items()):
        values = np.asarray(values, dtype=float)
        lift = rng.uniform(-0.24, 0.24, len(values))
        axes.scatter(values, i + lift, s=16, color=PALETTE[i % len(PALETTE)], alpha=0.55, linewidth=0, zorder=2)
        axes.plot([np.median(values)] * 2, [i - 0.36, i + 0.36], color=INK, linewidth=2.2, zorder=3)
        said.append(f"{label}: median {np.median(values):.2f}, {np.min(values):.2f} to {np.max(values):.2f}")
        if notes:
            axes.annotate(
                notes[label], (1.01, i), xycoords=("axes fraction", "data"), va="center", fontsize=10, color=INK
            )
    if truth is not None:
        axes.axvline(truth[1], color=RED, linewidth=1.2, linestyle=":", zorder=1)
        place = {"xycoords": ("data", "axes fraction"), "xytext": (4, 4), "textcoords": "offset points"}
        axes.annotate(f"{truth[0]}: {truth[1]:.3g}", (truth[1], 0), fontsize=9, color=INK, **place)
    axes.set_yticks(range(len(results)), results)
    axes.set_ylim(len(results) - 0.4, -0.6)
    dress(axes, title=title, xlabel=xlabel)
    return Picture(figure, f"{title or 'One dot an agent'}: {words or '; '.join(said) + '.'}")
