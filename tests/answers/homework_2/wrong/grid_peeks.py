"""The window ends one close later."""

import numpy as np

CHECK = "finds_turns_on_a_grid"
SAYS = "look ahead: the one at t knows the close at t + 1"


def grid_states(close, n):
    states = np.full(len(close), -1)
    for t in range(n - 1, len(close)):
        now = min(t + 1, len(close) - 1)
        window = close[now - n + 1 : now + 1]
        low, high = window.min(), window.max()
        if high == low:
            row = n // 2
        else:
            row = min(n - 1, int(n * (close[now] - low) / (high - low)))
        if row >= n / 2:
            column = window[::-1].argmin()
        else:
            column = window[::-1].argmax()
        states[t] = row * n + column
    return states
