"""A price that stands still is on level 0."""

import numpy as np

CHECK = "stands_between_low_and_high"
SAYS = "with high = low the level is levels // 2"


def minmax_states(close, m, levels):
    states = np.full(len(close), -1)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            states[t] = 0
        else:
            states[t] = min(levels - 1, int(levels * (close[t] - low) / (high - low)))
    return states
