"""Shifted columns, each with its own gap."""

import numpy as np
import pandas as pd

CHECK = "scales_by_what_it_may_know"
SAYS = "NaN in part"


def network_inputs(close, num_train, k):
    returns = np.log(pd.Series(close)).diff()
    scaled = (returns / returns[:num_train].std(ddof=0)).clip(-5, 5)
    return pd.concat([scaled.shift(lag) for lag in range(k - 1, -1, -1)], axis=1).to_numpy()
