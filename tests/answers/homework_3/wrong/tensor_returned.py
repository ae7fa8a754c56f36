"""Returns what torch has computed, as it is."""

import torch

CHECK = "passes_forward"
SAYS = "torch tensor"


def q_values(x, layers):
    x = torch.tensor(x)
    for i, (weights, biases) in enumerate(layers):
        x = x @ torch.tensor(weights) + torch.tensor(biases)
        if i < len(layers) - 1:
            x = torch.relu(x)
    return x
