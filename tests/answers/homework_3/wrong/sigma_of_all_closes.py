"""The scale is fitted on the test part as well."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "from all closes"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns)
    scaled = np.clip(returns / sigma, -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        rows[t] = scaled[t - k : t]
    return rows
