"""Multiplies float64 by float32."""

import numpy as np
import torch

CHECK = "passes_forward"
SAYS = "numbers of two kinds"


def q_values(x, layers):
    for i, (weights, biases) in enumerate(layers):
        x = torch.tensor(x) @ torch.tensor(weights).float() + torch.tensor(biases)
        if i < len(layers) - 1:
            x = np.maximum(x, 0)
    return x
