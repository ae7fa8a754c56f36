"""The window ends one close later."""

import numpy as np

CHECK = "stands_between_low_and_high"
SAYS = "look ahead: the one at t knows the close at t + 1"


def minmax_states(close, m, levels):
    states = np.full(len(close), -1)
    for t in range(m - 1, len(close)):
        now = min(t + 1, len(close) - 1)
        window = close[now - m + 1 : now + 1]
        low, high = window.min(), window.max()
        if high == low:
            states[t] = levels // 2
        else:
            states[t] = min(levels - 1, int(levels * (close[now] - low) / (high - low)))
    return states
