"""Pictures of the market say what happened: marks at their bars, areas under what is held, words with the numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from market_worlds import seldom
from matplotlib.markers import MarkerStyle

from course_lib import market, plots
from course_lib.plots.picture import BLUE, RED

TEST = market.split(market.RubberBandMarket().prices(700, seed=3)).test
CLOSE = TEST.close.to_numpy()
SHAPES = {"buy": "^", "sell": "v", "cash out": "o"}


def short_part(bars):
    return market.Part("test", TEST.prices, len(TEST.prices) - bars)


def some_positions(seed=0, bars=140):
    """Positions held for 1 to 6 bars each."""
    rng = np.random.default_rng(seed)
    return np.repeat(rng.integers(-1, 2, bars), rng.integers(1, 7, bars))[:bars]


def changes(positions, begins=0, ends=None):
    """{name: bars at which a position of that kind is entered}, of the bars shown, counted from the first of them."""
    found, held = {name: [] for name in SHAPES}, 0
    for bar, position in enumerate(positions):
        if position != held and begins <= bar < (len(positions) if ends is None else ends):
            found[{1: "buy", -1: "sell", 0: "cash out"}[position]].append(bar - begins)
        held = position
    return found


def marks(picture):
    """{name: [(bar, price), …]} of the marks, after a look at their shapes."""
    found = {}
    for kind in picture.figure.axes[0].collections:
        name, count = kind.get_label().split(": ")
        shape = MarkerStyle(SHAPES[name])
        expected = shape.get_path().transformed(shape.get_transform()).vertices
        assert np.array_equal(kind.get_paths()[0].vertices, expected)
        assert int(count) == len(kind.get_offsets())
        found[name] = [tuple(place) for place in kind.get_offsets().tolist()]
    return found


def areas(picture):
    """{colour: [whether it fills the half above, below 0] after each bar shown but the last}."""
    axes, found = picture.figure.axes[1], {}
    last = int(axes.lines[0].get_xdata()[-1])
    for kind in axes.collections:
        colour = tuple(np.round(kind.get_facecolor()[0][:3], 3))
        filled = [
            [any(path.contains_point((bar + 0.5, y)) for path in kind.get_paths()) for y in (0.5, -0.5)]
            for bar in range(last)
        ]
        found[colour] = filled
    return found


def percentile(values, share):
    """By hand: the place between two neighbours of the sorted values."""
    values, place = sorted(values), share / 100 * (len(values) - 1)
    below = int(place)
    above = min(below + 1, len(values) - 1)
    return values[below] + (place - below) * (values[above] - values[below])


# --- trades -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bars", [None, slice(0, 60), slice(35, 90), slice(100, None), slice(-20, None), slice(7, 9)])
def test_every_entry_and_exit_has_its_mark_at_its_bar_and_price_and_no_other(bars):
    positions = some_positions()
    begins, ends, _ = (bars or slice(None)).indices(len(TEST))
    picture = plots.trades(TEST, positions, bars=bars)
    expected = changes(positions, begins, ends)
    assert marks(picture) == {name: [(bar, CLOSE[begins + bar]) for bar in places] for name, places in expected.items()}
    price = picture.figure.axes[0].lines[0]
    assert price.get_xdata().tolist() == list(range(ends - begins))
    assert price.get_ydata().tolist() == CLOSE[begins:ends].tolist()
    held = sum(position != 0 for position in positions[begins:ends])
    for words in (
        f"{len(expected['buy'])} time{'s' * (len(expected['buy']) != 1)} long and",
        f"and {len(expected['sell'])} time{'s' * (len(expected['sell']) != 1)} short",
        f"in the market on {100 * held / (ends - begins):.0f}% of the bars.",
        f"from {TEST.dates[begins]:%Y-%m-%d} to {TEST.dates[ends - 1]:%Y-%m-%d}",
        f"{CLOSE[begins]:.4g} at first, {CLOSE[ends - 1]:.4g} at last",
        f"between {min(CLOSE[begins:ends]):.4g} and {max(CLOSE[begins:ends]):.4g}.",
    ):
        assert words in picture.alt


def test_what_is_held_when_the_shown_bars_begin_is_no_entry():
    positions = np.ones(len(TEST), int)
    assert marks(plots.trades(TEST, positions))["buy"] == [(0, CLOSE[0])]
    picture = plots.trades(TEST, positions, bars=slice(10, 30))
    assert marks(picture) == {"buy": [], "sell": [], "cash out": []}
    assert "0 times long and 0 times short, in the market on 100% of the bars." in picture.alt


@pytest.mark.parametrize("bars", [slice(None), slice(3, 5), slice(0, 40)])
def test_the_area_below_lies_under_every_bar_that_is_held_on_the_side_that_is_held(bars):
    """Also under positions of a single bar, and up to the very bar at which they are given up."""
    positions = some_positions(1)
    picture = plots.trades(TEST, positions, bars=bars)
    line, shown = picture.figure.axes[1].lines[0], positions[bars]
    assert (line.get_drawstyle(), line.get_ydata().tolist()) == ("steps-post", shown.tolist())
    blue, red = (tuple(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)) for colour in (BLUE, RED))
    expected = {blue: [[p == 1, False] for p in shown[:-1]], red: [[False, p == -1] for p in shown[:-1]]}
    assert areas(picture) == {tuple(np.round(colour, 3)): filled for colour, filled in expected.items()}
    assert [label.get_text() for label in picture.figure.axes[1].get_yticklabels()] == ["short", "flat", "long"]


def test_who_never_trades_has_no_marks_and_no_area():
    picture = plots.trades(TEST, market.flat(TEST))
    assert not any(marks(picture).values())
    assert not np.any(list(areas(picture).values()))
    assert "0 times long and 0 times short, in the market on 0% of the bars." in picture.alt


def test_prices_alone_have_neither_marks_nor_positions():
    picture = plots.trades(TEST, bars=slice(5, 25))
    (axes,) = picture.figure.axes
    assert axes.lines[0].get_ydata().tolist() == CLOSE[5:25].tolist()
    assert not axes.collections
    assert not picture.figure.legends
    assert "long" not in picture.alt


@pytest.mark.parametrize("bars", [2, 3, 4, 5, 6, 50])
@pytest.mark.parametrize("positions", [False, True])
def test_dates_stand_under_their_bars_each_once(bars, positions):
    part = short_part(bars)
    picture = plots.trades(part, some_positions(2, bars) if positions else None)
    axis = picture.figure.axes[-1].xaxis
    places = axis.get_ticklocs().tolist()
    assert len(set(places)) == len(places) == min(bars, 5)
    assert (places[0], places[-1]) == (0, bars - 1)
    assert [label.get_text() for label in axis.get_ticklabels()] == [f"{part.dates[int(i)]:%Y-%m-%d}" for i in places]


def test_bars_of_a_day_have_their_time():
    part = market.split(market.DayGridMarket().prices(400, seed=0)).test
    picture = plots.trades(part, bars=slice(0, 5))
    labels = [label.get_text() for label in picture.figure.axes[0].get_xticklabels()]
    assert labels == [f"{date:%Y-%m-%d}\n{date:%H:%M}" for date in part.dates[:5]]
    assert f"from {part.dates[0]:%Y-%m-%d %H:%M} to {part.dates[4]:%Y-%m-%d %H:%M}," in picture.alt


# --- wealth -----------------------------------------------------------------------------------------------------------


def curves(traders, seed=0, sigma=0.02):
    rng = np.random.default_rng(seed)
    return np.cumsum(sigma * rng.standard_normal((traders, len(TEST))), axis=1)


@pytest.mark.parametrize("band", [(5, 95), (20, 70)])
def test_of_several_traders_wealth_shows_the_median_and_the_band_it_names(band):
    runs, hold = curves(7), curves(1, seed=1)[0]
    picture = plots.wealth(TEST, {"hold": hold, "network": runs}, band=band)
    axes = picture.figure.axes[0]
    alone, median = axes.lines[:2]
    assert alone.get_ydata().tolist() == hold.tolist()
    by_bar = runs.T.tolist()
    assert median.get_ydata() == pytest.approx([sorted(values)[3] for values in by_bar])
    (drawn,) = axes.collections
    edges = {}
    for bar, height in drawn.get_paths()[0].vertices:
        edges.setdefault(round(bar), []).append(height)
    for edge, share in zip((min, max), band, strict=True):
        assert [edge(edges[bar]) for bar in range(len(TEST))] == pytest.approx(
            [percentile(values, share) for values in by_bar]
        )
    legend = picture.figure.legends[0]
    note = f"lines: medians of 7 traders; bands: {band[0]} % to {band[1]} % of them"
    assert legend.get_title().get_text() == note
    last = [np.exp(percentile(by_bar[-1], share)) for share in (50, *band)]
    names = [f"hold: ×{np.exp(hold[-1]):.3g}", f"network: ×{last[0]:.3g}"]
    assert [text.get_text() for text in legend.get_texts()] == names
    end = (
        f"In the end hold: {np.exp(hold[-1]):.3g}; network: {last[0]:.3g} ({last[1]:.3g} to {last[2]:.3g}), medians of"
    )
    assert f"{end} 7 traders and in brackets {band[0]} % to {band[1]} % of them." in picture.alt


def test_single_traders_have_no_band_and_no_note():
    picture = plots.wealth(TEST, {"hold": curves(1)[0], "network": curves(1)})
    assert not picture.figure.axes[0].collections
    assert picture.figure.legends[0].get_title().get_text() in ("", "None")
    assert "median" not in picture.alt


def test_traders_of_several_numbers_are_counted():
    picture = plots.wealth(TEST, {"a": curves(3), "b": curves(5), "c": curves(3)})
    assert "medians of 3 or 5 traders" in picture.alt


@seldom
@given(lowest=st.floats(-14, 0), highest=st.floats(0, 30))
def test_ticks_of_money_stand_at_its_logarithm_apart_from_one_another(lowest, highest):
    history = np.linspace(0, 1, len(TEST))
    axes = plots.wealth(TEST, {"worse": lowest * history, "better": highest * history}).figure.axes[0]
    amounts = [float(label.get_text().replace(",", "")) for label in axes.get_yticklabels()]
    places, (low, high) = axes.get_yticks(), axes.get_ylim()
    assert places == pytest.approx(np.log(amounts), abs=1e-9)
    assert low <= places.min() <= places.max() <= high
    assert (low <= lowest) & (highest <= high)
    if highest - lowest > 0.005:
        assert len(amounts) >= 2
        assert np.diff(places).min() >= (high - low) / 11


@pytest.mark.parametrize(("log_money", "shown"), [(10.0, "22,000"), (-13.8155, "0.000001"), (25, "7.2e+10"), (0, "1")])
def test_money_is_written_out(log_money, shown):
    picture = plots.wealth(TEST, {"a": np.linspace(0, log_money, len(TEST))})
    assert f"In the end a: {shown}." in picture.alt
    assert picture.figure.legends[0].get_texts()[0].get_text() == f"a: ×{shown}"


# --- in and out -------------------------------------------------------------------------------------------------------

KINDS = {f"kind {i}": (np.arange(3.0) + 2 * i, np.arange(3.0) - i) for i in range(12)}


def test_every_seed_has_its_dot():
    picture = plots.in_and_out(KINDS)
    axes = picture.figure.axes[0]
    for kind, (inside, outside) in zip(axes.collections, KINDS.values(), strict=True):
        assert kind.get_offsets().tolist() == np.column_stack([inside, outside]).tolist()
    for i, name in enumerate(KINDS):
        assert f"{name}: {1 + 2 * i:.1f} inside, {1 - i:.1f} outside" in picture.alt
    diagonal = axes.lines[0]
    assert [*diagonal.get_xdata()] == [*diagonal.get_ydata()] == [-11, 24]
    assert [text.get_text() for text in picture.figure.legends[0].get_texts()] == [*KINDS, "as good on unseen days"]


# --- a grid of states -------------------------------------------------------------------------------------------------


def a_grid(n, seed=0):
    rng = np.random.default_rng(seed)
    long, short = 1e-4 * rng.standard_normal((2, n * n))
    long[0], short[0], long[1], short[1] = 3e-4, 1e-4, 2e-4, 2e-4  # both worth it; equals, of which neither is opened
    return (long, short), rng.integers(0, 3, n * n) + (np.arange(n * n) < 2)


def signs(picture, n):
    """{state: sign}, read off the screen: row 0 is the lowest, column 0 the leftmost."""
    axes = picture.figure.axes[0]
    picture.figure.canvas.draw()
    box, found = axes.get_window_extent(), {}
    for text in axes.texts:
        x, y = axes.transData.transform(text.get_position())
        column, row = int(n * (x - box.x0) / box.width), int(n * (y - box.y0) / box.height)
        found[row * n + column] = text.get_text()
    return found


@pytest.mark.parametrize(("n", "seen"), [(2, True), (3, True), (8, True), (8, False), (12, True)])
def test_signs_and_colours_stand_in_their_cells(n, seen):
    (long, short), visits = a_grid(n)
    picture = plots.grid_of_states((long, short), visits=visits if seen else None)
    expected, worth = {}, {}
    for state in range(n * n):
        better = max(long[state], short[state])
        if visits[state] or not seen:
            nothing = better <= 0 or long[state] == short[state]
            expected[state] = "·" if nothing else "▲" if long[state] == better else "▼"
            worth[state] = 0 if nothing else better * 1e4 * (1 if expected[state] == "▲" else -1)
    assert signs(picture, n) == expected
    mesh = picture.figure.axes[0].collections[0]
    cells = np.ma.filled(mesh.get_array().reshape(n, n), np.nan)[::-1].ravel()
    assert {state: value for state, value in enumerate(cells) if not np.isnan(value)} == pytest.approx(worth)
    assert mesh.get_clim()[0] == -mesh.get_clim()[1]
    rows = {sign: [state // n for state, is_it in expected.items() if is_it == sign] for sign in "▲▼"}
    unseen = n * n - len(expected)
    assert f"{len(rows['▲'])} states say buy, {len(rows['▼'])} sell, {unseen} were never seen." in picture.alt
    if all(rows.values()):
        means = [sum(places) / len(places) for places in rows.values()]
        assert f"row of those that buy is {means[0]:.1f}, of those that sell {means[1]:.1f}." in picture.alt
    axes = picture.figure.axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == [str(i) for i in range(n)]
    ticks = zip(axes.get_yticks(), (label.get_text() for label in axes.get_yticklabels()), strict=True)
    assert [label for _, label in sorted(ticks, reverse=True)] == [str(i) for i in range(n)]
