"""How the loops are compiled: at their first call, by numba."""

from numba import njit


def compiled(function):
    """Compile at the first call, without the interpreter's lock; keep the result on disk where it can be written."""
    try:
        return njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # neither the package's folder nor the user's can be written to
        return njit(nogil=True, error_model="numpy")(function)


def inlined(function):
    """For a step of a compiled loop: pasted into it, which keeps the whole loop in one piece for the optimiser."""
    return njit(inline="always", error_model="numpy")(function)
