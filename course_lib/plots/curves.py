"""Numbers over time, with the spread behind them."""

import numpy as np

from course_lib.plots.picture import INK, LINE_STYLES, PALETTE, Picture, dress, new_figure


def learning_curves(
    curves,
    *,
    band=(5, 95),
    xlabel="episode",
    ylabel="return of an episode",
    title="",
    truth=None,
    log=False,
    at=None,
    words=None,
):
    """Median over the agents and a band between two percentiles of them; curves: {label: float[E, N]}.

    truth: (words, number) to compare with, or None; log: a logarithmic scale upwards; at: where the N numbers stand, by
    default 1 to N; words: a text alternative of your own, for numbers that another processor may round otherwise. The
    picture says which band it shows.
    """
    figure, axes = new_figure(7.2, 3.8)
    ends = []
    for i, (label, runs) in enumerate(curves.items()):
        low, middle, high = np.percentile(np.atleast_2d(runs), [band[0], 50, band[1]], axis=0)
        places, marker = (np.arange(1, len(middle) + 1), None) if at is None else (at, "o")
        axes.fill_between(places, low, high, color=PALETTE[i], alpha=0.18, linewidth=0)
        axes.plot(places, middle, color=PALETTE[i], linestyle=LINE_STYLES[i], linewidth=2, marker=marker, label=label)
        ends.append(f"{label}: {middle[-1]:.2f} ({low[-1]:.2f} to {high[-1]:.2f})")
    if truth is not None:
        axes.axhline(truth[1], color=INK, linewidth=1, linestyle=":")
        place = {"xycoords": ("axes fraction", "data"), "xytext": (-4, 3), "textcoords": "offset points"}
        axes.annotate(f"{truth[0]}: {truth[1]:.3g}", (1, truth[1]), va="bottom", ha="right", color=INK, **place)
    if log:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
    agents = {np.atleast_2d(runs).shape[0] for runs in curves.values()}
    count = f"{agents.pop():,} agents" if len(agents) == 1 else "the agents"
    dress(axes, title=title, xlabel=xlabel, ylabel=ylabel, legend=True)
    note = f"line: median of {count}; band: {band[0]} % to {band[1]} % of them"
    axes.text(0, -0.26, note, transform=axes.transAxes, fontsize=9, color=INK)
    alt = f"{title or 'Learning curves'}, {ylabel} by {xlabel}, median of {count} and {band[0]} to {band[1]} % band."
    return Picture(figure, f"{alt} {words or 'At the end: ' + '; '.join(ends) + '.'}")


def contraction(errors, gamma, *, title=""):
    """Largest error after each sweep, on a log scale, against gamma^k times the first; errors: {label: float[K]}."""
    figure, axes = new_figure(7.2, 3.8)
    first = max(float(series[0]) for series in errors.values())
    longest = max(len(series) for series in errors.values())
    axes.semilogy(
        first * gamma ** np.arange(longest), color=INK, linewidth=1.5, linestyle=":", label=f"first error × {gamma}^k"
    )
    words = []
    for i, (label, series) in enumerate(errors.items()):
        series = np.asarray(series, dtype=float)
        shown = np.where(series > 0, series, np.nan)  # a log scale has no place for an error of exactly zero
        axes.semilogy(
            shown, color=PALETTE[i], linestyle=LINE_STYLES[i], marker="o", markersize=3, linewidth=2, label=label
        )
        words.append(f"{label}: from {series[0]:.2g} to {series[-1]:.2g} in {len(series) - 1} sweeps")
    dress(axes, title=title, xlabel="sweep k", ylabel="largest error of any state", legend=True)
    return Picture(
        figure, f"{title or 'Errors'}, log scale, against the first error times {gamma}^k. {'; '.join(words)}."
    )


def counts(series, at, total, *, xlabel="episodes", ylabel="agents", title="", words=None):
    """How many of `total` agents, at several times; series: {label: int[K]}, at: [K] times; words as above."""
    figure, axes = new_figure(7.2, 3.6)
    said = []
    for i, (label, numbers) in enumerate(series.items()):
        look = {"color": PALETTE[i], "linestyle": LINE_STYLES[i], "linewidth": 2, "marker": "o", "markersize": 5}
        axes.plot(at, numbers, label=f"{label}: {numbers[-1]} in the end", **look)
        said.append(f"{label}: {', '.join(str(number) for number in numbers)}")
    axes.set_ylim(0, total * 1.05)
    dress(axes, title=title, xlabel=xlabel, ylabel=f"{ylabel}, of {total}", legend=True)
    when = ", ".join(str(time) for time in at)
    return Picture(
        figure, f"{title or 'Counts'}, {ylabel} of {total} at {xlabel} {when}. {words or '; '.join(said) + '.'}"
    )
