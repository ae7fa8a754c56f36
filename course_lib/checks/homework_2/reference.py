"""What the tasks of homework 2 ask for, written to be read. T closes; S states; log is the natural logarithm."""

import math

import numpy as np

HOLD, OPEN, CLOSE = range(3)
OUT, IN = range(2)  # the position: out of or in a side's trade
POSSIBLE = {OUT: (HOLD, OPEN), IN: (HOLD, CLOSE)}
NO_STATE = -1  # while the window is not full


def window_states(close, num_train, k):
    """int[T]: the last k moves, each a digit (0 down, 1 flat, 2 up), as a base-3 number whose last digit is the newest.

    A move is flat where |log return| <= the `threshold` of the training part. -1 for t < k.
    """
    returns, flat = np.diff(np.log(close)), threshold(close, num_train)
    digits = [1 if abs(r) <= flat else 2 if r > 0 else 0 for r in returns.tolist()]  # digits[t - 1]: the move to t
    return np.array([NO_STATE if t < k else base_3(digits[t - k : t]) for t in range(len(close))])


def threshold(close, num_train):
    """Up to which size a move is flat: the 1/3 quantile of the log returns between the first `num_train` closes."""
    return np.quantile(np.abs(np.diff(np.log(close[:num_train]))), 1 / 3)


def base_3(digits):
    """The number that these digits write, the last one the least significant."""
    number = 0
    for digit in digits:
        number = 3 * number + digit
    return number


def grid_states(close, n):
    """int[T]: row * n + column. row: the level of the newest of n closes between their low and high, one of n.

    column: bars since the low for a close in the upper half (row >= n / 2), else since the high; the latest of equal
    ones. -1 for t < n - 1.
    """
    states = np.full(len(close), NO_STATE)
    for t in range(n - 1, len(close)):
        window = close[t - n + 1 : t + 1]
        row = level(close[t], window.min(), window.max(), n)
        opposite = window.min() if row >= n / 2 else window.max()
        states[t] = row * n + window[::-1].tolist().index(opposite)
    return states


def minmax_states(close, m, levels):
    """int[T]: the level, of `levels`, of the newest of m closes between their low and high. -1 for t < m - 1."""
    states = np.full(len(close), NO_STATE)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        states[t] = level(close[t], window.min(), window.max(), levels)
    return states


def level(close, low, high, levels):
    """Which of the equal steps from low to high a close stands on, 0 … levels - 1; the middle if there is one price."""
    if high == low:
        return levels // 2
    return min(levels - 1, int(levels * (close - low) / (high - low)))


def reward(price, next_price, side, position, next_position, cost):
    """log(money at next_price / money before): a trade costs the fraction `cost`; side 1 long, -1 short."""
    money = 1 - cost if next_position != position else 1
    money *= 1 + side * next_position * (next_price / price - 1)
    return math.log(money)


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    """Q-learning in place on float[2 S, 3], row = position * S + state, its maximum over possible actions only."""
    num_states = len(q_table) // 2
    row, next_row = position * num_states + state, next_position * num_states + next_state
    best = max(q_table[next_row, a] for a in POSSIBLE[next_position])
    q_table[row, action] += alpha * (reward + gamma * best - q_table[row, action])


def trade(q_long, q_short, states):
    """int[T]: the position -1, 0 or 1 after each bar's greedy decision of two tables float[2 S, 3]; ties hold.

    In a trade its own table decides. Out of one, or in the bar of a close, the side with the larger advantage of
    opening over holding opens, if that is positive; but a side that has closed in this bar does not open again in it.
    """
    num_states, position, positions = len(q_long) // 2, 0, []
    for state in states:
        closed = 0
        if state == NO_STATE:
            position = 0
        elif position:
            row = (q_long if position > 0 else q_short)[IN * num_states + state]
            if row[CLOSE] > row[HOLD]:
                closed, position = position, 0
        if state != NO_STATE and position == 0:
            row = OUT * num_states + state
            long, short = (table[row, OPEN] - table[row, HOLD] for table in (q_long, q_short))
            wanted = 0 if max(long, short) <= 0 or long == short else 1 if long > short else -1
            position = 0 if wanted == closed else wanted
        positions.append(position)
    return np.array(positions)
