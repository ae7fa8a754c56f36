"""Task 2, the forward pass of a network with any number of layers."""

from itertools import pairwise

import numpy as np

from course_lib.checks.check import Check, Trial
from course_lib.checks.homework_3.arrays import MISTAKES_WITH_ARRAYS, Case, check_arrays

_WANTED = "a row for each row of `x`, a column for each node of the last layer"


def q_values(x, layers):
    """float[B, A]: x through all layers, with ReLU after every one but the last."""
    for weights, biases in layers[:-1]:
        x = np.maximum(x @ weights + biases, 0)
    weights, biases = layers[-1]
    return x @ weights + biases


def network(rng, sizes):
    """A tuple of (weights float[n, m], biases float[m]), a pair for each layer between these numbers of nodes."""
    return tuple((rng.normal(scale=1.5 / np.sqrt(n), size=(n, m)), rng.normal(size=m)) for n, m in pairwise(sizes))


def _relu(x):
    return np.maximum(x, 0)


def _as_it_is(x):
    return x


def _pass(*, before=_as_it_is, inside=_relu, last=_as_it_is, bias=1.0, transposed=False, most=None):
    """A forward pass with other functions before the first layer, between layers and after the last; and the like."""

    def passed(x, layers):
        x, layers = before(x), layers[:most]
        for i, (weights, biases) in enumerate(layers):
            x = x @ (weights.T if transposed else weights) + bias * biases
            x = last(x) if i == len(layers) - 1 else inside(x)
        return x

    return passed


def _sigmoid(x):
    return 1 / (1 + np.exp(-x))


def _softmax(x):
    exponentials = np.exp(x - x.max(axis=1, keepdims=True))
    return exponentials / exponentials.sum(axis=1, keepdims=True)


def _without_the_last(x, layers):
    return _pass(last=_relu)(x, layers[:-1])


_ANOTHER_FUNCTION = "between the layers stands another function than ReLU, which is max(0, x)."
_MISTAKES = [
    (
        _pass(last=_relu),
        "ReLU stands after the last layer too. Values of actions may be negative: nothing comes after the last layer.",
    ),
    (
        _pass(inside=_as_it_is),
        "there is no ReLU between the layers, which makes them one single layer: `np.maximum(x, 0)`.",
    ),
    (_pass(bias=0.0), "the biases are forgotten: `x @ weights + biases`."),
    (_pass(bias=-1.0), "the biases are subtracted: `x @ weights + biases`."),
    (
        _pass(transposed=True),
        "the weights are transposed: their rows are the inputs of a layer, `x @ weights + biases`.",
    ),
    (_pass(last=_softmax), "there is a softmax at the end. It makes probabilities; wanted are values, as they are."),
    (_pass(last=np.tanh), "there is a tanh at the end: nothing comes after the last layer."),
    (_pass(last=_sigmoid), "there is a sigmoid at the end: nothing comes after the last layer."),
    (_pass(inside=np.abs), "negative numbers become positive between the layers. ReLU makes 0 of them."),
    (_pass(inside=np.tanh), _ANOTHER_FUNCTION),
    (_pass(inside=_sigmoid), _ANOTHER_FUNCTION),
    (_pass(before=_relu), "ReLU stands before the first layer too: inputs may be negative."),
    (_without_the_last, "the last layer is left out."),
    (_pass(most=3), "your function takes three layers, however many there are."),
    (_pass(most=2), "your function takes two layers, however many there are."),
]


def _check_networks(call, seed, all_sizes, rows, names=()):
    rng = np.random.default_rng(seed)
    cases = []
    for sizes in all_sizes:
        nodes = " → ".join(map(str, sizes))
        cases.append(Case((rng.normal(size=(rows, sizes[0])), network(rng, sizes)), f"{nodes} nodes, {rows} rows"))
    check_arrays(call, cases, q_values, _MISTAKES, _WANTED, names=names)


def _passes_square_layers(call, seed):
    _check_networks(call, seed, [(3, 3, 3, 3), (4, 4, 4, 4)], rows=6)


def _passes_the_networks_of_this_homework(call, seed):
    _check_networks(call, seed + 10, [(9, 32, 32, 3), (9, 32, 32, 3)], rows=64)


def _passes_any_number_of_layers(call, seed):
    _check_networks(call, seed + 20, [(5, 3), (6, 8, 2), (4, 6, 6, 6, 6, 3)], rows=7)


def _passes_one_row(call, seed):
    _check_networks(call, seed + 30, [(9, 8, 8, 3), (4, 4, 3)], rows=1, names=("x", "layers"))


passes_forward = Check(
    "passes_forward",
    title="Task 2, the forward pass",
    usage="q_values(x, layers)",
    trials=[
        Trial(
            "small networks with as many nodes in each layer",
            "`x @ weights + biases` in each layer, ReLU between them",
            _passes_square_layers,
        ),
        Trial(
            "networks of 9, 32, 32 and 3 nodes",
            "for 64 rows of inputs 64 rows of three values",
            _passes_the_networks_of_this_homework,
        ),
        Trial("networks of one, two and five layers", "any number of layers", _passes_any_number_of_layers),
        Trial("a single row of inputs", "a single row of values; `x` and `layers` as they were", _passes_one_row),
    ],
    likely={
        "values to unpack|(tuple|list) index out of range": "your function expects a certain number of layers, or "
        "takes a layer for something else: each is a pair, `for weights, biases in layers`.",
        "not have enough dimensions": "numbers are lost between the layers. `np.max(x, 0)` takes the largest of each "
        "column; ReLU is `np.maximum(x, 0)`, which compares each number with 0.",
        **MISTAKES_WITH_ARRAYS,
        "matmul: Input operand|mat1 and mat2|not aligned|not be broadcast|must match the size": "shapes do not fit: "
        "the rows of `weights` are the inputs of its layer, `x @ weights + biases`. (A `Linear` layer of torch keeps "
        "them the other way round.)",
    },
    hints=[
        "One layer is `x @ weights + biases`: B rows with n numbers become B rows with m numbers.",
        "What comes out of one layer goes into the next: a loop, `for weights, biases in layers`, that puts its result "
        "into `x` again.",
        "ReLU is `np.maximum(x, 0)`. It stands between two layers, so not after the last one: "
        "`for i, (weights, biases) in enumerate(layers)` tells you which one is the last.",
    ],
)
