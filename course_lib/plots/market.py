"""Prices and what traders made of them."""

import numpy as np

from course_lib.plots.board import readable_on
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
_COLOURS = "PuOr"  # of differences, as in the maze's heat maps: from orange over nothing to purple


def trades(part, positions=None, *, bars=None, title="", words=None):
    """Closes with entries and exits, and the position below; positions: int[N], or None for the prices alone.

    part    a `market.Part`;  bars: a slice of it to show, at least 2 bars, by default all
    words   a text alternative of your own, for trades that another processor may decide otherwise

    A position that is held when `bars` begin is no entry there. `ValueError` for other positions and other bars.
    """
    shown = _checked_bars(bars, len(part))
    dates, close = part.dates[shown], part.close.to_numpy(float)[shown]
    place = np.arange(len(close))
    if positions is None:
        figure, axes = new_figure(7.4, 3.2)
        axes.plot(place, close, color=INK, linewidth=1)
        dress(axes, title=title, ylabel="price")
        _say_dates(axes, dates)
        return Picture(figure, f"{title or 'Prices'}: {_course(close, dates)} {words or ''}")
    positions = _checked_positions(positions, len(part))
    before = np.append(0, positions[:-1])[shown]
    positions = positions[shown]
    figure, axes = new_figure(7.4, 4.3)
    figure.clf()
    axes, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [4, 1]})
    for part_of_it in (axes, below):
        part_of_it.set_facecolor(PAPER)
    axes.plot(place, close, color=INK, linewidth=1, zorder=1)
    longs, shorts, exits = ((positions == side) & (before != side) for side in (1, -1, 0))
    for changes, marker, colour, name in (
        (longs, "^", _LONG, "buy"),
        (shorts, "v", _SHORT, "sell"),
        (exits, "o", PAPER, "cash out"),
    ):
        look = {"color": colour, "edgecolor": INK, "linewidth": 0.7, "s": 34, "zorder": 3}
        axes.scatter(place[changes], close[changes], marker=marker, label=f"{name}: {changes.sum()}", **look)
    below.step(place, positions, where="post", color=INK, linewidth=0.8)
    for side, colour in ((1, _LONG), (-1, _SHORT)):
        held = np.where(positions == side, side, 0)
        below.fill_between(place, held, 0, step="post", color=colour, alpha=0.5, linewidth=0)
    below.set_yticks([-1, 0, 1], ["short", "flat", "long"])
    below.set_ylim(-1.25, 1.25)
    dress(axes, title=title, ylabel="price")
    dress(below)
    _say_dates(below, dates)
    _legend_below(figure, axes)
    entries = f"{_times(longs.sum())} long and {_times(shorts.sum())} short"
    held = f"in the market on {np.mean(positions != 0):.0%} of the bars"
    return Picture(figure, f"{title or 'Trades'}: {_course(close, dates)} {words or f'{entries}, {held}.'}")


def _checked_bars(bars, num_bars):
    """`bars` as a slice of so many, or a `ValueError`."""
    try:
        shown = range(num_bars)[slice(None) if bars is None else bars]
        if shown.step == 1 and len(shown) >= 2:
            return slice(shown.start, shown.stop)
    except (AttributeError, TypeError, IndexError):
        pass
    raise ValueError(
        f"bars must be a slice, such as slice(0, 250), of 2 or more of {num_bars} bars in turn, got {bars}"
    )


def _checked_positions(positions, num_bars):
    positions = np.asarray(positions)
    if positions.shape != (num_bars,) or not np.isin(positions, (-1, 0, 1)).all():
        raise ValueError(
            f"positions must be those of one trader, -1, 0 or 1 for each of {num_bars} bars, got "
            f"{positions.dtype}{[*positions.shape]}"
        )
    return positions


def _say_dates(axes, dates):
    """Bars as dates, at five places or as many as there are."""
    places = np.unique(np.linspace(0, len(dates) - 1, 5).round().astype(int))
    axes.set_xticks(places, [_when(dates, i, "\n") for i in places])
    axes.set_xlabel("date")


def _when(dates, i, between=" "):
    """A date, with its time where the bars are parts of days."""
    time = "" if (dates == dates.normalize()).all() else f"{between}{dates[i]:%H:%M}"
    return f"{dates[i]:%Y-%m-%d}{time}"


def _course(close, dates):
    first, last, low, high = (_rounded(price, 4) for price in (close[0], close[-1], close.min(), close.max()))
    days = f"from {_when(dates, 0)} to {_when(dates, -1)}"
    return f"closes {days}, {first} at first, {last} at last, between {low} and {high}."


