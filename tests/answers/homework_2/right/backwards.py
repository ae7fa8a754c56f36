"""Backwards from the last bar, with numbers as text, a match statement, and a helper for both windows."""

import math

import numpy as np

HOLD, OPEN, CLOSE = 0, 1, 2


def window_states(close, num_train, k):
    logs = np.log(close)
    moves = np.concatenate([[np.nan], logs[1:] - logs[:-1]])
    flat = np.nanquantile(np.abs(moves[:num_train]), 1 / 3)
    letters = "".join("1" if abs(move) <= flat else "02"[int(move > 0)] for move in moves)
    states = -np.ones(len(close), dtype=int)
    for t in reversed(range(k, len(close))):
        states[t] = int(letters[t - k + 1 : t + 1], base=3)
    return states


def from_windows(function, close, size):
    states = np.zeros(len(close), dtype=np.int32) - 1
    t = len(close) - 1
    while t >= size - 1:
        states[t] = function(close[t - size + 1 : t + 1])
        t -= 1
    return states


def standing(window, levels):
    low, high = sorted(window)[0], sorted(window)[-1]
    match high - low:
        case 0:
            return levels // 2
        case span:
            return max(i for i in range(levels) if i == 0 or levels * (window[-1] - low) / span >= i)


def grid_states(close, n):
    def cell(window):
        row = standing(window, n)
        wanted = min(window) if row >= n / 2 else max(window)
        return row * n + (n - 1 - np.flatnonzero(window == wanted).max())

    return from_windows(cell, close, n)


def minmax_states(close, m, levels):
    return from_windows(lambda window: standing(window, levels), close, m)


def reward(price, next_price, side, position, next_position, cost):
    match (side, next_position):
        case (_, 0):
            growth = 1
        case (1, 1):
            growth = next_price / price
        case _:
            growth = (2 * price - next_price) / price
    return np.array(math.log(growth) + (position != next_position) * math.log1p(-cost))


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    half = q_table.shape[0] // 2
    there = q_table[half * next_position + next_state].tolist()
    del there[CLOSE if next_position == 0 else OPEN]
    here = (half * position + state, action)
    q_table[here] = q_table[here] + alpha * (reward + gamma * max(there) - q_table[here])
    return q_table


def trade(q_long, q_short, states):
    half = len(q_long) // 2
    path = [0]
    for state in states.tolist():
        match path[-1]:
            case _ if state == -1:
                path.append(0)
                continue
            case 1 if q_long[half + state, CLOSE] <= q_long[half + state, HOLD]:
                path.append(1)
                continue
            case -1 if q_short[half + state, CLOSE] <= q_short[half + state, HOLD]:
                path.append(-1)
                continue
        up, down = (table[state, OPEN] - table[state, HOLD] for table in (q_long, q_short))
        choice = 1 if up > max(0, down) else -1 if down > max(0, up) else 0
        path.append(0 if choice == path[-1] else choice)
    return path[1:]


def looks_ahead(encode, close):
    t = len(close) - 1
    while t > 0:
        longer = np.concatenate([close[:t], np.linspace(close[t - 1], 2 * close[t - 1], 2 * len(close) - t)])
        if encode(longer)[:t].tolist() != encode(close)[:t].tolist():
            return True
        t -= 1
    return False
