"""What many runs say together: definitions against plain ones and SciPy's, intervals that hold what they promise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib.study import (
    Estimate,
    band,
    bootstrap,
    difference,
    interquartile_mean,
    probability_of_improvement,
)

finite = st.floats(-1e6, 1e6)
runs = st.lists(finite, min_size=2, max_size=30)


def scores_of(count, *shape, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, *shape))


# --- definitions ------------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(st.lists(finite, min_size=1, max_size=40))
def test_the_interquartile_mean_is_that_of_the_middle_half(values):
    cut = int(0.25 * len(values))
    assert interquartile_mean(values) == pytest.approx(np.mean(sorted(values)[cut : len(values) - cut]), abs=1e-6)


@pytest.mark.parametrize("shape", [(1,), (4,), (7,), (5, 3), (100, 4)])
def test_it_is_scipys_trimmed_mean(shape):
    stats = pytest.importorskip("scipy.stats")
    scores = scores_of(*shape)
    assert interquartile_mean(scores) == pytest.approx(stats.trim_mean(scores, 0.25, axis=None), abs=1e-14)
    for axis in range(len(shape)):
        assert interquartile_mean(scores, axis=axis) == pytest.approx(stats.trim_mean(scores, 0.25, axis=axis))


def test_a_wild_run_does_not_move_it_and_order_does_not_matter():
    assert interquartile_mean([0, 1, 2, 3, 4, 5, 6, 1e9]) == 3.5
    scores = scores_of(9)
    assert interquartile_mean(scores) == interquartile_mean(scores[::-1])


@settings(deadline=None)
@given(runs, runs)
def test_the_probability_of_improvement_is_the_share_of_pairs_won(x, y):
    plain = np.mean([1.0 if a > b else 0.5 if a == b else 0.0 for a in x for b in y])
    assert probability_of_improvement(x, y, resamples=1).middle == pytest.approx(plain, abs=1e-12)


def test_it_is_mann_and_whitneys_u_over_the_pairs_averaged_over_tasks():
    stats = pytest.importorskip("scipy.stats")
    x, y = scores_of(12, 3).round(1), scores_of(9, 3, seed=1).round(1)
    by_task = [stats.mannwhitneyu(x[:, t], y[:, t]).statistic / (12 * 9) for t in range(3)]
    assert probability_of_improvement(x, y).middle == pytest.approx(np.mean(by_task))
    assert probability_of_improvement(x, x).middle == 0.5
    assert probability_of_improvement(x, x + 10) == (0, 0, 0)
    assert probability_of_improvement(np.ones(5), np.ones(4)) == (0.5, 0.5, 0.5)


@settings(deadline=None)
@given(runs, runs)
def test_a_difference_is_that_of_the_two(x, y):
    found = difference(x, y, resamples=5)
    assert found.middle == pytest.approx(interquartile_mean(x) - interquartile_mean(y), abs=1e-6)
    assert found.low <= found.high


# --- the bootstrap ----------------------------------------------------------------------------------------------------


def plainly_drawn(scores, rng, resamples):
    """rliable's stratified bootstrap of the interquartile mean, written with loops: runs are drawn within tasks."""
    drawn = []
    for _ in range(resamples):
        again = [[column[rng.integers(len(column))] for _ in column] for column in scores.T]
        drawn.append(interquartile_mean(again))
    return drawn


@pytest.mark.parametrize("shape", [(12,), (6, 3)])
def test_the_interval_is_that_of_a_plain_bootstrap(shape):
    scores = scores_of(*shape) + (np.arange(3) * 10 if len(shape) > 1 else 0)
    drawn = plainly_drawn(scores.reshape(len(scores), -1), np.random.default_rng(5), 4000)
    found = bootstrap(scores, resamples=20_000)
    width = found.high - found.low
    assert found.middle == interquartile_mean(scores)
    assert [found.low, found.high] == pytest.approx(np.percentile(drawn, [2.5, 97.5]), abs=0.06 * width)


def test_it_is_scipys_percentile_bootstrap():
    stats = pytest.importorskip("scipy.stats")
    scores = scores_of(25)
    theirs = stats.bootstrap(
        (scores,), interquartile_mean, method="percentile", n_resamples=20_000, rng=np.random.default_rng(1)
    ).confidence_interval
    ours = bootstrap(scores, resamples=20_000)
    assert ours[1:] == pytest.approx([theirs.low, theirs.high], abs=0.02)


def test_runs_stay_in_their_task():
    """Tasks far apart: were runs drawn across them, the mean would swing by tens; within them it does not move."""
    scores = np.repeat([[0.0, 100.0, 1000.0]], 5, axis=0)
    assert bootstrap(scores, np.mean) == pytest.approx([1100 / 3] * 3)
    assert difference(scores, scores + 1, np.mean) == pytest.approx([-1] * 3)


