"""The first return after the training part goes into sigma."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "one return too many"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns[:num_train])
    scaled = np.clip(returns / sigma, -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        rows[t] = scaled[t - k : t]
    return rows
