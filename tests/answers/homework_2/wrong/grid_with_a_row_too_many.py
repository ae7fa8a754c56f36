"""At the high the row is n."""

import numpy as np

CHECK = "finds_turns_on_a_grid"
SAYS = "the highest level is too high"


def grid_states(close, n):
    states = np.full(len(close), -1)
    for t in range(n - 1, len(close)):
        window = close[t - n + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            row = n // 2
        else:
            row = int(n * (close[t] - low) / (high - low))
        if row >= n / 2:
            column = window[::-1].argmin()
        else:
            column = window[::-1].argmax()
        states[t] = row * n + column
    return states
