"""pandas divides by n - 1."""

import numpy as np
import pandas as pd

CHECK = "scales_by_what_it_may_know"
SAYS = "ddof=0"


def network_inputs(close, num_train, k):
    returns = np.log(pd.Series(close)).diff()
    scaled = (returns / returns[:num_train].std()).clip(-5, 5)
    table = pd.concat([scaled.shift(lag) for lag in range(k - 1, -1, -1)], axis=1)
    table[table.isna().any(axis=1)] = np.nan
    return table.to_numpy()
