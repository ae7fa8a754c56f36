"""ReLU before each layer."""

import numpy as np

CHECK = "passes_forward"
SAYS = "before the first layer"


def q_values(x, layers):
    for weights, biases in layers:
        x = np.maximum(x, 0) @ weights + biases
    return x
