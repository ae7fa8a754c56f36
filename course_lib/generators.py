"""One generator in place of many, for compiled loops, which can be handed one but not a thousand."""

import ctypes

import numpy as np


class OneForMany:
    """A PCG64 generator that E agents draw from in turn, each from a state of its own.

    parts   the generator; the memory in which it keeps its state, uint64[4]; the agents' states, uint64[E, 4]

    The loop copies an agent's state to that memory before its turn, and back after it. numpy tells the place:
    `ctypes.state_address` points to it, and number and increment lie there, 4 times 64 bits. `RuntimeError` from a
    numpy that keeps them elsewhere. Half a draw that is kept for a next one of 32 bits is not carried along; `random()`
    keeps none.
    """

    def __init__(self, number):
        rng = np.random.Generator(np.random.PCG64(0))
        place = ctypes.c_void_p.from_address(rng.bit_generator.ctypes.state_address).value
        state = np.frombuffer((ctypes.c_uint64 * 4).from_address(place), np.uint64)
        told = rng.bit_generator.state["state"]
        halves = [half for whole in (told["state"], told["inc"]) for half in divmod(whole, 2**64)]
        if sorted(map(int, state)) != sorted(halves):
            raise RuntimeError(f"numpy {np.__version__} keeps the state of PCG64 elsewhere")
        self.parts = (rng, state, np.zeros((number, 4), np.uint64))

    def keep(self, i, rng):
        """Agent i goes on from where `rng`, a PCG64 generator, stands; `ValueError` for another kind."""
        own, state, states = self.parts
        own.bit_generator.state = rng.bit_generator.state
        states[i] = state
