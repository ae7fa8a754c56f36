"""What many runs say together, and how sure one can be (Agarwal et al., 2021, "Deep RL at the edge of the precipice").

The definitions are those of that paper's library, rliable. Scores are float64[n] of n runs, or float64[n, T] of n runs
in each of T tasks. A run is drawn anew only within its own task (a stratified bootstrap; Efron & Tibshirani, 1993,
chapters 6 and 13), and the tasks are then looked at together.
"""

from typing import NamedTuple

import numpy as np

from course_lib.validate import fraction, whole_number

_NUMBERS_AT_ONCE = 2**21  # of resampled runs, so that memory stays small


class Estimate(NamedTuple):
    """A number from many runs, and an interval around it; each a float, or float64[N] of a curve.

    middle is what the runs themselves give, low and high are the ends of the bootstrap's interval.
    """

    middle: float
    low: float
    high: float


def interquartile_mean(scores, axis=None):
    """The mean of the middle half: the lowest quarter and the highest, int(n / 4) runs each, are left out.

    It is rliable's `aggregate_iqm`, SciPy's `trim_mean(scores, 0.25)`: over all scores, or along `axis`. As a rule
    less noisy than the median, and not led astray by a few runs as the mean is. `ValueError` for no runs, NaN or
    infinity.
    """
    scores = _checked(scores)
    scores = scores.reshape(-1) if axis is None else np.moveaxis(scores, axis, -1)
    return _middle_half(scores)


