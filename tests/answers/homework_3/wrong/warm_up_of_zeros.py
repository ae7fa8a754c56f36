"""The first rows are zeros."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "filled with zeros. Zero says"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns[: num_train - 1])
    scaled = np.clip(returns / sigma, -5, 5)
    rows = np.zeros((len(close), k))
    for t in range(k, len(close)):
        rows[t] = scaled[t - k : t]
    return rows
