"""np.max in the place of np.maximum: the largest of each column."""

import numpy as np

CHECK = "passes_forward"
SAYS = "takes the largest of each column"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = x @ weights + biases
        if i < len(layers) - 1:
            x = np.max(x, 0)
    return x
