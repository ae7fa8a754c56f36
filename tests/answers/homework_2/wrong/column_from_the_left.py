"""The column is the place of the extreme in the window."""

import numpy as np

CHECK = "finds_turns_on_a_grid"
SAYS = "from the left"


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
            column = window.argmin()
        else:
            column = window.argmax()
        states[t] = row * n + column
    return states
