"""Row t ends with the return up to bar t - 1."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "one bar too early"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns[: num_train - 1])
    scaled = np.clip(returns / sigma, -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k + 1, len(close)):
        rows[t] = scaled[t - k - 1 : t - 1]
    return rows
