"""Divides by zero where the price stands still."""

import numpy as np

CHECK = "stands_between_low_and_high"
SAYS = "divides by zero, or gives another level than the middle one"


def minmax_states(close, m, levels):
    states = np.full(len(close), -1)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        low, high = window.min(), window.max()
        states[t] = min(levels - 1, int(levels * (close[t] - low) / (high - low)))
    return states
