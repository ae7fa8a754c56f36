"""As the tasks say it, with numpy where it helps; the future is changed after every bar."""

import numpy as np


def window_states(close, num_train, k):
    returns = np.diff(np.log(close))
    flat = np.quantile(np.abs(returns[: num_train - 1]), 1 / 3)
    digits = np.where(np.abs(returns) <= flat, 1, np.where(returns > 0, 2, 0))
    states = np.full(len(close), -1)
    for t in range(k, len(close)):
        state = 0
        for digit in digits[t - k : t]:
            state = 3 * state + digit
        states[t] = state
    return states


def grid_states(close, n):
    states = np.full(len(close), -1)
    for t in range(n - 1, len(close)):
        window = close[t - n + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            row = n // 2
        else:
            row = min(n - 1, int(n * (close[t] - low) / (high - low)))
        newest_first = window[::-1]
        column = newest_first.argmin() if row >= n / 2 else newest_first.argmax()
        states[t] = row * n + column
    return states


def minmax_states(close, m, levels):
    states = np.full(len(close), -1)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            states[t] = levels // 2
        else:
            states[t] = min(levels - 1, int(levels * (close[t] - low) / (high - low)))
    return states


def reward(price, next_price, side, position, next_position, cost):
    money = 1.0
    if next_position != position:
        money *= 1 - cost
    money *= 1 + side * next_position * (next_price / price - 1)
    return np.log(money)


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    row = position * num_states + state
    next_row = next_position * num_states + next_state
    possible = [0, 2] if next_position == 1 else [0, 1]
    target = reward + gamma * q_table[next_row, possible].max()
    q_table[row, action] += alpha * (target - q_table[row, action])


def trade(q_long, q_short, states):
    num_states = len(q_long) // 2
    position = 0
    positions = []
    for state in states:
        if state == -1:
            positions.append(0)
            continue
        closed = 0
        if position != 0:
            table = q_long if position == 1 else q_short
            row = table[num_states + state]
            if row[2] > row[0]:
                closed = position
                position = 0
        if position == 0:
            long = q_long[state, 1] - q_long[state, 0]
            short = q_short[state, 1] - q_short[state, 0]
            wanted = 0
            if long > short and long > 0:
                wanted = 1
            if short > long and short > 0:
                wanted = -1
            if wanted != closed:
                position = wanted
        positions.append(position)
    return np.array(positions)


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] = 2 * other[t + 1 :]
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
    return False
