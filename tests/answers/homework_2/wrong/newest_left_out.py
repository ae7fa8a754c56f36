"""Low and high are those of the closes before."""

import numpy as np

CHECK = "stands_between_low_and_high"
SAYS = "leave out the newest close"


def minmax_states(close, m, levels):
    states = np.full(len(close), -1)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        low, high = window[:-1].min(), window[:-1].max()
        if high == low:
            states[t] = levels // 2
        else:
            states[t] = min(levels - 1, int(levels * (close[t] - low) / (high - low)))
    return states
