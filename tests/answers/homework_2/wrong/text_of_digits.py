"""The digits as text."""

import numpy as np

CHECK = "reads_moves_as_digits"
SAYS = "something else than one state for each bar"


def window_states(close, num_train, k):
    returns = np.diff(np.log(close))
    flat = np.quantile(np.abs(returns[: num_train - 1]), 1 / 3)
    digits = np.where(np.abs(returns) <= flat, 1, np.where(returns > 0, 2, 0))
    states = [""] * len(close)
    for t in range(k, len(close)):
        states[t] = "".join(str(digit) for digit in digits[t - k : t])
    return states
