"""A table of pandas, not an array."""

import numpy as np
import pandas as pd

CHECK = "scales_by_what_it_may_know"
SAYS = ".to_numpy()"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    sigma = np.std(returns[: num_train - 1])
    scaled = np.clip(returns / sigma, -5, 5)
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        rows[t] = scaled[t - k : t]
    return pd.DataFrame(rows)
