"""Subtracts the mean, as scalers do."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "subtracts the mean"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns[: num_train - 1])
    scaled = np.clip((returns - returns[: num_train - 1].mean()) / sigma, -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        rows[t] = scaled[t - k : t]
    return rows
