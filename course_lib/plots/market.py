"""Prices and what traders made of them."""

import numpy as np

from course_lib.plots.picture import (
    BLUE,
    FAINT,
    INK,
    LINE_STYLES,
    PALETTE,
    PAPER,
    RED,
    Picture,
    dress,
    new_figure,
)

_LONG, _SHORT = BLUE, RED
_LEVELS = (0.1, 0.2, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3, 5, 10, 20, 50, 100, 1000)


def trades(part, positions=None, *, bars=None, title="", words=None):
    """Closes with entries and exits, and the position below; positions: int[N], or None for the prices alone.

    part    a `market.Part`;  bars: a slice of it to show, by default all
    words   a text alternative of your own, for trades that another processor may decide otherwise
    """
    shown = slice(None) if bars is None else bars
    dates, close = part.dates[shown], part.close.to_numpy(float)[shown]
    figure, axes = new_figure(7.4, 3.2 if positions is None else 4.4)
    place = np.arange(len(close))
    if positions is None:
        axes.plot(place, close, color=INK, linewidth=1)
        dress(axes, title=title, xlabel="bar", ylabel="price")
        _say_dates(axes, dates)
        return Picture(figure, f"{title or 'Prices'}: {_course(close, dates)}")
    positions = np.asarray(positions)[shown]
    figure.clf()
    axes, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [4, 1]})
    for part_of_it in (axes, below):
        part_of_it.set_facecolor(PAPER)
    axes.plot(place, close, color=INK, linewidth=1, zorder=1)
    before = np.concatenate([[0], positions[:-1]])
    for changes, marker, colour, name in (
        ((positions == 1) & (before != 1), "^", _LONG, "buy"),
        ((positions == -1) & (before != -1), "v", _SHORT, "sell"),
        ((positions == 0) & (before != 0), "o", PAPER, "cash out"),
    ):
        look = {"color": colour, "edgecolor": INK, "linewidth": 0.7, "s": 34, "zorder": 3}
        axes.scatter(place[changes], close[changes], marker=marker, label=f"{name}: {changes.sum()}", **look)
    below.step(place, positions, where="post", color=INK, linewidth=0.8)
    below.fill_between(place, positions, 0, where=positions > 0, step="post", color=_LONG, alpha=0.5, linewidth=0)
    below.fill_between(place, positions, 0, where=positions < 0, step="post", color=_SHORT, alpha=0.5, linewidth=0)
    below.set_yticks([-1, 0, 1], ["short", "flat", "long"])
    below.set_ylim(-1.25, 1.25)
    dress(axes, title=title, ylabel="price", legend=True)
    dress(below, xlabel="bar")
    _say_dates(below, dates)
    longs, shorts = (int(((positions == side) & (before != side)).sum()) for side in (1, -1))
    entries = f"{longs} times long and {shorts} times short"
    held = f"in the market on {np.mean(positions != 0):.0%} of the bars"
    return Picture(figure, f"{title or 'Trades'}: {_course(close, dates)} {words or f'{entries}, {held}.'}")


def _say_dates(axes, dates):
    """Bars as dates, at five places."""
    places = np.linspace(0, len(dates) - 1, 5).round().astype(int)
    axes.set_xticks(places, [f"{dates[i]:%Y-%m-%d}" for i in places])
    axes.set_xlabel("date")


def _course(close, dates):
    return (
        f"closes from {dates[0]:%Y-%m-%d} to {dates[-1]:%Y-%m-%d}, {close[0]:.4g} at first, {close[-1]:.4g} at last, "
        f"between {close.min():.4g} and {close.max():.4g}."
    )


def wealth(part, log_equity, *, band=(5, 95), title="", words=None):
    """What 1 unit of money becomes, on a log scale; log_equity: {name: float64[N] or float64[E, N]}.

    Of several agents it shows the median and a band between two percentiles. words: a text alternative of your own.
    """
    figure, axes = new_figure(7.4, 3.9)
    ends, lowest, highest, agents = [], 0.0, 0.0, set()
    for i, (name, curves) in enumerate(log_equity.items()):
        curves = np.atleast_2d(curves)
        low, middle, high = np.percentile(curves, [band[0], 50, band[1]], axis=0)
        colour, place = PALETTE[i % len(PALETTE)], np.arange(len(middle))
        if len(curves) > 1:
            axes.fill_between(place, low, high, color=colour, alpha=0.18, linewidth=0)
            agents.add(len(curves))
        look = {"color": colour, "linestyle": LINE_STYLES[i % len(LINE_STYLES)], "linewidth": 1.8}
        axes.plot(place, middle, label=f"{name}: ×{np.exp(middle[-1]):.3g}", **look)
        lowest, highest = min(lowest, low.min()), max(highest, high.max())
        spread = f" ({np.exp(low[-1]):.3g} to {np.exp(high[-1]):.3g})" if len(curves) > 1 else ""
        ends.append(f"{name}: {np.exp(middle[-1]):.3g}{spread}")
    axes.axhline(0, color=FAINT, linewidth=1)
    levels = [level for level in _LEVELS if lowest - 0.05 <= np.log(level) <= highest + 0.05]
    axes.set_yticks(np.log(levels), [f"{level:g}" for level in levels])
    dress(axes, title=title, ylabel="money (log scale)", legend=True)
    _say_dates(axes, part.dates)
    if agents:
        count = " or ".join(str(number) for number in sorted(agents))
        note = f"lines: medians of {count} traders; bands: {band[0]} % to {band[1]} % of them"
        axes.text(0, -0.27, note, transform=axes.transAxes, fontsize=9, color=INK)
    return Picture(figure, f"{title or 'Money'}, log scale, by date. {words or 'In the end ' + '; '.join(ends) + '.'}")


