"""A network trained by the learner's function from a memory, and words for what it says of the states."""

import contextlib
import sys

import numpy as np

from course_lib.checks.check import NotYet
from course_lib.checks.homework_3.arrays import array_from, numbers
from course_lib.checks.plain import described

_WANTED = "a row for each observation, a column for each action"


def trained(call, memory, *, steps, copy_every, seed):
    """float[S, A]: what the learner's learn(…) says of each state, trained from the memory on one thread."""
    with one_thread():
        values = array_from(call(*memory.transitions, steps, copy_every, seed).value, _WANTED)
    N, A = len(memory.states), memory.exact.shape[1]
    if values.shape != (N, A):
        raise NotYet(f"{_in_words(values)}; {(N, A)} is right", _likely_of_shape(values, N, A))
    if not np.isfinite(values).all():
        raise NotYet(
            "values that are infinite or NaN (no number)",
            "the values grow without end, or −inf, which stands for what is impossible, has come into your targets.",
        )
    by_state = memory.by_state(values)
    alike = np.isclose(values, by_state[memory.states], atol=1e-3).all(axis=1)
    if not alike.all():
        row = int(alike.argmin())
        first = int(np.flatnonzero(memory.states == memory.states[row])[0])
        raise NotYet(
            f"rows {first} and {row} belong to the same observation: {numbers(values[first])}, {numbers(values[row])}",
            "your function returns the rows in another order than that of `observations`. (Or does something in your "
            "network guess, such as dropout? `network.eval()` ends that.)",
        )
    return by_state


@contextlib.contextmanager
def one_thread():
    """Torch computes on one thread meanwhile: for networks as small as these, more only wait for one another."""
    torch = sys.modules.get("torch")  # it is the learner's code that needs it
    before = torch.get_num_threads() if torch else None
    try:
        if torch:
            torch.set_num_threads(1)
        yield
    finally:
        if torch:
            torch.set_num_threads(before)


def shown(memory, values, states, names):
    """Values of some states beside the exact ones, as text; a line each, two columns an action."""
    lines = ["state" + "".join(f"{name:>16}" for name in names), " " * 5 + f"{'came':>8}{'exact':>8}" * len(names)]
    for state in states:
        exact = ["–" if np.isnan(value) else f"{value:.2f}" for value in memory.exact[state]]
        pairs = zip(values[state], exact, strict=True)
        lines.append(f"{state:>5}" + "".join(f"{value:>8.2f}{right:>8}" for value, right in pairs))
    return "\n".join(lines)


def _in_words(values):
    return described(values) if values.ndim else f"one number, {values:.4g}"


def _likely_of_shape(values, N, A):
    if values.shape in ((N,), (N, 1)):
        return (
            "your function returns one value for each observation. Wanted are those of all actions, as they come out "
            "of the network: no max, no `gather`."
        )
    if values.ndim == 2 and values.shape[1] == A and len(values) != N:
        return "your function returns the values of a batch: at the end the network is asked about all `observations`."
    if values.shape == (A, N):
        return f"rows and columns are exchanged: what is wanted is {_WANTED}."
    return f"the shape is another one than asked for: what is wanted is {_WANTED}."
