"""Task 1, the last moves as digits of one number."""

import operator
from functools import partial
from itertools import permutations

import numpy as np

from course_lib.checks.check import Check, Trial
from course_lib.checks.homework_2.encoders import AHEAD, ANY, Encoder, shifted
from course_lib.checks.homework_2.prices import drowsy, lively, wilder
from course_lib.checks.homework_2.reference import base_3, threshold, window_states

_DIGITS = "0 is a move down, 1 a flat one, 2 a move up"


def _read(
    close,
    num_train,
    k,
    *,
    flat_of=None,
    is_flat=operator.le,
    is_up=operator.gt,
    digits=(0, 1, 2),
    more=0,
    newest_first=False,
):
    """`window_states` with one thing misread. int[T], ANY where it says nothing.

    flat_of  flat_of(sizes of all moves, num_train): those that the threshold is the quantile of
    more     moves in a window, more than k
    """
    returns = np.diff(np.log(close))
    sizes = np.abs(returns)
    flat = np.quantile(sizes[: num_train - 1] if flat_of is None else flat_of(sizes, num_train), 1 / 3)
    down, level, up = digits
    read = [
        level if is_flat(size, flat) else up if is_up(r, 0) else down for r, size in zip(returns, sizes, strict=True)
    ]
    states = np.full(len(close), ANY)
    for t in range(max(k, k + more), len(close)):
        window = read[t - k - more : t]
        states[t] = base_3(reversed(window) if newest_first else window)
    return states


def _of_the_whole_past(close, num_train, _):
    """The number of all moves so far, as long as an int has room for it."""
    states = _read(close, num_train, 1)
    for t in range(2, min(len(close), 36)):
        states[t] += 3 * states[t - 1]
    states[36:] = ANY
    return states


_GROWS = "your number grows with every move: only the last k moves are its digits."
_MISREAD = (
    (
        "your digits are read the wrong way round: the oldest move comes first, the newest is the last digit, the one "
        "that counts 1.",
        partial(_read, newest_first=True),
    ),
    (f"a flat move counts as one down: {_DIGITS}.", partial(_read, digits=(0, 0, 2))),
    (f"a flat move counts as one up: {_DIGITS}.", partial(_read, digits=(0, 2, 2))),
    ("the moves −1, 0, 1 are read as digits as they are: add 1 to each.", partial(_read, digits=(-1, 0, 1))),
    *(
        (f"your digits stand for other moves: {_DIGITS}.", partial(_read, digits=digits))
        for digits in permutations(range(3))
        if digits != (0, 1, 2)
    ),
    ("flat and not flat are exchanged: a move is flat where |r| <= flat.", partial(_read, is_flat=operator.gt)),
    (_GROWS, _of_the_whole_past),
    (AHEAD, lambda close, num_train, k: shifted(window_states(close, num_train, k), k)),
    ("your window is one move too long: k moves, of k + 1 closes.", partial(_read, more=1)),
    ("your window is one move too short: k moves need k + 1 closes.", partial(_read, more=-1)),
    *(
        (
            "a move of the very size `flat` is not flat in your code, so that a price that stands still moves "
            "where `flat` is 0: |r| <= flat.",
            partial(_read, is_flat=operator.lt, is_up=is_up),
        )
        for is_up in (operator.gt, operator.ge)
    ),
    (
        "the threshold knows moves that come after the training part: take the quantile of |r| between the first "
        "`num_train` closes only.",
        partial(_read, flat_of=lambda sizes, _: sizes),
    ),
    (
        "the threshold knows one move too many: between `num_train` closes there are `num_train - 1` moves.",
        partial(_read, flat_of=lambda sizes, num_train: sizes[:num_train]),
    ),
    (
        "the bar t = 0 counts as a move of size 0, but it has none: that shifts the quantile.",
        partial(_read, flat_of=lambda sizes, num_train: np.concatenate([[0], sizes[: num_train - 1]])),
    ),
)


def _moves_and_threshold(case, window):
    """The moves between the closes that are shown, and the size up to which they are flat."""
    close, num_train, _ = case
    moves = " ".join(f"{r:.5f}" for r in np.diff(np.log(close[window])))
    return f"r between them: {moves.replace('-', '−')}\nflat = {threshold(close, num_train):.5f}"


_ENCODER = Encoder(window_states, lambda _, k: k, _MISREAD, _moves_and_threshold)
_OTHERWISE = (
    "the threshold, the digits or their order differ from what the task asks for. Print your moves, your threshold and "
    "your digits for the closes shown here, and work out the number by hand."
)


def _reads_two_moves(call, seed):
    close = lively(seed)
    _ENCODER.check(call, [(close, len(close), 2)], _OTHERWISE)


def _reads_other_windows(call, seed):
    cases = [(lively(10 * seed + k), 60, k) for k in (1, 3, 8)]
    _ENCODER.check(call, cases, _OTHERWISE)


def _takes_standing_still_for_flat(call, seed):
    markets = drowsy(seed), lively(seed)
    _ENCODER.check(
        call,
        [(close, len(close), 2) for close in markets],
        "this price often stands still, so that `flat` is 0. A move of 0 is flat there, and every other move is not.",
    )


def _knows_the_training_part_only(call, seed):
    cases = [(*wilder(10 * seed + k), k) for k in (1, 3)]
    likely = "the threshold is not the quantile at 1/3 of |r| between the first `num_train` closes: `np.quantile`."
    _ENCODER.check(call, cases, likely)


def _keeps_the_past(call, seed):
    close, num_train = wilder(seed)
    _ENCODER.check_past(call, [(close, num_train, 3)])


reads_moves_as_digits = Check(
    "reads_moves_as_digits",
    title="Task 1, moves as digits",
    usage="window_states(close, num_train, k)",
    trials=[
        Trial("two moves a state", "−1 for t < 2, then 3 · the older digit + the newer one", _reads_two_moves),
        Trial("windows of 1, 3 and 8 moves", "base-3 numbers, the oldest digit first", _reads_other_windows),
        Trial("a price that often stands still", "a move is flat where |r| <= flat", _takes_standing_still_for_flat),
        Trial(
            "a market that is wilder after its training part",
            "the threshold comes from the training part alone",
            _knows_the_training_part_only,
        ),
        Trial("the same past with other futures", "the same states up to there", _keeps_the_past),
    ],
    likely={
        "out of bounds|out of range": "your code asks for a close that is not there: there is one move less than there "
        "are closes, and none after the last close.",
        "too large to convert": _GROWS,
        "cannot convert float NaN": "NaN is no whole number: the bars before the window is full are to hold −1.",
    },
    hints=[
        "Three steps: the log returns of all closes, `np.diff(np.log(close))`; from each its digit; from each k digits "
        "one number. There is one return less than there are closes: the first belongs to t = 1.",
        "The threshold is `np.quantile(abs(returns[: num_train - 1]), 1 / 3)`: the returns between the first "
        "`num_train` closes. Up to that size a move is flat, digit 1; else it is 2 up, 0 down.",
        "A base-3 number from digits: begin with 0, and for each digit, the oldest first, `state = 3 * state + digit`. "
        "So down, flat, up is 0, then 1, then 3 · 1 + 2 = 5.",
        "Begin with `states = np.full(len(close), -1)`. For each t from k on the digits of the last k moves are "
        "`digits[t - k : t]`, if `digits[0]` is the move to t = 1.",
    ],
)