def in_and_out(sharpe, *, title="", words=None):
    """A dot a seed: what it reached on days it learned from against days it never saw.

    sharpe  {name: (in sample float64[E], out of sample float64[E])}
    """
    figure, axes = new_figure(7.0, 4.2)
    said, markers = [], "os^DvP*X"
    for i, (name, (inside, outside)) in enumerate(sharpe.items()):
        inside, outside = np.asarray(inside, float), np.asarray(outside, float)
        look = {"color": PALETTE[i % len(PALETTE)], "alpha": 0.7, "s": 30, "linewidth": 0}
        axes.scatter(inside, outside, marker=markers[i % len(markers)], label=name, **look)
        said.append(f"{name}: {inside.mean():.1f} inside, {outside.mean():.1f} outside")
    least = min(0.0, *(np.min(pair) for pair in sharpe.values()))
    most = max(1.0, *(np.max(pair) for pair in sharpe.values()))
    axes.plot([least, most], [least, most], color=FAINT, linestyle=":", label="as good on unseen days")
    axes.axhline(0, color=INK, linewidth=0.8)
    dress(axes, title=title, xlabel="Sharpe ratio on the training days", ylabel="on unseen days", legend=True)

    words = words or f"Means: {'; '.join(said)}."
    return Picture(figure, f"{title or 'Inside and outside'}, Sharpe ratios, one dot a seed. {words}")


def grid_of_states(advantage, *, visits=None, n=None, xlabel="bars since the opposite extreme", title="", words=None):
    """A table over n × n states drawn as the maze is: what opening is worth more than staying out, by long and short.

    advantage  (long, short), each float64[n * n], state = row * n + column, row 0 the lowest price: at the bottom
    visits     int[n * n], how often each state has been seen; unseen ones stay empty
    ▲ buy, ▼ sell where it is worth it, else a dot; the colour says how much, in basis points of the money.
    """
    import seaborn

    long, short = (np.asarray(side, dtype=float) * 1e4 for side in advantage)
    n = round(np.sqrt(len(long))) if n is None else n
    best = np.where(long >= short, long, -short)  # blue upwards to buy, orange downwards to sell
    best = np.where(np.maximum(long, short) > 0, best, 0.0).reshape(n, n)
    seen = np.ones((n, n), bool) if visits is None else np.asarray(visits).reshape(n, n) > 0
    figure, axes = new_figure(0.62 * n + 2.2, 0.56 * n + 1.0)
    bound = max(1e-9, np.percentile(np.abs(best[seen]), 95)) if seen.any() else 1.0
    seaborn.heatmap(
        best[::-1], ax=axes, mask=~seen[::-1], cmap="PuOr", vmin=-bound, vmax=bound, linewidths=1.5, linecolor=PAPER,
        cbar_kws={"label": "advantage of opening (basis points)\nbelow 0: of selling"},
    )  # fmt: skip
    for row, column in np.argwhere(seen):
        sign = "▲" if best[row, column] > 0 else "▼" if best[row, column] < 0 else "·"
        strong = abs(best[row, column]) > 0.6 * bound
        axes.text(column + 0.5, n - row - 0.5, sign, ha="center", va="center", color="white" if strong else INK)
    axes.set_yticks(np.arange(n) + 0.5, np.arange(n)[::-1], rotation=0)
    axes.set_xticks(np.arange(n) + 0.5, np.arange(n), rotation=0)
    axes.set_xlabel(f"column: {xlabel}", fontsize=10, color=INK)
    axes.set_ylabel("row: price, low to high", fontsize=10, color=INK)
    axes.tick_params(length=0, colors=INK)
    axes.set_title(title, fontsize=12, color=INK, loc="left", pad=8)
    buys, sells = (np.argwhere(seen & (best * sign > 0))[:, 0] for sign in (1, -1))
    said = f"{len(buys)} states say buy, {len(sells)} sell, {int((~seen).sum())} were never seen."
    if len(buys) and len(sells):
        said += f" The mean row of those that buy is {buys.mean():.1f}, of those that sell {sells.mean():.1f}."
    return Picture(figure, f"{title or 'A table on a grid'}: {words or said}")
