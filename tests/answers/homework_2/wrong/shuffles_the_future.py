"""The other future has the same closes in another order."""

import numpy as np

CHECK = "finds_the_leak"
SAYS = "made of the same closes in another order"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = np.concatenate([close[: t + 1], close[: t - len(close) : -1]])
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
    return False
