"""Takes three layers of as many as there are."""

import numpy as np

CHECK = "passes_forward"
SAYS = "three layers, however many"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers[:3]):
        x = x @ weights + biases
        if i < min(len(layers), 3) - 1:
            x = np.maximum(x, 0)
    return x
