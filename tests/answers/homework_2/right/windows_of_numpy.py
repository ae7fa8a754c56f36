"""Everything that can be is done for all bars at once, with sliding_window_view; small integer types; numpy's own bool."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view


def window_states(close, num_train, k):
    r = np.diff(np.log(close))
    flat = np.percentile(abs(r[: num_train - 1]), 100 / 3)
    digits = ((r > flat).astype(int) - (r < -flat) + 1).astype(np.int64)
    powers = 3 ** np.arange(k)[::-1]
    return np.concatenate([np.full(k, -1), sliding_window_view(digits, k) @ powers])


def levels_of(windows, steps):
    low, high = windows.min(1), windows.max(1)
    with np.errstate(invalid="ignore"):
        share = (windows[:, -1] - low) / (high - low)
    share = np.where(high == low, 0, share)
    place = np.minimum(steps - 1, (steps * share).astype(int))
    return np.where(high == low, steps // 2, place)


def grid_states(close, n):
    windows = sliding_window_view(close, n)
    row = levels_of(windows, n)
    backwards = windows[:, ::-1]
    column = np.where(row >= n / 2, backwards.argmin(1), backwards.argmax(1))
    return np.pad(row * n + column, (n - 1, 0), constant_values=-1).astype(np.int16)


def minmax_states(close, m, levels):
    return np.pad(levels_of(sliding_window_view(close, m), levels), (m - 1, 0), constant_values=-1).astype(np.int8)


def reward(price, next_price, side, position, next_position, cost):
    return np.log1p(-cost * abs(next_position - position)) + np.log1p(side * next_position * (next_price / price - 1))


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    q = q_table.reshape(2, -1, 3)
    allowed = np.array([[True, True, False], [True, False, True]])[next_position]
    best = np.where(allowed, q[next_position, next_state], -np.inf).max()
    q[position, state, action] += alpha * (reward + gamma * best - q[position, state, action])


def trade(q_long, q_short, states):
    long, short = (q.reshape(2, -1, 3) for q in (q_long, q_short))
    gain = np.stack([short[0, :, 1] - short[0, :, 0], long[0, :, 1] - long[0, :, 0]])
    wanted = np.where(gain.max(0) > 0, np.sign(gain[1] - gain[0]), 0).astype(int)
    closes = {1: long[1, :, 2] > long[1, :, 0], -1: short[1, :, 2] > short[1, :, 0]}
    positions = np.zeros(len(states), np.int8)
    for t in np.flatnonzero(states >= 0):
        now = positions[t - 1] if t else 0
        s = states[t]
        if now == 0:
            positions[t] = wanted[s]
        elif not closes[int(now)][s]:
            positions[t] = now
        elif wanted[s] == -now:
            positions[t] = -now
    return positions


def looks_ahead(encode, close):
    states = encode(close)
    leak = np.False_
    for t in range(1, len(close)):
        future = np.where(np.arange(len(close)) < t, close, close[t - 1] * (1.3 if t % 2 else 0.7))
        leak |= np.any(encode(future)[:t] != states[:t])
    return leak
