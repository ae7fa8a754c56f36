"""Takes three layers apart."""

import numpy as np

CHECK = "passes_forward"
SAYS = "expects a certain number of layers"


def q_values(x, layers):
    (W1, b1), (W2, b2), (W3, b3) = layers
    x = np.maximum(x @ W1 + b1, 0)
    x = np.maximum(x @ W2 + b2, 0)
    return x @ W3 + b3
