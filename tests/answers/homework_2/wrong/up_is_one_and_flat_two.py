"""Digits 0 down, 1 up, 2 flat."""

import numpy as np

CHECK = "reads_moves_as_digits"
SAYS = "your digits stand for other moves"


def window_states(close, num_train, k):
    returns = np.diff(np.log(close))
    flat = np.quantile(np.abs(returns[: num_train - 1]), 1 / 3)
    digits = np.where(np.abs(returns) <= flat, 2, np.where(returns > 0, 1, 0))
    states = np.full(len(close), -1)
    for t in range(k, len(close)):
        state = 0
        for digit in digits[t - k : t]:
            state = 3 * state + digit
        states[t] = state
    return states
