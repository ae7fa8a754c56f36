"""What an agent sees of a price history: three ways of making a state, and the inputs of a network.

All four do the same. A state at bar t depends on closes up to bar t, and else on what `fit` has seen.

fit(close)        learn scale or thresholds from the training part's closes; gives itself
transform(close)  for every close of a history what is seen there: int64[T], -1 in the first `warmup` bars, or float32
                  [T, k], NaN there
warmup            bars at the beginning of a history that are needed before there is anything to see
num_states        how many states there are; None for inputs of a network
describe(state)   a state in words
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from course_lib.market.prices import PriceDataError, as_price_errors
from course_lib.validate import number, whole_number


@dataclass(frozen=True, eq=False)
class _Closes:
    """Closes, float64[T], and the day of each as a number, int64[T], where they came with dates."""

    values: np.ndarray
    days: np.ndarray | None

    @property
    def moves(self):
        """Log returns, float64[T - 1]."""
        return np.diff(np.log(self.values))


class _Encoder:
    """What all have in common. A kind of encoder gives `_learn` and `_encode`, for `_Closes`."""

    num_states, warmup = None, 0
    fitted_until = None  # the last date that `fit` has seen, where the closes had dates

    def fit(self, close):
        """Learn what is to be learned from these closes, which must be of the training part alone; gives itself."""
        self._learn(_checked(close, at_least=max(self.warmup, 1) + 1))
        self.fitted_until = close.index[-1] if _has_dates(close) else None
        self._is_fitted = True
        return self

    def transform(self, close):
        """What is seen at every bar of these closes, as the module says; `PriceDataError` before `fit`."""
        if not getattr(self, "_is_fitted", False):
            raise PriceDataError(
                f"the {type(self).__name__} is not fitted yet: call fit(close) with the training closes first"
            )
        return self._encode(_checked(close))

    def describe(self, state):
        """A state in words. `ValueError` for one that is out of range."""
        return self._words(whole_number("state", state, below=self.num_states))


class WindowEncoder(_Encoder):
    """The directions of the last k moves: a base-3 number, a digit a move, the newest least significant; 3^k states.

    A move is the log return r of a bar: down (digit 0), flat (1) if |r| <= `flat`, or up (2).

    flat  a number >= 0, or "third": the 1/3 quantile of |r| in training, which makes the three about equally frequent
          on every market
    """

    def __init__(self, k=8, flat="third"):
        self.k = _size("k", k, at_least=1, at_most=16)
        self.flat = flat if flat == "third" else _not_negative("flat", flat)
        self.warmup, self.num_states = self.k, 3**self.k
        self.threshold = None if flat == "third" else self.flat

    def _learn(self, closes):
        if self.flat == "third":
            self.threshold = float(np.quantile(np.abs(closes.moves), 1 / 3))

    def _encode(self, closes):
        states = np.full(len(closes.values), -1)
        moves, flat = closes.moves, self.threshold * (1 + 1e-9)  # moves alike but for rounding are one digit
        digits = 1 + (moves > flat).astype(np.int64) - (moves < -flat)
        if len(digits) >= self.k:
            states[self.k :] = sliding_window_view(digits, self.k) @ 3 ** np.arange(self.k)[::-1]
        return states

    def digits(self, state):
        """The moves of a state, -1, 0 or 1, oldest first: int64[k]."""
        state = whole_number("state", state, below=self.num_states)
        return state // 3 ** np.arange(self.k)[::-1] % 3 - 1

    def _words(self, state):
        return ", ".join(("down", "flat", "up")[move + 1] for move in self.digits(state)) + " (the newest last)"


class GridEncoder(_Encoder):
    """A price on a grid of n rows and columns: state = row * n + column, numbered as in the maze; row 0 is the lowest.

    mode "turn"  a moving window of n closes. row: where the newest close stands between the window's low and high, in n
                 levels; column: bars since the opposite extreme, the low for a close in the upper half, else the high.
                 So a column says how long the last swing has taken, and its end is where prices turn.
    mode "day"   a day of n bars drawn on a grid. column: bar of the day; row: the price around the day's first close in
                 log steps of which the largest deviation in training takes n // 2. Days are told by the dates where
                 they have times of day, else every n bars are one.
    """

    def __init__(self, n=8, mode="turn"):
        self.n = _size("n", n, at_least=2, at_most=1000)
        if mode not in ("turn", "day"):
            raise PriceDataError(f"mode must be 'turn' or 'day', got {mode!r}")
        self.mode, self.num_states = mode, self.n**2
        self.warmup = self.n - 1 if mode == "turn" else 0
        self.step = None

    def _learn(self, closes):
        if self.mode == "day":
            moved, bar = self._since_base(closes)
            begins = np.append(np.flatnonzero(bar == 0), len(bar))
            if len(begins) > 2 and begins[1] < np.diff(begins).max():  # cut off: its first close is not the day's
                moved = moved[begins[1] :]
            largest = np.abs(moved).max()
            if largest == 0:
                raise PriceDataError("no price moves within a day: is each bar a day? A day needs several bars")
            self.step = float(largest / (self.n // 2))

    def _encode(self, closes):
        if self.mode == "day":
            moved, bar = self._since_base(closes)
            rows = np.clip(self.n // 2 + np.rint(moved / self.step), 0, self.n - 1).astype(np.int64)
            return rows * self.n + bar
        states = np.full(len(closes.values), -1)
        if len(closes.values) < self.n:
            return states
        windows = sliding_window_view(closes.values, self.n)[:, ::-1]  # the newest first
        low, high = windows.min(axis=1), windows.max(axis=1)
        row = _level(windows[:, 0], low, high, self.n)
        opposite = np.where(2 * row >= self.n, low, high)
        states[self.warmup :] = row * self.n + np.argmax(windows == opposite[:, None], axis=1)
        return states

    def _since_base(self, closes):
        """Log of each close over its day's first, float64[T], and the number of its bar in the day, int64[T]."""
        number = np.arange(len(closes.values))
        first = number - number % self.n
        if closes.days is not None and len(np.unique(closes.days)) < len(closes.days):
            first = np.searchsorted(closes.days, closes.days)
            longest = int((number - first).max()) + 1
            if longest > self.n:
                raise PriceDataError(f"a day has {longest} bars, more than {self.n}: use n={longest}")
        return np.log(closes.values / closes.values[first]), number - first

    def _words(self, state):
        row, column = divmod(state, self.n)
        if self.mode == "day":
            return f"bar {column + 1} of the day, the price in row {row} of {self.n}, counted from the lowest"
        extreme = "low" if 2 * row >= self.n else "high"
        return f"the price in row {row} of {self.n}, counted from the lowest; {column} bars since the {extreme}"


