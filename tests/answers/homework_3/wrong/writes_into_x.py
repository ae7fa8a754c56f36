"""Where shapes fit, results go into the array that was given."""

import numpy as np

CHECK = "passes_forward"
SAYS = "writes into `x`"


def q_values(x, layers):
    for weights, biases in layers[:-1]:
        out = x if weights.shape[0] == weights.shape[1] else None
        x = np.maximum(x @ weights + biases, 0, out=out)
    weights, biases = layers[-1]
    return x @ weights + biases
