"""Windows of prices."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "hold prices"


def network_inputs(close, num_train, k):
    scaled = np.clip(close / np.std(close[:num_train]), -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        rows[t] = scaled[t - k + 1 : t + 1]
    return rows
