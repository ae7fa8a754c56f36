"""Encoders with and without a leak: functions close float64[T] -> int[T], -1 where there is no state, for any T."""

from functools import wraps

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from course_lib.checks.homework_2.reference import NO_STATE

_FLAT = 0.004  # log return
COARSE = 0.05  # log price
_SALT = 2_654_435_761  # Knuth's multiplier: what it is multiplied by looks random


def _quietly(encoder):
    """Closes may be NaN, infinite or negative where a learner has changed them, and there may be none."""

    @wraps(encoder)
    def encode(close):
        if not len(close):
            return np.zeros(0, np.int64)
        with np.errstate(all="ignore"):
            return encoder(np.asarray(close, float)).astype(np.int64)

    return encode


def _digits(close):
    """-1, then 0 down, 1 flat, 2 up."""
    digits = np.full(len(close), NO_STATE)
    returns = np.log(close[1:] / close[:-1])
    digits[1:] = 1 + (returns > _FLAT) - (returns < -_FLAT)
    return digits


def _levels(close, number):
    """The level of each close in the window of that many closes that ends there."""
    states = np.full(len(close), NO_STATE)
    if len(close) >= number:
        windows = sliding_window_view(close, number)
        states[number - 1 :] = _level(close[number - 1 :], windows.min(axis=1), windows.max(axis=1))
    return states


def _level(newest, low, high, levels=10):
    """Which of ten steps between low and high; the lowest where one of them is no number."""
    place = np.where(high == low, levels // 2, levels * (newest - low) / (high - low))
    return np.nan_to_num(place).clip(0, levels - 1).astype(np.int64)


def _noise(close, kinds):
    """A number from 0 to kinds - 1 for each close that looks random, and is always the same for the same close."""
    cents = np.nan_to_num(np.round(close * 100), posinf=1e9, neginf=-1e9).clip(-1e9, 1e9).astype(np.int64)
    return (cents * _SALT % 2**32 >> 12) % kinds


def _later(values, bars, otherwise=0):
    """What comes that many bars later, and `otherwise` where nothing does."""
    moved = np.full(len(values), otherwise)
    moved[: max(0, len(values) - bars)] = values[bars:]
    return moved


# --- without a leak ---------------------------------------------------------------------------------------------------


@_quietly
def last_moves(close):
    """The last three moves."""
    digits, states = _digits(close), np.full(len(close), NO_STATE)
    states[3:] = 9 * digits[1:-2] + 3 * digits[2:-1] + digits[3:]
    return states


@_quietly
def last_low_and_high(close):
    """Between the low and the high of the last 12 closes."""
    return _levels(close, 12)


@_quietly
def long_warm_up(close):
    """The same of the last 70: -1 for most of a short series."""
    return _levels(close, 70)


@_quietly
def looks_random(close):
    """Numbers without rhyme or reason, but of the last two closes alone."""
    states = _noise(close, 27)
    states[1:] = (states[1:] + 5 * states[:-1]) % 27
    return states


# --- with a leak ------------------------------------------------------------------------------------------------------


@_quietly
def one_bar(close):
    """The next move is among the three."""
    digits, states = _digits(close), np.full(len(close), NO_STATE)
    states[2:] = 9 * digits[1:-1] + 3 * digits[2:] + _later(digits, 1, 1)[2:]
    return states


@_quietly
def three_bars(close):
    """Whether the price will be higher three bars later."""
    states = _levels(close, 12)
    states[states >= 0] += 10 * (_later(close, 3, -np.inf) > close)[states >= 0]
    return states


@_quietly
def twenty_bars(close):
    """Whether the price will be higher twenty bars later."""
    states = _levels(close, 12)
    states[states >= 0] += 10 * (_later(close, 20, -np.inf) > close)[states >= 0]
    return states


@_quietly
def centred(close):
    """Between the low and the high of the five closes before and the five after."""
    windows = sliding_window_view(np.pad(close, 5, mode="edge"), 11)
    return _level(close, windows.min(axis=1), windows.max(axis=1))


@_quietly
def all_lows_and_highs(close):
    """Between the low and the high of all closes."""
    return _level(close, close.min(), close.max())


@_quietly
def coarse_low_and_high_of_all(close):
    """Between a low and a high of all closes that stay where they are if one close changes, or all a little."""
    low, high = coarse_low_and_high(close)
    return _level(close, np.exp(COARSE * np.floor(low)), np.exp(COARSE * np.ceil(high)))


def coarse_low_and_high(close):
    """float[2]: the closes that a tenth of all is below, and a tenth above: their logarithms in steps of `COARSE`."""
    return np.quantile(np.log(close), [0.1, 0.9]) / COARSE


@_quietly
def thresholds_of_all(close):
    """In which fifth of all moves the last one lies, by size: another future moves that in a few bars."""
    states, sizes = np.full(len(close), NO_STATE), np.abs(np.log(close[1:] / close[:-1]))
    if len(sizes):
        states[1:] = (sizes[:, None] > np.quantile(sizes, [0.2, 0.4, 0.6, 0.8])).sum(axis=1)
    return states


@_quietly
def now_and_then(close):
    """The last moves; after two that are alike and not flat, what the next close is has a part in it too."""
    states = last_moves(close)
    seldom = np.isin(states % 9, (0, 8))
    states[seldom] += 27 * (1 + _noise(_later(close, 1, 0.0), 20))[seldom]
    return states


@_quietly
def only_at_the_end(close):
    """The last moves; in the last three bars the last close has a part in it."""
    states = last_moves(close)
    if len(close) > 6:
        states[-3:] += 27 * (1 + _noise(close[-1:], 9973))
    return states
