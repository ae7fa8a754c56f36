"""Probabilities instead of values."""

import numpy as np

CHECK = "passes_forward"
SAYS = "softmax"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = x @ weights + biases
        if i < len(layers) - 1:
            x = np.maximum(x, 0)
    return np.exp(x) / np.exp(x).sum(axis=1, keepdims=True)
