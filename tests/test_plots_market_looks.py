"""Pictures of the market can be read: nothing is cut or hidden, axes have names, and bad input is refused."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.text import Text
from test_plots_market import CLOSE, KINDS, TEST, a_grid, curves, short_part, some_positions

from course_lib import market, plots

LONG_TITLE = "IBM, unseen days: what 1 dollar becomes in three years"
PICTURES = {
    "prices": lambda **more: plots.trades(TEST, **more),
    "prices of two bars": lambda **more: plots.trades(short_part(2), **more),
    "prices within days": lambda **more: plots.trades(market.split(market.DayGridMarket().prices(400)).test, **more),
    "trades": lambda **more: plots.trades(TEST, some_positions(), **more),
    "trades of two bars": lambda **more: plots.trades(short_part(2), [1, -1], **more),
    "no trades": lambda **more: plots.trades(TEST, market.flat(TEST), bars=slice(9, 29), **more),
    "wealth": lambda **more: plots.wealth(TEST, {"hold": curves(1)[0]}, **more),
    "wealth of two bars": lambda **more: plots.wealth(short_part(2), {"hold": [0, 0.1]}, **more),
    "wealth of nobody": lambda **more: plots.wealth(TEST, {"flat": np.zeros(len(TEST))}, **more),
    "wealth of many": lambda **more: plots.wealth(
        TEST, {"buy and hold": curves(1)[0]} | {f"turning grid {i}": curves(20, i) for i in range(6)}, **more
    ),
    "ruin": lambda **more: plots.wealth(TEST, {"a trader who was ruined": -14.0 * (np.arange(140) > 70)}, **more),
    "riches": lambda **more: plots.wealth(TEST, {"oracle, " * 6: np.linspace(0, 25, 140)}, **more),
    "inside and outside": lambda **more: plots.in_and_out(KINDS, **more),
    "one seed": lambda **more: plots.in_and_out({"window 8": ([-12.1], [-0.3])}, **more),
    "grid": lambda **more: plots.grid_of_states(a_grid(8)[0], visits=a_grid(8)[1], **more),
    "small grid": lambda **more: plots.grid_of_states(a_grid(2)[0], **more),
    "large grid": lambda **more: plots.grid_of_states(a_grid(12)[0], xlabel="bar of the day", **more),
    "grid of nothing": lambda **more: plots.grid_of_states(-np.ones((2, 9)), **more),
    "unseen grid": lambda **more: plots.grid_of_states(a_grid(3)[0], visits=np.zeros(9), **more),
}
LABELS = {  # what is written beside the axes, bottom and left, of every panel and scale
    "trades": {("", "price"), ("date", "")},
    "prices": {("date", "price")},
    "wealth": {("date", "money (log scale)")},
    "inside and outside": {("Sharpe ratio on the training days", "Sharpe ratio on unseen days")},
    "grid": {
        ("column: bars since the opposite extreme", "row: price, low to high"),
        ("", "advantage of opening (basis points)\nbelow 0: of selling"),
    },
    "large grid": {
        ("column: bar of the day", "row: price, low to high"),
        ("", "advantage of opening (basis points)\nbelow 0: of selling"),
    },
}
each_picture = pytest.mark.parametrize("name", PICTURES)


def fits(picture):
    """Nothing is cut, no label stands on another, and the legend hides nothing."""
    figure = picture.figure
    figure.canvas.draw()
    texts, paper = set(figure.findobj(Text)), figure.bbox
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        labels = [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
        texts -= {label for tick in axis.majorTicks for label in (tick.label1, tick.label2)} - set(labels)
        boxes = [label.get_window_extent() for label in labels if label.get_visible() and label.get_text()]
        assert not [1 for one, other in combinations(boxes, 2) if one.overlaps(other)], "labels on one another"
    for text in texts:
        if text.get_text() and text.get_visible():
            box = text.get_window_extent()
            inside = paper.x0 <= box.x0 and paper.y0 <= box.y0 and box.x1 <= paper.x1 and box.y1 <= paper.y1
            assert inside, f"{text.get_text()!r} is cut"
    for legend in figure.legends:
        assert not [1 for axes in figure.axes if legend.get_window_extent().overlaps(axes.get_tightbbox())]
    assert not [1 for axes in figure.axes if axes.get_legend()], "a legend among the data hides some"
    assert figure.axes[0].get_window_extent().height > 2 * figure.dpi, "room for what is shown, of 2 inches or more"
    return True


@each_picture
def test_nothing_is_cut_or_hidden(name):
    assert fits(PICTURES[name](title=LONG_TITLE))


@each_picture
def test_every_picture_has_its_title_and_words_of_ones_own(name):
    picture = PICTURES[name](title="My title", words="as I say")
    assert picture.figure.axes[0].get_title(loc="left") == "My title"
    assert picture.alt.startswith("My title")
    assert picture.alt.endswith("as I say")
    untitled = PICTURES[name]()
    assert untitled.figure.axes[0].get_title(loc="left") == ""
    assert untitled.alt[0].isupper()


@pytest.mark.parametrize("name", ["trades", "wealth of many", "inside and outside", "large grid"])
def test_every_picture_shows_itself(name):
    shown = PICTURES[name]()._repr_mimebundle_()
    assert 'src="data:image/png;base64,' in shown["text/html"]
    assert len(shown["text/html"]) < 250_000


@pytest.mark.parametrize("name", LABELS)
def test_axes_say_what_they_show(name):
    assert {(axes.get_xlabel(), axes.get_ylabel()) for axes in PICTURES[name]().figure.axes} == LABELS[name]


def test_no_two_kinds_are_told_apart_by_colour_alone():
    shapes = [kind.get_paths()[0].vertices for kind in plots.in_and_out(KINDS).figure.axes[0].collections]
    assert not [1 for one, other in combinations(shapes[:8], 2) if np.array_equal(one, other)]
    lines = plots.wealth(TEST, dict.fromkeys(KINDS, CLOSE)).figure.axes[0].lines[:-1]
    looks = [(line.get_color(), line._dash_pattern) for line in lines]
    assert len({str(look) for look in looks}) == len(KINDS)
    assert len({str(dashes) for _, dashes in looks[:6]}) == 6


@pytest.mark.parametrize("name", ["grid", "large grid", "small grid"])
def test_signs_stand_out_on_their_colours(name):
    picture = PICTURES[name]()
    axes = picture.figure.axes[0]
    picture.figure.canvas.draw()
    mesh = axes.collections[0]
    cells = mesh.get_facecolors().reshape(*mesh.get_array().shape, 4)
    for text in axes.texts:
        column, row = (int(place) for place in text.get_position())
        levels = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in cells[row, column][:3]]
        luminance = np.dot([0.2126, 0.7152, 0.0722], levels)
        contrast = (luminance + 0.05) / 0.05 if text.get_color() == "black" else 1.05 / (luminance + 0.05)
        assert contrast >= 4.5


def test_colours_of_a_grid_are_not_those_of_its_largest_number_alone():
    """One state of 64 is worth a hundred times the others; the scale says that it goes on."""
    long = np.ones(64) * 1e-4
    long[5] = 100e-4
    picture = plots.grid_of_states((long, 0 * long))
    assert picture.figure.axes[0].collections[0].get_clim() == pytest.approx((-1, 1))
    assert picture.figure.axes[1].get_ylim() == pytest.approx((-1, 1))
    assert picture.figure.axes[0].collections[0].colorbar.extend == "both"
    assert PICTURES["grid of nothing"]().figure.axes[0].collections[0].colorbar.extend == "neither"


BAD = [
    (lambda: plots.trades(TEST, some_positions()[:-1]), "-1, 0 or 1 for each of 140 bars, got int64[139]"),
    (lambda: plots.trades(TEST, [some_positions()] * 2), "positions must be those of one trader, -1, 0 or 1"),
    (lambda: plots.trades(TEST, np.zeros((140, 2), int)), "-1, 0 or 1 for each of 140 bars, got int64[140, 2]"),
    (lambda: plots.trades(TEST, 2 * some_positions()), "-1, 0 or 1 for each of 140 bars, got int64[140]"),
    (lambda: plots.trades(TEST, np.full(140, np.nan)), "-1, 0 or 1 for each of 140 bars, got float64[140]"),
    (lambda: plots.trades(TEST, bars=slice(5, 6)), "of 2 or more of 140 bars in turn, got slice(5, 6, None)"),
    (lambda: plots.trades(TEST, bars=slice(200, 300)), "of 2 or more of 140 bars in turn, got slice(200, 300, None)"),
    (lambda: plots.trades(TEST, bars=slice(0, 90, 2)), "of 2 or more of 140 bars in turn, got slice(0, 90, 2)"),
    (lambda: plots.trades(TEST, bars=slice(None, None, -1)), "of 2 or more of 140 bars in turn"),
    (lambda: plots.trades(TEST, bars=50), "bars must be a slice, such as slice(0, 250), of 2 or more of 140 bars"),
    (lambda: plots.trades(TEST, bars=(0, 50)), "in turn, got (0, 50)"),
    (lambda: plots.wealth(TEST, {"a": CLOSE, "b": CLOSE[:9]}), "log_equity of b must have 140 bars, as the part, got"),
    (lambda: plots.wealth(TEST, {"a": np.zeros((2, 3, 140))}), "must have 140 bars, as the part, got [2, 3, 140]"),
    (lambda: plots.wealth(TEST, {}), "log_equity must hold one trader or more, got none"),
    (lambda: plots.in_and_out({}), "sharpe must hold two arrays of one length for each name, got lengths {}"),
    (lambda: plots.in_and_out({"a": ([1], [2, 3])}), "of one length for each name, got lengths {'a': [1, 2]}"),
    (lambda: plots.in_and_out({"a": ([], [])}), "two arrays of one length for each name, got lengths {'a': [0, 0]}"),
    (lambda: plots.in_and_out({"a": ([1], [2], [3])}), "for each name, got lengths {'a': [1, 1, 1]}"),
    (lambda: plots.grid_of_states(np.zeros((2, 10))), "a grid of 3 × 3 states needs 9 numbers of each kind, got 10"),
    (lambda: plots.grid_of_states(np.zeros((2, 9)), n=4), "a grid of 4 × 4 states needs 16 numbers of each kind"),
    (lambda: plots.grid_of_states((np.zeros(9), np.zeros(4))), "got 9 for long, 4 for short and 9 for visits"),
    (lambda: plots.grid_of_states(np.zeros((2, 9)), visits=[1, 2]), "9 for short and 2 for visits"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "words"), BAD, ids=[f"{i:02} {words}" for i, (_, words) in enumerate(BAD)])
def test_bad_input_is_refused_in_one_clear_sentence(call, words):
    with pytest.raises(ValueError, match=r"^[^\n]+$") as error:
        call()
    assert words in str(error.value)
