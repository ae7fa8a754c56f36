"""Functions that call themselves, reduce and generators; the future becomes NaN."""

from functools import reduce
from itertools import accumulate, pairwise
from math import log
from statistics import quantiles

import numpy as np


def number_of(digits):
    return number_of(digits[:-1]) * 3 + digits[-1] if digits else 0


def window_states(close, num_train, k):
    returns = [log(b) - log(a) for a, b in pairwise(close)]
    flat = quantiles(map(abs, returns[: num_train - 1]), n=3, method="inclusive")[0]
    digits = [(r > flat) + (r >= -flat) for r in returns]
    return [-1] * min(k, len(close)) + [number_of(digits[t - k : t]) for t in range(k, len(close))]


def steps_up(price, low, high, levels, level=0):
    """How many equal steps lie below the price."""
    if high == low:
        return levels // 2
    if level == levels - 1 or price - low < (high - low) * (level + 1) / levels:
        return level
    return steps_up(price, low, high, levels, level + 1)


def bars_since(window, value):
    return 0 if window[-1] == value else 1 + bars_since(window[:-1], value)


def grid_state(window):
    n = len(window)
    row = steps_up(window[-1], min(window), max(window), n)
    return n * row + bars_since(window, min(window) if row >= n / 2 else max(window))


def windows(close, number):
    values = tuple(close)
    return (values[max(0, t + 1 - number) : t + 1] for t in range(len(values)))


def grid_states(close, n):
    return [grid_state(window) if len(window) == n else -1 for window in windows(close, n)]


def minmax_states(close, m, levels):
    return tuple(
        steps_up(window[-1], min(window), max(window), levels) if len(window) == m else -1
        for window in windows(close, m)
    )


def reward(price, next_price, side, position, next_position, cost):
    factors = [(1 - cost) if position != next_position else 1]
    if next_position:
        factors += [1 + side * (next_price - price) / price]
    return log(reduce(lambda a, b: a * b, factors))


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    out, inside = np.split(q_table, 2)
    now, then = (out, inside)[position], (out, inside)[next_position]
    best = max(then[next_state, 0], then[next_state, 2 if next_position else 1])
    now[state, action] -= alpha * (now[state, action] - reward - gamma * best)


def trade(q_long, q_short, states):
    number = len(q_long) // 2

    def opening(state):
        gains = {1: q_long[state, 1] - q_long[state, 0], -1: q_short[state, 1] - q_short[state, 0]}
        side = max(gains, key=gains.get)
        return side if gains[side] > max(0, gains[-side]) else 0

    def decide(position, state):
        if state == -1:
            return 0
        if position == 0:
            return opening(state)
        hold, _, close = (q_long if position == 1 else q_short)[number + state]
        if close <= hold:
            return position
        return opening(state) if opening(state) == -position else 0

    return list(accumulate(states, decide, initial=0))[1:]


def looks_ahead(encode, close):
    states = encode(close)

    def leaks_after(t):
        other = np.where(np.arange(len(close)) > t, np.nan, close)
        return not np.array_equal(encode(other)[: t + 1], states[: t + 1])

    return any(leaks_after(t) for t in range(len(close) - 1))
