"""Row t ends with the return from bar t to bar t + 1."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "one bar ahead"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns[: num_train - 1])
    scaled = np.clip(returns / sigma, -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close) - 1):
        rows[t] = scaled[t - k + 1 : t + 1]
    return rows
