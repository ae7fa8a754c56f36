"""The absolute value in the place of ReLU."""

import numpy as np

CHECK = "passes_forward"
SAYS = "negative numbers become positive"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = x @ weights + biases
        if i < len(layers) - 1:
            x = np.abs(x)
    return x
