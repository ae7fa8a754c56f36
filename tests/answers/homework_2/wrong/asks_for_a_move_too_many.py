"""Reads a move that is not there."""

import numpy as np

CHECK = "reads_moves_as_digits"
SAYS = "one move less than there are closes"


def window_states(close, num_train, k):
    returns = np.diff(np.log(close))
    flat = np.quantile(np.abs(returns[: num_train - 1]), 1 / 3)
    digits = np.where(np.abs(returns) <= flat, 1, np.where(returns > 0, 2, 0))
    states = np.full(len(close), -1)
    for t in range(k, len(close)):
        state = 0
        for i in range(k):
            state = 3 * state + digits[t - k + 1 + i]
        states[t] = state
    return states
