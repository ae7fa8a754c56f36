"""Task 2, a grid that a price turns on: how high the newest close stands, and how long ago the other extreme was."""

from functools import partial

import numpy as np

from course_lib.checks.check import Check, Trial
from course_lib.checks.homework_2.encoders import AHEAD, ANY, DIVIDES, Encoder, in_window, shifted
from course_lib.checks.homework_2.prices import ladder, resting, walk
from course_lib.checks.homework_2.reference import grid_states, level


def _read(close, n, *, row=level, column="latest", half=2, closes=0, over="window", number=None):
    """`grid_states` with one thing misread. int[T], ANY where it says nothing.

    row     row(newest, low, high, n)
    column  which extreme the bars since are counted from
    half    the upper half begins at row n / half, or n // 2 for half = None
    closes  of a window, more than n
    over    what low and high are taken of
    number  number(row, column, n) of the state
    """
    states = np.full(len(close), ANY)
    for t in range(n - 1 + max(0, closes), len(close)):
        window = close[t - n - closes + 1 : t + 1]
        low, high = in_window(close, window, t, over)
        up = row(close[t], low, high, n)
        is_upper = up >= (n // 2 if half is None else n / half)
        extreme = window.min() if is_upper != (column == "same") else window.max()
        found = np.flatnonzero(window[::-1] == extreme)
        since = {"first": found[-1], "from the left": len(window) - 1 - found[0]}.get(column, found[0])
        states[t] = up * n + since if number is None else number(up, since, n)
    return states


def _unbounded(newest, low, high, n):
    return n // 2 if high == low else int(n * (newest - low) / (high - low))


def _of_fewer(newest, low, high, n):
    return n // 2 if high == low else int((n - 1) * (newest - low) / (high - low))


def _rounded(newest, low, high, n):
    return n // 2 if high == low else min(n - 1, round(n * (newest - low) / (high - low)))


def _rounded_of_fewer(newest, low, high, n):
    return n // 2 if high == low else round((n - 1) * (newest - low) / (high - low))


_STEPS = (
    "the levels are not n equal steps from low to high: `int(n * (close - low) / (high - low))`, and n − 1 at the high."
)
_MISREAD = (
    (
        "row and column are exchanged: state = row · n + column, as in the maze.",
        partial(_read, number=lambda row, column, n: column * n + row),
    ),
    (
        "your levels count from the top: level 0 is at the low of the window.",
        partial(_read, number=lambda row, column, n: (n - 1 - row) * n + column),
    ),
    (
        "the bars are counted from the extreme that the close is near: it is the opposite one, the low for a close in "
        "the upper half, else the high.",
        partial(_read, column="same"),
    ),
    (
        "where several closes are as high, or as low, you count from the first of them: it is the latest.",
        partial(_read, column="first"),
    ),
    (
        "your column says where in the window the extreme is, from the left: it is the number of bars since then.",
        partial(_read, column="from the left"),
    ),
    (
        "the bars since an extreme are counted from 1: where the newest close is that extreme itself, it is 0.",
        partial(_read, number=lambda row, column, n: row * n + column + 1),
    ),
    ("the highest level is too high: a close at the high stands on level n − 1.", partial(_read, row=_unbounded)),
    *((_STEPS, partial(_read, row=row)) for row in (_of_fewer, _rounded, _rounded_of_fewer)),
    (
        "for an odd n the middle level counts as the upper half: the upper half is level >= n / 2, not n // 2.",
        partial(_read, half=None),
    ),
    (AHEAD, lambda close, n: shifted(grid_states(close, n), n - 1)),
    ("your window is one close too long: n closes, the newest among them.", partial(_read, closes=1)),
    ("your window is one close too short: n closes, the newest among them.", partial(_read, closes=-1)),
    (
        "low and high are those of all closes: a window knows its own n closes only, and no later one.",
        partial(_read, over="all"),
    ),
)
_ENCODER = Encoder(grid_states, lambda n: n - 1, _MISREAD)
_OTHERWISE = (
    "row or column differ from what the task asks for. Work out low, high, level and the bars since the opposite "
    "extreme by hand for the closes shown here."
)


def _reads_an_even_grid(call, seed):
    _ENCODER.check(call, [(walk(seed, 60, [(8, 8)]), 8)], _OTHERWISE)


def _reads_other_grids(call, seed):
    _ENCODER.check(call, [(walk(10 * seed + n, 60, [(n, n)]), n) for n in (3, 5, 12)], _OTHERWISE)


def _counts_from_the_latest(call, seed):
    cases = [(ladder(10 * seed + n, 60, [(n, n)]), n) for n in (6, 9)]
    _ENCODER.check(call, cases, "this price comes back to its lows and highs: the latest of them counts.")


def _divides_by_nothing(call, seed):
    cases = [(resting(10 * seed + n, 60, [(n, n)], rest=n + 3), n) for n in (4, 7)]
    _ENCODER.check(call, cases, DIVIDES.format(middle="n // 2", column=", column 0"))


def _keeps_the_past(call, seed):
    _ENCODER.check_past(call, [(walk(seed + 1, 60, [(6, 6)]), 6)])


finds_turns_on_a_grid = Check(
    "finds_turns_on_a_grid",
    title="Task 2, a grid for turns",
    usage="grid_states(close, n)",
    trials=[
        Trial("a random walk, n = 8", "−1 for t < 7, then row · 8 + column", _reads_an_even_grid),
        Trial("n = 3, 5 and 12", "an n for each, odd ones too", _reads_other_grids),
        Trial(
            "lows and highs that are reached several times",
            "the bars since the latest of them",
            _counts_from_the_latest,
        ),
        Trial("a price that stands still for a while", "level n // 2 where high = low", _divides_by_nothing),
        Trial("the same past with other futures", "the same states up to there", _keeps_the_past),
    ],
    likely={
        "ZeroDivision|division by zero|cannot convert float NaN|invalid value encountered": DIVIDES.format(
            middle="n // 2", column=", column 0"
        ),
        "out of bounds|out of range": "your code asks for a close that is not there. The first full window ends at "
        "t = n − 1, and none begins before t = 0.",
    },
    hints=[
        "Go through t = n − 1, n, n + 1 … and take the window `close[t - n + 1 : t + 1]`: n closes, the newest last. "
        "All that the state is made of lies in it.",
        "The row: how far up between low and high the newest close stands, in n equal steps. At the high itself the "
        "formula gives n, one level too many: `min(n - 1, …)`. Where high equals low, take `n // 2` instead.",
        "The column: in the upper half (`row >= n / 2`) look for the low, else for the high. How many bars ago was it, "
        "for the last time? Turned round, `window[::-1]` has the newest close first.",
        "`window[::-1].argmin()` is the number of bars since the latest low, and `window[::-1].argmax()` since the "
        "latest high. Then `states[t] = row * n + column`, in an array that begins as `np.full(len(close), -1)`.",
    ],
)
