"""Returns before the first bar count as zero."""

import numpy as np

CHECK = "scales_by_what_it_may_know"
SAYS = "what is missing in the first k rows"


def network_inputs(close, num_train, k):
    returns = np.diff(np.log(close))
    scaled = np.clip(returns / np.std(returns[: num_train - 1]), -5, 5)
    padded = np.concatenate([np.zeros(k), scaled])
    return np.array([padded[t : t + k] for t in range(len(close))])
