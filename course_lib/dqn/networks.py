"""E networks of one shape, trained side by side: one tensor holds all weights, one operation serves all networks."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch

BETA_1, BETA_2, TINY = 0.9, 0.999, 1e-8  # Adam's usual constants
_FASTER = 1e-36  # for zero under a square root, where TINY follows: roots of zero take twenty times as long


@dataclass(eq=False)
class Pass:
    """One forward pass: what went into every layer, and what came out at the end, float32[E, N, A].

    The first input is None where the networks were asked about every state at once.
    """

    inputs: list
    q: torch.Tensor


class Networks:
    """E fully connected networks with ReLU between the layers, none after the last; their gradients, by hand.

    sizes   numbers of nodes, inputs first
    flat    float32[E, P], a row a network: per layer its weights float32[inputs, outputs], then its biases

    Inputs x are float32[E, N, inputs], N rows for each network. One-hot encoded ones come shorter, and the first layer
    then needs no multiplication: int64[E, N] says where the ones stand, None means every row of the identity matrix.
    """

    def __init__(self, sizes, flat):
        self.sizes, self.flat = tuple(sizes), flat
        self.layers = layers_of(self.sizes, flat)
        self._gradient = torch.empty_like(flat)
        self._d_layers = layers_of(self.sizes, self._gradient)

    def forward(self, x):
        """The `Pass` of inputs x through all networks."""
        inputs = []
        for i, (weights, biases) in enumerate(self.layers):
            inputs.append(x)
            if x is None:
                x = weights + biases
            elif x.ndim == 2:
                x = weights.gather(1, _across(x, weights)) + biases
            else:
                x = torch.bmm(x, weights).add_(biases)
            if i < len(self.layers) - 1:
                x = x.relu_()
        return Pass(inputs, x)

    def backward(self, passed, dq):
        """The gradient, float32[E, P], of a loss whose derivative by the outputs of a `Pass` is dq, float32[E, N, A].

        It stands in the same tensor every time.

        Back-propagation (Rumelhart, Hinton & Williams, 1986): from the last layer to the first, a layer's weights get
        inputs^T dq, and what it was fed gets dq weights^T where the ReLU before it let something through.
        """
        for (d_weights, d_biases), (weights, _), x in reversed(
            list(zip(self._d_layers, self.layers, passed.inputs, strict=True))
        ):
            torch.sum(dq, dim=1, keepdim=True, out=d_biases)
            if x is None:
                d_weights.copy_(dq)
            elif x.ndim == 2:
                add_at(d_weights.zero_(), x, dq)
            else:
                d_weights.copy_(torch.bmm(x.transpose(1, 2), dq))
            if x is not passed.inputs[0]:
                dq = torch.bmm(dq, weights.transpose(1, 2))
                dq = torch.ops.aten.threshold_backward(dq, x, 0.0)
        return self._gradient


class Adam:
    """Adam (Kingma & Ba, 2015) for E networks at once, each of which may have made another number of updates.

    first, second   float32[E, P], the moving averages of the gradient and of its square
    updates         int64[E]
    """

    def __init__(self, flat):
        self.first, self.second = torch.zeros_like(flat), torch.zeros_like(flat)
        self.updates, self._room = np.zeros(len(flat), np.int64), torch.empty_like(flat)

    def step(self, flat, gradient, learning_rate, learning):
        """Move the weights of those networks for which `learning`, bool[E], is true; the others stay as they are.

        The corrections for averages that began at zero are drawn into the step and into the constant below the line,
        which is the same, written so that it needs fewer operations on large tensors.
        """
        self.updates += learning
        count = np.maximum(self.updates, 1)
        correction = np.sqrt(1 - BETA_2**count)
        step = learning_rate * correction / (1 - BETA_1**count)
        columns = [(1 - BETA_1) * learning, (1 - BETA_2) * learning, step * learning, TINY * correction]
        rate_1, rate_2, step, tiny = torch.from_numpy(np.array(columns, np.float32)[:, :, None]).to(flat.device)
        self.first.lerp_(gradient, rate_1)
        self.second.lerp_(gradient.square_(), rate_2)
        below = torch.clamp_min(self.second, _FASTER, out=self._room).sqrt_().add_(tiny)
        flat.sub_(torch.div(self.first, below, out=below).mul_(step))


def add_at(zeros, rows, values):
    """Add values, float32[E, N] or [E, N, W], to those `rows`, int64[E, N], of `zeros`, float32[E, M] or [E, M, W].

    A GPU adds to one place in whatever order its threads come, and the last bits would change from run to run. There
    every value is replaced by the sum of all that have its row, and then it does not matter who writes last.
    """
    places = rows if values.ndim == 2 else _across(rows, zeros)
    if zeros.device.type == "cpu":
        return zeros.scatter_add_(1, places, values)
    return zeros.scatter_(1, places, row_sums(rows, values))


def row_sums(rows, values):
    """Instead of each of the values, [E, N] or [E, N, W], the sum of all with the same of the rows, int64[E, N]."""
    same = (rows.unsqueeze(2) == rows.unsqueeze(1)).to(values.dtype)
    return torch.bmm(same, values.reshape(*rows.shape, -1)).view_as(values)


def _across(rows, weights):
    """Row numbers, int64[E, N], repeated for every column of `weights`, as torch's gather and scatter take them."""
    return rows.unsqueeze(2).expand(-1, -1, weights.shape[2])


def layers_of(sizes, flat):
    """[(weights float32[E, inputs, outputs], biases float32[E, 1, outputs]), …], views of flat, float32[E, P]."""
    layers, start = [], 0
    for inputs, outputs in pairwise(sizes):
        middle, end = start + inputs * outputs, start + (inputs + 1) * outputs
        weights = flat[:, start:middle].view(-1, inputs, outputs)
        layers.append((weights, flat[:, middle:end].view(-1, 1, outputs)))
        start = end
    return layers


def number_of_weights(sizes):
    """P: weights and biases of one network."""
    return sum((inputs + 1) * outputs for inputs, outputs in pairwise(sizes))


def starting_weights(sizes, rng):
    """float32[P], one network: weights uniform in ±sqrt(6 / (inputs + outputs)) (Glorot & Bengio, 2010), biases 0."""
    parts = []
    for inputs, outputs in pairwise(sizes):
        limit = np.sqrt(6 / (inputs + outputs))
        parts += [rng.uniform(-limit, limit, inputs * outputs), np.zeros(outputs)]
    return np.concatenate(parts).astype(np.float32)
