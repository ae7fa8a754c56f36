"""A scaler fitted on the columns of the training rows."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "each column is scaled by itself"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    rows = np.full((len(close), k), np.nan)
    for t in range(k, len(close)):
        rows[t] = returns[t - k : t]
    train = rows[k:num_train]
    return np.clip((rows - train.mean(axis=0)) / train.std(axis=0), -5, 5)
