"""As torch keeps its weights."""

import numpy as np

CHECK = "passes_forward"
SAYS = "transposed"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = x @ weights.T + biases
        if i < len(layers) - 1:
            x = np.maximum(x, 0)
    return x
