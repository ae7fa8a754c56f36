"""Counts the bars of the window."""

import numpy as np

CHECK = "finds_turns_on_a_grid"
SAYS = "row or column differ"


def grid_states(close, n):
    states = np.full(len(close), -1)
    for t in range(n - 1, len(close)):
        window = close[t - n + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            row = n // 2
        else:
            row = min(n - 1, int(n * (close[t] - low) / (high - low)))
        if row >= n / 2:
            column = n - 1
        else:
            column = n - 1
        states[t] = row * n + column
    return states
