"""Pictures of studies: lines, bands, bars and fields stand where the numbers are, and the words say the same."""

import numpy as np
import pytest
from study_worlds import drawn

from course_lib import plots, study

BANDS = {
    "a": (np.array([1.0, 2.0, 3.0]), np.array([0.5, 1.5, 2.5]), np.array([1.25, 2.25, 3.25])),
    "b": (np.array([4.0, 4.0, 4.0]), np.array([3.0, 3.5, 3.75]), np.array([5.0, 4.5, 4.25])),
}
INTERVALS = {"a": (1.0, 0.5, 1.75), "b": (2.0, 1.5, 2.25), "c": (3.0, 2.0, 3.5)}


def words_on_screen(picture):
    picture.figure.canvas.draw()
    return " ".join(text.get_text() for axes in picture.figure.axes for text in axes.texts)


@pytest.mark.parametrize("at", [None, [10, 20, 30]])
def test_a_band_lies_around_its_line(at):
    picture = plots.bands(BANDS, at=at, ylabel="steps", title="Steps")
    axes = picture.figure.axes[0]
    for line, area, (middle, low, high) in zip(axes.lines, axes.collections, BANDS.values(), strict=True):
        assert line.get_xdata().tolist() == (at or [1, 2, 3])
        assert line.get_ydata().tolist() == middle.tolist()
        corners = area.get_paths()[0].vertices
        for x, bottom, top in zip(at or [1, 2, 3], low, high, strict=True):
            assert {bottom, top} <= set(corners[corners[:, 0] == x, 1])
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["a", "b"]
    assert "a: 3.000 (2.500 to 3.250); b: 4.000 (3.750 to 4.250)" in picture.alt
    assert "steps by episode, line: interquartile mean; band: 95 % of its bootstrap" in picture.alt
    assert "band: 95 % of its bootstrap" in words_on_screen(picture)


def test_the_bands_of_a_study_can_be_drawn():
    results = study.run(drawn, {"scale": [1, 2], "size": 4}, seeds=5)
    picture = plots.bands(results.bands("curve", resamples=20), words="It goes up and down.")
    assert picture.alt.endswith("It goes up and down.")
    assert [len(line.get_xdata()) for line in picture.figure.axes[0].lines] == [4, 4]
    assert "scale = 2" in plots.learning_curves(results.curves["curve"]).alt


def test_more_settings_than_colours_are_drawn_too():
    picture = plots.bands({str(i): BANDS["a"] for i in range(9)})
    assert len(picture.figure.axes[0].lines) == 9


@pytest.mark.parametrize("truth", [None, ("truth", 1.6)])
def test_an_interval_has_its_ends_and_its_dot(truth):
    picture = plots.intervals(INTERVALS, truth=truth, xlabel="worth", title="Three")
    axes = picture.figure.axes[0]
    bars, dots = axes.lines[0 : 2 * 3 : 2], axes.lines[1 : 2 * 3 : 2]
    for i, (bar, dot, (middle, low, high)) in enumerate(zip(bars, dots, INTERVALS.values(), strict=True)):
        assert list(bar.get_xdata()) == [low, high]
        assert set(bar.get_ydata()) == {i}
        assert [*dot.get_xdata(), *dot.get_ydata()] == [middle, i]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a", "b", "c"]
    assert axes.yaxis_inverted(), "the first one on top"
    assert ("truth: 1.6" in words_on_screen(picture)) == (truth is not None)
    assert "a: 1.000 (0.500 to 1.750); b: 2.000 (1.500 to 2.250); c: 3.000" in picture.alt


def test_a_heat_map_has_each_number_in_its_field():
    values = np.array([[0.1, 0.25, 0.3], [0.9, 0.5, 0.6]])
    picture = plots.heat_map(values, ["low", "high"], [1, 2, 3], xlabel="epsilon", ylabel="alpha", label="worth")
    axes = picture.figure.axes[0]
    places = {text.get_text(): text.get_position() for text in axes.texts}
    assert places == {f"{values[i, j]:.3f}": (j + 0.5, i + 0.5) for i in range(2) for j in range(3)}
    assert axes.yaxis_inverted(), "the first row on top"
    assert [label.get_text() for label in axes.get_xticklabels()] == ["1", "2", "3"]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["low", "high"]
    assert "worth: largest 0.900 at alpha high and epsilon 1, least 0.100." in picture.alt
    colours = {text.get_text(): text.get_color() for text in axes.texts}
    assert colours["0.100"] == "white"
    assert colours["0.900"] == "black"


def test_a_heat_map_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"values must be \[2, 3\], got \[3, 2\]"):
        plots.heat_map(np.zeros((3, 2)), ["a", "b"], [1, 2, 3])
    assert plots.heat_map(np.zeros((1, 1)), ["a"], [1]).png().startswith(b"\x89PNG")
