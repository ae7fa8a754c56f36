"""Task 3, where a close stands between the low and the high of its recent past."""

from functools import partial

import numpy as np

from course_lib.checks.check import Check, Trial
from course_lib.checks.homework_2.encoders import AHEAD, ANY, DIVIDES, Encoder, in_window, shifted
from course_lib.checks.homework_2.prices import climbing, resting, walk
from course_lib.checks.homework_2.reference import level, minmax_states


def _read(close, m, levels, *, step=level, closes=0, over="window"):
    """`minmax_states` with one thing misread. int[T], ANY where it says nothing.

    step    step(newest, low, high, levels)
    closes  of a window, more than m
    over    what low and high are taken of
    """
    states = np.full(len(close), ANY)
    for t in range(m - 1 + max(0, closes), len(close)):
        low, high = in_window(close, close[t - m - closes + 1 : t + 1], t, over)
        states[t] = step(close[t], low, high, levels)
    return states


def _stepping(formula):
    """A step between low and high by another formula: formula(share of the way from 0 to 1, levels)."""

    def step(newest, low, high, levels):
        return levels // 2 if high == low else int(formula((newest - low) / (high - low), levels))

    return step


_STEPS = (
    "the levels are not equal steps from low to high: `int(levels * (close - low) / (high - low))`, and levels − 1 at "
    "the high."
)
_MISREAD = (
    (
        "the highest level is too high: a close at the high stands on level levels − 1, and the steps are as large as "
        "ever.",
        partial(_read, step=_stepping(lambda share, levels: levels * share)),
    ),
    (
        "your levels count from the top: level 0 is at the low.",
        partial(_read, step=lambda *where: where[-1] - 1 - level(*where)),
    ),
    (
        "your levels count from 1: they begin at 0, at the low.",
        partial(_read, step=lambda *where: 1 + level(*where)),
    ),
    *(
        (_STEPS, partial(_read, step=_stepping(formula)))
        for formula in (
            lambda share, levels: (levels - 1) * share,
            lambda share, levels: round((levels - 1) * share),
            lambda share, levels: min(levels - 1, round(levels * share)),
        )
    ),
    (AHEAD, lambda close, m, levels: shifted(minmax_states(close, m, levels), m - 1)),
    ("your window is one close too long: m closes, the newest among them.", partial(_read, closes=1)),
    ("your window is one close too short: m closes, the newest among them.", partial(_read, closes=-1)),
    (
        "low and high are those of all closes: only the last m are to count, and no later one.",
        partial(_read, over="all"),
    ),
    (
        "low and high are those of all closes so far: only the last m are to count.",
        partial(_read, over="past"),
    ),
    (
        "low and high leave out the newest close: it is one of the m.",
        partial(_read, over="before"),
    ),
)
_ENCODER = Encoder(minmax_states, lambda m, _: m - 1, _MISREAD)
_OTHERWISE = (
    "the level differs from what the task asks for. Work out low, high and level by hand for the last m closes up to "
    "there."
)
_STILL = DIVIDES.format(middle="levels // 2", column="")


def _reads_ten_levels(call, seed):
    _ENCODER.check(call, [(walk(seed, 70, [(20, 10)]), 20, 10)], _OTHERWISE)


def _reads_other_levels(call, seed):
    windows = [(5, 3), (12, 4), (30, 7)]
    cases = [(walk(10 * seed + m, 70, [(m, levels)]), m, levels) for m, levels in windows]
    _ENCODER.check(call, cases, _OTHERWISE)


def _stands_at_low_and_high(call, seed):
    cases = [(climbing(seed, 60, up), 10, 6) for up in (1, -1)]
    likely = "a price that always rises stands on the highest level, levels − 1; one that always falls on level 0."
    _ENCODER.check(call, cases, likely)


def _divides_by_nothing(call, seed):
    windows = [(4, 5), (7, 10)]
    cases = [(resting(10 * seed + m, 60, [(m, levels)], rest=m + 3), m, levels) for m, levels in windows]
    _ENCODER.check(call, cases, _STILL)


def _keeps_the_past(call, seed):
    _ENCODER.check_past(call, [(walk(seed + 1, 60, [(15, 10)]), 15, 10)])


stands_between_low_and_high = Check(
    "stands_between_low_and_high",
    title="Task 3, between low and high",
    usage="minmax_states(close, m, levels)",
    trials=[
        Trial("a random walk, m = 20 and 10 levels", "−1 for t < 19, then a level from 0 to 9", _reads_ten_levels),
        Trial("other windows and levels", "m closes, `levels` equal steps", _reads_other_levels),
        Trial(
            "prices that always rise, or always fall",
            "always the highest level, or level 0",
            _stands_at_low_and_high,
        ),
        Trial("a price that stands still for a while", "level levels // 2 where high = low", _divides_by_nothing),
        Trial("the same past with other futures", "the same states up to there", _keeps_the_past),
    ],
    likely={
        "ZeroDivision|division by zero|cannot convert float NaN|invalid value encountered": _STILL,
        "out of bounds|out of range": "your code asks for a close that is not there. The first full window ends at "
        "t = m − 1, and none begins before t = 0.",
    },
    hints=[
        "This is the row of task 2, with a window of m closes and a number of levels of its own.",
        "For t = m − 1, m, m + 1 … the window is `close[t - m + 1 : t + 1]`. Its smallest and largest close are low "
        "and high; the newest close is its last.",
        "`(close[t] - low) / (high - low)` is 0 at the low and 1 at the high. Times `levels`, cut off by `int`, it is "
        "the level; at the high it would be `levels`, one too many: `min(levels - 1, …)`.",
        "Ask first whether `high == low`: there is nothing to divide by then, and the level is `levels // 2`.",
    ],
)
