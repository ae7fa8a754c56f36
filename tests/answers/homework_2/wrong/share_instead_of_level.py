"""The share of the way, not the level."""

import numpy as np

CHECK = "stands_between_low_and_high"
SAYS = "a state is a whole number"


def minmax_states(close, m, levels):
    states = np.full(len(close), -1.0)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            states[t] = levels // 2
        else:
            states[t] = (close[t] - low) / (high - low)
    return states
