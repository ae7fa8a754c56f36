"""What many seeds say together: bands, intervals, and a grid of settings."""

import numpy as np

from course_lib.plots.board import readable_on
from course_lib.plots.picture import INK, LINE_STYLES, PALETTE, PAPER, RED, Picture, dress, new_figure

_CLOSE, _NOTE = (
    {"xytext": (4, 4), "textcoords": "offset points"},
    "line: interquartile mean; band: 95 % of its bootstrap",
)


def bands(estimates, *, at=None, xlabel="episode", ylabel="return of an episode", title="", note=_NOTE, words=None):
    """A line and the interval around it; estimates: {label: (middle, low, high)}, each float64[N].

    They are `Results.bands` of a study. at: where the N numbers stand, by default 1 to N; note: what line and band are;
    words: a text alternative of your own.
    """
    figure, axes = new_figure(7.2, 3.8)
    said = []
    for i, (label, (middle, low, high)) in enumerate(estimates.items()):
        places, colour = np.arange(1, len(middle) + 1) if at is None else at, PALETTE[i % len(PALETTE)]
        axes.fill_between(places, low, high, color=colour, alpha=0.22, linewidth=0)
        axes.plot(places, middle, color=colour, linestyle=LINE_STYLES[i % len(LINE_STYLES)], linewidth=2, label=label)
        said.append(f"{label}: {middle[-1]:.3f} ({low[-1]:.3f} to {high[-1]:.3f})")
    dress(axes, title=title, xlabel=xlabel, ylabel=ylabel, legend=True)
    axes.text(0, -0.26, note, transform=axes.transAxes, fontsize=9, color=INK)
    alt = f"{title or 'Bands'}, {ylabel} by {xlabel}, {note}."
    return Picture(figure, f"{alt} {words or 'At the end: ' + '; '.join(said) + '.'}")


def intervals(estimates, *, xlabel="", truth=None, title="", words=None):
    """A dot and its interval, a row each; estimates: {label: (middle, low, high)}, in floats.

    truth: (words, number) to compare with, or None; words: a text alternative of your own.
    """
    figure, axes = new_figure(7.4, (0.42 if len(estimates) < 12 else 0.24) * len(estimates) + 1.5)
    said = []
    for i, (label, (middle, low, high)) in enumerate(estimates.items()):
        axes.plot([low, high], [i, i], color=PALETTE[0], linewidth=5, alpha=0.35, solid_capstyle="butt")
        axes.plot([middle], [i], color=PALETTE[0], marker="o", markersize=6)
        said.append(f"{label}: {middle:.3f} ({low:.3f} to {high:.3f})")
    if truth is not None:
        axes.axvline(truth[1], color=RED, linewidth=1.2, linestyle=":", zorder=1)
        axes.annotate(
            f"{truth[0]}: {truth[1]:.3g}", (truth[1], 0), xycoords=("data", "axes fraction"), color=INK, **_CLOSE
        )
    axes.set_yticks(range(len(estimates)), estimates)
    axes.set_ylim(len(estimates) + (0.2 if truth else -0.4), -0.6)  # room for the words about the truth
    dress(axes, title=title, xlabel=xlabel)
    return Picture(figure, f"{title or 'Intervals'}: {words or '; '.join(said) + '.'}")


def heat_map(values, rows, columns, *, xlabel="", ylabel="", label="", title="", words=None):
    """A number in each field of a grid, and a colour for it; values: float64[len(rows), len(columns)].

    label: what the numbers are; words: a text alternative of your own. `ValueError` for values of another shape.
    """
    import seaborn

    values = np.asarray(values, dtype=float)
    if values.shape != (len(rows), len(columns)):
        raise ValueError(f"values must be [{len(rows)}, {len(columns)}], got {[*values.shape]}")
    figure, axes = new_figure(0.95 * len(columns) + 2.2, 0.55 * len(rows) + 1.5)
    look = {"cmap": "cividis", "linewidths": 1.5, "linecolor": PAPER, "cbar_kws": {"label": label}}
    seaborn.heatmap(values, ax=axes, xticklabels=list(columns), yticklabels=list(rows), **look)
    ink = readable_on("cividis", values.min(), values.max())
    for (i, j), value in np.ndenumerate(values):
        axes.text(j + 0.5, i + 0.5, f"{value:.3f}", ha="center", va="center", fontsize=9.5, color=ink(value))
    axes.set_xlabel(xlabel, fontsize=11, color=INK)
    axes.set_ylabel(ylabel, fontsize=11, color=INK)
    axes.tick_params(length=0, colors=INK, labelrotation=0)
    axes.set_title(title, fontsize=12, color=INK, loc="left", pad=10)
    best = np.unravel_index(values.argmax(), values.shape)
    where = f"{ylabel} {rows[best[0]]} and {xlabel} {columns[best[1]]}"
    said = f"largest {values.max():.3f} at {where}, least {values.min():.3f}."
    return Picture(figure, f"{title or 'A grid of settings'}, {label}: {words or said}")
