"""How an agent chooses: the one place where ties are broken and actions explored. The compiled loops draw alike."""

import numpy as np


def random_argmax(values, rng):
    """The index of the largest of `values`; among equals one at random, all alike likely. Draws only for a tie."""
    best = np.flatnonzero(values == values.max())
    return int(best[int(rng.random() * len(best))]) if len(best) > 1 else int(best[0])


def epsilon_greedy(values, epsilon, rng):
    """A random index with probability `epsilon`, else a best one (Sutton & Barto, 2nd ed., section 2.2)."""
    if rng.random() < epsilon:
        return int(rng.random() * len(values))
    return random_argmax(values, rng)
