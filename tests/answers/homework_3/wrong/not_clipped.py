"""Nothing is clipped."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "comes last, after the division"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns[: num_train - 1])
    scaled = returns / sigma
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        rows[t] = scaled[t - k : t]
    return rows
