"""The biases are forgotten."""

import numpy as np

CHECK = "passes_forward"
SAYS = "biases are forgotten"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = x @ weights
        if i < len(layers) - 1:
            x = np.maximum(x, 0)
    return x
