"""Low and high are those of all closes."""

import numpy as np

CHECK = "stands_between_low_and_high"
SAYS = "those of all closes: only the last m"


def minmax_states(close, m, levels):
    states = np.full(len(close), -1)
    for t in range(m - 1, len(close)):
        window = close[t - m + 1 : t + 1]
        low, high = close.min(), close.max()
        if high == low:
            states[t] = levels // 2
        else:
            states[t] = min(levels - 1, int(levels * (close[t] - low) / (high - low)))
    return states