class MinMaxEncoder(_Encoder):
    """On which of so many levels the newest close stands between the low and the high of the last m closes.

    m  None takes low and high from training: best where a price always comes back, useless where it drifts away
    """

    def __init__(self, m=60, levels=10):
        self.m = None if m is None else _size("m", m, at_least=2, at_most=100_000)
        self.num_states = self.levels = _size("levels", levels, at_least=2, at_most=10_000)
        self.warmup = 0 if m is None else self.m - 1
        self.low = self.high = None

    def _learn(self, closes):
        self.low, self.high = float(closes.values.min()), float(closes.values.max())

    def _encode(self, closes):
        if self.m is None:
            return _level(np.clip(closes.values, self.low, self.high), self.low, self.high, self.levels)
        states = np.full(len(closes.values), -1)
        if len(closes.values) >= self.m:
            windows = sliding_window_view(closes.values, self.m)
            states[self.warmup :] = _level(
                closes.values[self.warmup :], windows.min(axis=1), windows.max(axis=1), self.levels
            )
        return states

    def _words(self, state):
        of_what = "training" if self.m is None else f"the last {self.m} closes"
        return f"level {state} of {self.levels} between the low and the high of {of_what}, counted from the low"


class ReturnsEncoder(_Encoder):
    """The last k log returns, oldest first, over their standard deviation in training, clipped: for a network."""

    def __init__(self, k=8, clip=5.0):
        self.k, self.clip = _size("k", k, at_least=1, at_most=10_000), _not_negative("clip", clip)
        self.warmup, self.sigma = self.k, None

    def _learn(self, closes):
        self.sigma = float(closes.moves.std())
        if self.sigma == 0:
            raise PriceDataError("the closes never move in training: there is no scale for their returns")

    def _encode(self, closes):
        seen = np.full((len(closes.values), self.k), np.nan, np.float32)
        scaled = np.clip(closes.moves / self.sigma, -self.clip, self.clip)
        if len(scaled) >= self.k:
            seen[self.k :] = sliding_window_view(scaled, self.k)
        return seen

    def describe(self, state):
        """What is seen, float[k], in words."""
        return (
            ", ".join(f"{value:+.1f}" for value in np.asarray(state)[: self.k])
            + " standard deviations (the newest last)"
        )


def _level(values, low, high, levels):
    """On which of so many equal levels from low to high, int64; the middle one where these are the same."""
    span = high - low
    with np.errstate(invalid="ignore", divide="ignore"):
        level = np.floor(levels * (values - low) / span)
    return np.where(span > 0, np.minimum(np.nan_to_num(level), levels - 1), levels // 2).astype(np.int64)


def _has_dates(close):
    return isinstance(close, pd.Series) and isinstance(close.index, pd.DatetimeIndex)


def _checked(close, at_least=1):
    """`_Closes`, or a `PriceDataError`."""
    try:
        values = np.asarray(close, dtype=float)
    except (TypeError, ValueError):
        raise PriceDataError("closes must be numbers: use pandas.to_numeric") from None
    if values.ndim != 1:
        raise PriceDataError(f"closes must be one column of numbers, got shape {values.shape}")
    if len(values) < at_least:
        raise PriceDataError(f"{at_least} closes are needed, {len(values)} are given: take a longer stretch")
    is_bad = ~(np.isfinite(values) & (values > 0))
    if is_bad.any():
        place = int(np.argmax(is_bad))
        where = f"on {close.index[place]:%Y-%m-%d}" if _has_dates(close) else f"in place {place}"
        raise PriceDataError(f"closes must be positive and finite, got {values[place]} {where}: correct it")
    return _Closes(values, close.index.normalize().asi8 if _has_dates(close) else None)


def _size(name, value, *, at_least, at_most):
    with as_price_errors():
        return whole_number(name, value, at_least=at_least, below=at_most + 1)


def _not_negative(name, value):
    with as_price_errors():
        result = number(name, value)
    if result < 0:
        raise PriceDataError(f"{name} must not be negative, got {value!r}")
    return result
