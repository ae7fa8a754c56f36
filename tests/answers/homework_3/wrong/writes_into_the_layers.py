"""Adds to the biases that were given."""

import numpy as np

CHECK = "passes_forward"
SAYS = "writes into `layers`"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        rows = []
        for row in x:
            kept = biases.copy()
            biases += row @ weights
            rows.append(np.maximum(biases, 0) if i < len(layers) - 1 else biases.copy())
            if len(x) > 1:
                biases[:] = kept
        x = np.array(rows)
    return x
