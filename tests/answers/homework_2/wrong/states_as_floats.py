"""The states are whole numbers, but floats."""

import numpy as np

CHECK = "reads_moves_as_digits"
SAYS = "your states are floats"


def window_states(close, num_train, k):
    returns = np.diff(np.log(close))
    flat = np.quantile(np.abs(returns[: num_train - 1]), 1 / 3)
    digits = np.where(np.abs(returns) <= flat, 1, np.where(returns > 0, 2, 0))
    states = np.full(len(close), -1.0)
    for t in range(k, len(close)):
        state = 0
        for digit in digits[t - k : t]:
            state = 3 * state + digit
        states[t] = state
    return states