def _rounded(number, digits=3):
    """So many digits that count, written out: 22,000, 0.000001; what is beyond a billion as 7.2e+10."""
    rounded = float(f"{number:.{digits}g}")
    if rounded < 1000:
        return np.format_float_positional(rounded, trim="-")
    return f"{rounded:,.12g}" if rounded < 1e9 else f"{rounded:g}"


def _times(count):
    return f"{count} time{'' if count == 1 else 's'}"


def _legend_below(figure, axes, note=None):
    """The legend under the picture, which grows by it, so that it hides nothing; above it what `note` says."""
    handles, names = axes.get_legend_handles_labels()
    columns = max(1, min(3, 84 // (max(map(len, names)) + 6)))
    rows = -(-len(names) // columns) + (note is not None)
    figure.set_figheight(figure.get_figheight() + 0.12 + 0.2 * rows)
    legend = figure.legend(
        handles, names, loc="outside lower left", ncols=columns, fontsize=10, frameon=False, labelcolor=INK,
        title=note, title_fontsize=9, alignment="left",
    )  # fmt: skip
    legend.get_title().set_color(INK)


def wealth(part, log_equity, *, band=(5, 95), title="", words=None):
    """What 1 unit of money becomes, on a log scale; log_equity: {name: float64[N] or float64[E, N]}.

    Of several agents it shows the median and a band between two percentiles. words: a text alternative of your own.
    `ValueError` for another number of bars than the part has.
    """
    curves = {name: np.atleast_2d(np.asarray(runs, float)) for name, runs in log_equity.items()}
    for name, runs in curves.items():
        if runs.ndim != 2 or runs.shape[1] != len(part):
            raise ValueError(f"log_equity of {name} must have {len(part)} bars, as the part, got {[*runs.shape]}")
    if not curves:
        raise ValueError("log_equity must hold one trader or more, got none")
    figure, axes = new_figure(7.4, 3.8)
    ends, place = [], np.arange(len(part))
    for i, (name, runs) in enumerate(curves.items()):
        low, middle, high = np.percentile(runs, [band[0], 50, band[1]], axis=0)
        colour, style = PALETTE[i % len(PALETTE)], LINE_STYLES[(i + i // len(PALETTE)) % len(LINE_STYLES)]
        if len(runs) > 1:
            axes.fill_between(place, low, high, color=colour, alpha=0.18, linewidth=0)
        look = {"color": colour, "linestyle": style, "linewidth": 1.8}
        axes.plot(place, middle, label=f"{name}: ×{_rounded(np.exp(middle[-1]))}", **look)
        last, least, most = (_rounded(np.exp(curve[-1])) for curve in (middle, low, high))
        ends.append(f"{name}: {last} ({least} to {most})" if len(runs) > 1 else f"{name}: {last}")
    axes.axhline(0, color=FAINT, linewidth=1)
    levels = _levels(*axes.get_ylim())
    axes.set_yticks(np.log(levels), [_rounded(level, 6) for level in levels])
    dress(axes, title=title, ylabel="money (log scale)")
    _say_dates(axes, part.dates)
    note = agents = None
    if several := sorted({len(runs) for runs in curves.values()} - {1}):
        agents = f"{' or '.join(map(str, several))} traders"
        note = f"lines: medians of {agents}; bands: {band[0]} % to {band[1]} % of them"
    _legend_below(figure, axes, note)
    said = f"In the end {'; '.join(ends)}"
    if agents:
        said += f", medians of {agents} and in brackets {band[0]} % to {band[1]} % of them"
    return Picture(figure, f"{title or 'Money'}, log scale, by date. {words or said + '.'}")


def _levels(low, high):
    """Round amounts of money between two logs of it, for the ticks: as many as stand apart, 1 among them if it can."""
    least, most = np.exp([low, high])
    steps = [step * size for size in (0.0001, 0.001, 0.01, 0.1) for step in (1, 2, 5)]
    decades = np.arange(np.floor(low / np.log(10)), np.ceil(high / np.log(10)) + 1)
    finest = [s * np.arange(np.ceil(least / s), np.floor(most / s) + 1) for s in steps if (most - least) / s < 100]
    finest += [np.multiply.outer(10.0**decades, digits).ravel() for digits in ((1, 2, 5), (1, 3))]
    finest += [10.0 ** decades[decades % every == 0] for every in range(1, 1 + len(decades))]
    for levels in finest:
        levels = levels[(levels >= least) & (levels <= most)]
        if len(levels) and np.diff(np.log(levels)).min(initial=np.inf) >= (high - low) / 10:
            return levels
    return np.ones(1)


def in_and_out(sharpe, *, title="", words=None):
    """A dot a seed: what it reached on days it learned from against days it never saw.

    sharpe  {name: (in sample float64[E], out of sample float64[E])}; `ValueError` where there is nothing, or not a pair
    """
    pairs = {name: [np.asarray(days, float).ravel() for days in both] for name, both in sharpe.items()}
    if not pairs or not all(len(both) == 2 and len(both[0]) == len(both[1]) > 0 for both in pairs.values()):
        sizes = {name: [len(days) for days in both] for name, both in pairs.items()}
        raise ValueError(f"sharpe must hold two arrays of one length for each name, got lengths {sizes}")
    figure, axes = new_figure(7.0, 4.1)
    said, markers = [], "os^DvP*X"
    for i, (name, (inside, outside)) in enumerate(pairs.items()):
        look = {"color": PALETTE[i % len(PALETTE)], "alpha": 0.7, "s": 30, "linewidth": 0}
        axes.scatter(inside, outside, marker=markers[i % len(markers)], label=name, **look)
        said.append(f"{name}: {inside.mean():.1f} inside, {outside.mean():.1f} outside")
    least = min(0.0, *(np.min(both) for both in pairs.values()))
    most = max(1.0, *(np.max(both) for both in pairs.values()))
    axes.plot([least, most], [least, most], color=FAINT, linestyle=":", label="as good on unseen days")
    axes.axhline(0, color=INK, linewidth=0.8)
    dress(axes, title=title, xlabel="Sharpe ratio on the training days", ylabel="Sharpe ratio on unseen days")
    _legend_below(figure, axes)
    words = words or f"Means: {'; '.join(said)}."
    return Picture(figure, f"{title or 'Inside and outside'}, Sharpe ratios, one dot a seed. {words}")


def grid_of_states(advantage, *, visits=None, n=None, xlabel="bars since the opposite extreme", title="", words=None):
    """A table over n × n states drawn as the maze is: what opening is worth more than staying out, by long and short.

    advantage  (long, short), each float64[n * n], state = row * n + column, row 0 the lowest price: at the bottom
    visits     int[n * n], how often each state has been seen; unseen ones stay empty
    ▲ buy, ▼ sell where it is worth it, else a dot; the colour says how much, in basis points of the money.
    `ValueError` for another number of states.
    """
    import seaborn

    long, short = (np.asarray(side, dtype=float).ravel() * 1e4 for side in advantage)
    n = round(np.sqrt(len(long))) if n is None else n
    visits = np.ones(n * n) if visits is None else np.asarray(visits).ravel()
    if {len(long), len(short), len(visits)} != {n * n}:
        sizes = f"{len(long)} for long, {len(short)} for short and {len(visits)} for visits"
        raise ValueError(f"a grid of {n} × {n} states needs {n * n} numbers of each kind, got {sizes}")
    best = np.select([long > short, short > long], [long, -short])  # upwards to buy, downwards to sell, as in `trade`
    best = np.where(np.maximum(long, short) > 0, best, 0.0).reshape(n, n)
    seen = visits.reshape(n, n) > 0
    figure, axes = new_figure(max(5.2, 0.62 * n + 2.2), max(3.9, 0.56 * n + 1.0))
    worth = np.abs(best[seen & (best != 0)])
    bound = np.percentile(worth, 95) if worth.size else 1.0
    scale = {"label": "advantage of opening (basis points)\nbelow 0: of selling"}
    scale["extend"] = "both" if worth.size and worth.max() > bound else "neither"
    seaborn.heatmap(
        best[::-1], ax=axes, mask=~seen[::-1], cmap=_COLOURS, vmin=-bound, vmax=bound, linewidths=1.5, linecolor=PAPER,
        cbar_kws=scale,
    )  # fmt: skip
    ink = readable_on(_COLOURS, -bound, bound)
    for row, column in np.argwhere(seen):
        value = best[row, column]
        sign = "▲" if value > 0 else "▼" if value < 0 else "·"
        look = {"ha": "center", "va": "center", "fontsize": 11 if value else 16, "color": ink(value)}
        axes.text(column + 0.5, n - row - 0.5, sign, **look)
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
