"""ReLU after every layer."""

import numpy as np

CHECK = "passes_forward"
SAYS = "ReLU stands after the last layer"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = x @ weights + biases
        x = np.maximum(x, 0)
    return x
