"""Divides by zero where the price stands still."""

import numpy as np

CHECK = "finds_turns_on_a_grid"
SAYS = "divides by zero, or gives another level than the middle one"


def grid_states(close, n):
    states = np.full(len(close), -1)
    for t in range(n - 1, len(close)):
        window = close[t - n + 1 : t + 1]
        low, high = window.min(), window.max()
        row = min(n - 1, int(n * (close[t] - low) / (high - low)))
        if row >= n / 2:
            column = window[::-1].argmin()
        else:
            column = window[::-1].argmax()
        states[t] = row * n + column
    return states