@pytest.mark.parametrize("statistic", [interquartile_mean, np.mean, np.median])
def test_intervals_hold_the_truth_as_often_as_they_say(statistic):
    """300 studies of 40 runs each; of 95 % intervals one expects 285 to hold the truth, and a few less from so few."""
    held = 0
    for study in range(300):
        found = bootstrap(scores_of(40, seed=study) + 7, statistic, resamples=400, seed=study)
        held += found.low <= 7 <= found.high
    assert 265 <= held <= 297


def test_intervals_of_differences_hold_the_truth_too():
    held = np.zeros(2)
    for study in range(300):
        x, y = scores_of(30, seed=study) + 0.5, scores_of(40, seed=1000 + study)
        found = difference(x, y, resamples=400)
        wins = probability_of_improvement(x, y, resamples=400)
        held += [found.low <= 0.5 <= found.high, wins.low <= 0.6382 <= wins.high]  # Φ(0.5 / √2)
    assert (held >= 270).all()
    assert (held <= 298).all()


def test_a_higher_confidence_is_a_wider_interval_and_more_runs_a_narrower_one():
    widths = [np.diff(bootstrap(scores_of(50), confidence=c)[1:])[0] for c in (0.5, 0.95, 0.999)]
    assert widths == sorted(widths)
    assert np.diff(bootstrap(scores_of(5000))[1:]) < widths[1] / 5


def test_the_same_seed_gives_the_same_interval_whatever_fits_into_memory(monkeypatch):
    from course_lib.study import statistics

    scores = scores_of(20, 3)
    both = scores, scores_of(15, 3, seed=1)
    calls = [lambda: bootstrap(scores), lambda: difference(*both), lambda: band(scores)]
    before = [call() for call in calls]
    assert bootstrap(scores, seed=1) != before[0]
    monkeypatch.setattr(statistics, "_NUMBERS_AT_ONCE", 1000)
    for call, found in zip(calls, before, strict=True):
        assert np.array_equal(call(), found)
    assert probability_of_improvement(*both) == probability_of_improvement(*both)


@settings(max_examples=30, deadline=None)
@given(st.integers(2, 12), st.integers(1, 5))
def test_a_band_is_an_interval_at_each_point(count, length):
    curves = scores_of(count, length)
    found = band(curves, resamples=300)
    assert isinstance(found, Estimate)
    assert np.allclose(found.middle, [interquartile_mean(column) for column in curves.T])
    for i in range(length):
        alone = bootstrap(curves[:, i], resamples=300)
        assert np.all(found.low <= found.high)
        assert abs(found.low[i] - alone.low) <= 0.5 * (alone.high - alone.low) + 1e-12


def test_where_all_runs_are_alike_there_is_nothing_to_doubt():
    assert bootstrap([2.0, 2.0, 2.0]) == (2, 2, 2)
    assert np.array_equal(band(np.ones((4, 3))), np.ones((3, 3)))


# --- what cannot be meant ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scores", "said"),
    [
        ([], "at least 1 run"),
        (3.0, "at least 1 run"),
        ([1.0], "at least 2 runs"),
        ([[1.0, 2.0]], "at least 2 runs"),
        ([1.0, np.nan], "1 that are NaN"),
        ([np.inf, 1.0], "finite"),
        ([[1.0], [2.0, 3.0]], "rows of one length"),
        (["a", "b"], "must be numbers"),
        (np.zeros((2, 2, 2)), r"\[n\] or \[n, T\]"),
    ],
)
def test_scores_that_say_nothing_are_refused(scores, said):
    for function in (bootstrap, lambda x: difference(x, [1, 2]), lambda x: probability_of_improvement([1, 2], x)):
        with pytest.raises(ValueError, match=said):
            function(scores)


def test_so_are_settings_out_of_range():
    for confidence in (0, 1, 1.5, -0.1, np.nan, "much"):
        with pytest.raises(ValueError, match="confidence"):
            bootstrap([1, 2, 3], confidence=confidence)
    for resamples in (0, -1, 2.5):
        with pytest.raises(ValueError, match="resamples"):
            bootstrap([1, 2, 3], resamples=resamples)
    with pytest.raises(ValueError, match="seed"):
        bootstrap([1, 2, 3], seed=-1)
    with pytest.raises(ValueError, match="same tasks, got 2 and 3"):
        difference(np.zeros((4, 2)), np.zeros((4, 3)))
    with pytest.raises(ValueError, match="curves must be"):
        band([1.0, 2.0])
    with pytest.raises(ValueError, match="at least 1 run"):
        interquartile_mean(np.zeros((0, 3)))
