"""Bar 0 has a return of zero, so the rows begin a bar too early."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "bar 0 has a return"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close), prepend=np.log(close[0]))
    scaled = np.clip(returns / np.std(returns[1:num_train]), -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k - 1, len(close)):
        rows[t] = scaled[t - k + 1 : t + 1]
    return rows