def _middle_half(scores, axis=-1):
    """`interquartile_mean` along the last axis, of scores that are known to be finite."""
    count = scores.shape[axis]
    middle = np.sort(scores, axis=axis)[..., count // 4 : count - count // 4].mean(axis=axis)
    return float(middle) if np.ndim(middle) == 0 else middle


def bootstrap(scores, statistic=interquartile_mean, *, confidence=0.95, resamples=2000, seed=0):
    """`Estimate` of a statistic of `scores`, float64[n] or [n, T], with its percentile interval.

    From every task n runs are drawn with replacement and the statistic is worked out again, `resamples` times; the
    interval holds the middle `confidence` of what came. The same `seed` gives the same interval. `statistic` takes
    (float64[…, n · T], axis=-1), as numpy's mean, median and max do. `ValueError` for fewer than 2 runs, which say
    nothing about how much runs differ, for NaN or infinity, and for a confidence outside (0, 1).
    """
    scores, rng, resamples = _by_task(scores), _generator(seed), whole_number("resamples", resamples, at_least=1)
    statistic = _quick(statistic)
    drawn = [statistic(again, axis=-1) for again in _resampled(scores, rng, resamples)]
    return _estimate(statistic(scores.reshape(-1), axis=-1), np.concatenate(drawn), confidence)


def difference(scores, others, statistic=interquartile_mean, *, confidence=0.95, resamples=2000, seed=0):
    """`Estimate` of statistic(scores) - statistic(others), the runs of both drawn anew independently of each other.

    Where the interval does not hold 0, luck alone would seldom make such a difference: in about 1 - confidence of all
    studies of equals, more often with few runs, and far more often if the two were chosen among many. Shapes and
    `ValueError` as for `bootstrap`; both must have the same tasks.
    """
    both, rng, resamples = _pair(scores, others), _generator(seed), whole_number("resamples", resamples, at_least=1)
    statistic = _quick(statistic)
    middle = [statistic(runs.reshape(-1), axis=-1) for runs in both]
    drawn = [np.concatenate([statistic(a, axis=-1) for a in _resampled(runs, rng, resamples)]) for runs in both]
    return _estimate(middle[0] - middle[1], drawn[0] - drawn[1], confidence)


def probability_of_improvement(scores, others, *, confidence=0.95, resamples=2000, seed=0):
    """`Estimate` of P(X > Y): how often a run of `scores` beats one of `others`; equal runs count half.

    The share of all pairs, Mann and Whitney's U / (n m), averaged over tasks, with its stratified bootstrap interval.
    Shapes and `ValueError` as for `difference`.
    """
    both, rng, resamples = _pair(scores, others), _generator(seed), whole_number("resamples", resamples, at_least=1)
    middle, drawn = [], []
    for x, y in zip(both[0].T, both[1].T, strict=True):
        y = np.sort(y)
        below, not_above = np.searchsorted(y, x, side="left"), np.searchsorted(y, x, side="right")
        middle.append((below + not_above).mean() / (2 * len(y)))
        drawn.append(_wins_drawn(below, not_above, len(y), rng, resamples))
    return _estimate(np.mean(middle), np.mean(drawn, axis=0), confidence)


def band(curves, statistic=interquartile_mean, *, confidence=0.95, resamples=1000, seed=0):
    """`Estimate` for each point of curves, float64[n, N] of n runs: three float64[N].

    Whole runs are drawn anew, and the interval holds for each point by itself. `ValueError` as for `bootstrap`.
    """
    curves, rng, resamples = _checked(curves), _generator(seed), whole_number("resamples", resamples, at_least=1)
    if curves.ndim != 2 or len(curves) < 2:
        raise ValueError(f"curves must be [n, N] of at least 2 runs, got shape {[*curves.shape]}")
    statistic, columns = _quick(statistic), np.ascontiguousarray(curves.T)
    drawn = [statistic(columns[:, which], axis=-1) for which in _choices(len(curves), curves.size, rng, resamples)]
    return _estimate(statistic(columns, axis=-1), np.concatenate(drawn, axis=1), confidence)


def _quick(statistic):
    """The statistic, which need not look for NaN in numbers that have been looked at."""
    return _middle_half if statistic is interquartile_mean else statistic


def _checked(scores):
    try:
        scores = np.asarray(scores, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"scores must be numbers in rows of one length, got {scores!r}") from None
    if scores.ndim == 0 or scores.size == 0:
        raise ValueError(f"scores must be of at least 1 run, got shape {[*scores.shape]}")
    if not np.isfinite(scores).all():
        raise ValueError(f"scores must be finite, got {int((~np.isfinite(scores)).sum())} that are NaN or infinite")
    return scores


def _by_task(scores):
    """Scores as float64[n, T] with at least two runs."""
    scores = _checked(scores)
    if scores.ndim > 2 or len(scores) < 2:
        raise ValueError(f"scores must be [n] or [n, T] of at least 2 runs, got shape {[*scores.shape]}")
    return scores.reshape(len(scores), -1)


def _pair(scores, others):
    scores, others = _by_task(scores), _by_task(others)
    if scores.shape[1] != others.shape[1]:
        raise ValueError(f"both must have the same tasks, got {scores.shape[1]} and {others.shape[1]}")
    return scores, others


def _generator(seed):
    return np.random.default_rng(whole_number("seed", seed))


def _choices(count, size, rng, resamples):
    """Which of `count` runs are drawn, int64[R, count], in portions of R until there are `resamples`."""
    at_once = max(1, _NUMBERS_AT_ONCE // size)
    for done in range(0, resamples, at_once):
        yield rng.integers(count, size=(min(at_once, resamples - done), count))


def _resampled(scores, rng, resamples):
    """The runs of every task drawn anew, float64[R, n · T], in portions."""
    runs, tasks = scores.shape
    at_once = max(1, _NUMBERS_AT_ONCE // scores.size)
    for done in range(0, resamples, at_once):
        which = rng.integers(runs, size=(min(at_once, resamples - done), runs, tasks))
        yield scores[which, np.arange(tasks)].reshape(len(which), -1)


def _wins_drawn(below, not_above, num_others, rng, resamples):
    """P(X > Y) of one task for runs drawn anew, float64[resamples].

    It is counted how often each run was drawn, since pairs of runs compare as they did: of the others, sorted, the
    first `below` are less than a run and the first `not_above` not greater.
    """
    wins = []
    for which in _choices(len(below), max(len(below), num_others), rng, resamples):
        others = rng.integers(num_others, size=(len(which), num_others))
        times = np.zeros((len(which), num_others + 1))  # times[:, j]: how many drawn ones are among the first j
        rows = np.arange(len(which))[:, None] * num_others
        times[:, 1:] = np.bincount((rows + others).ravel(), minlength=len(which) * num_others).reshape(others.shape)
        np.cumsum(times, axis=1, out=times)
        lows, highs = (np.take_along_axis(times, places[which], axis=1) for places in (below, not_above))
        wins.append((lows + highs).mean(axis=1) / (2 * num_others))
    return np.concatenate(wins)


def _estimate(middle, drawn, confidence):
    """The middle and the percentile interval of what was drawn, along its last axis."""
    confidence = fraction("confidence", confidence, above_zero=True)
    if confidence == 1:
        raise ValueError(f"confidence must be in (0, 1), got {confidence!r}")
    low, high = np.quantile(drawn, [(1 - confidence) / 2, (1 + confidence) / 2], axis=-1)
    return Estimate(middle, low, high) if np.ndim(middle) else Estimate(float(middle), float(low), float(high))
