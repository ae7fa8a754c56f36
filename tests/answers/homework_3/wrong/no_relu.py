"""No ReLU at all."""

import numpy as np

CHECK = "passes_forward"
SAYS = "no ReLU between"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = x @ weights + biases
    return x
