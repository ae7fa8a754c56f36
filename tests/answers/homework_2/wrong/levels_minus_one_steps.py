"""The steps are too large."""

import numpy as np

CHECK = "stands_between_low_and_high"
SAYS = "not equal steps"


def minmax_states(close, m, levels):
    states = np.full(len(close), -1)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            states[t] = levels // 2
        else:
            states[t] = int((levels - 1) * (close[t] - low) / (high - low))
    return states
