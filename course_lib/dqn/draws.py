"""The agents' random numbers: a row a step, every agent from a generator of its own."""

import numpy as np

from course_lib.files import generator_in

_NUMBERS_AT_ONCE = 2**24  # of all agents together, 128 MiB: generators are slow to start, and there may be many


class Draws:
    """For each of E agents, rows of `width` numbers in [0, 1), as its generator would draw them one after the other.

    They are drawn many rows ahead, which changes no number and takes a tenth of the time.
    """

    def __init__(self, generators, width):
        self.generators, self.width = generators, width
        rows = max(1, min(256, _NUMBERS_AT_ONCE // (len(generators) * width)))
        self._ahead = np.empty((len(generators), rows, width))
        self._used = np.full(len(generators), rows)  # rows of `_ahead` that are spent
        self._before = [None] * len(generators)  # a generator's state before it filled `_ahead`
        self._lanes = np.arange(len(generators))

    def rows(self):
        """The current row of each agent, float64[E, width]; the same until `spend`."""
        for i in np.flatnonzero(self._used == self._ahead.shape[1]):
            self._before[i] = self.generators[i].bit_generator.state
            self.generators[i].random(out=self._ahead[i])
            self._used[i] = 0
        return self._ahead[self._lanes, self._used]

    def spend(self, agents):
        """Those agents, bool[E], have used their row."""
        self._used += agents

    def states(self):
        """For each agent the state of a generator whose next number is the first of its current row; plain JSON."""
        states = []
        for generator, before, used in zip(self.generators, self._before, self._used, strict=True):
            if used < self._ahead.shape[1]:
                generator = generator_in(before)
                generator.bit_generator.advance(int(used) * self.width)
            states.append(generator.bit_generator.state)
        return states
