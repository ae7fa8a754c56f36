"""Each window has a sigma of its own."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "its own standard deviation"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        window = returns[t - k : t]
        rows[t] = np.clip(window / np.std(window), -5, 5)
    return rows
