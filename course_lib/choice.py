"""How an agent chooses: the one place where ties are broken and actions explored. The compiled loops draw alike."""

import numpy as np


def random_argmax(values, rng, possible=None):
    """The index of the largest of `values`; among equals one at random, all alike likely. Draws only for a tie.

    possible, bool[A], leaves out what it has False for.
    """
    if possible is not None:
        which = np.flatnonzero(possible)
        return int(which[random_argmax(values[which], rng)])
    best = np.flatnonzero(values == values.max())
    return int(best[int(rng.random() * len(best))]) if len(best) > 1 else int(best[0])


def epsilon_greedy(values, epsilon, rng, possible=None):
    """A random index with probability `epsilon`, else a best one (Sutton & Barto, 2nd ed., section 2.2).

    possible, bool[A], leaves out what it has False for.
    """
    if possible is not None:
        which = np.flatnonzero(possible)
        return int(which[epsilon_greedy(values[which], epsilon, rng)])
    if rng.random() < epsilon:
        return int(rng.random() * len(values))
    return random_argmax(values, rng)


def possible_actions(info, num_actions, *, terminated=False):
    """What an environment's `info["action_mask"]` says, Gymnasium's way (1: possible, 0: not), as bool[A].

    `ValueError` if there is no mask, one of another shape, or one without any possible action. After a terminated
    step nothing follows, so that such a state may do without possible actions, or a mask: all are then True.
    """
    mask = info.get("action_mask")
    if mask is not None:
        possible = checked_mask(mask, (num_actions,), may_be_empty=terminated)
        return possible if possible.any() else ~possible
    if terminated:
        return np.ones(num_actions, bool)
    raise ValueError(
        'mask_actions needs an environment that gives info["action_mask"] at reset and at every step, got'
        f" {sorted(map(str, info)) or 'nothing'} in info"
    )


def checked_mask(mask, shape, name='info["action_mask"]', *, may_be_empty=False):
    """An action mask as bool[shape]; `ValueError` for other shapes, more than 0 and 1, and where nothing is left."""
    try:
        array = np.asarray(mask)
    except ValueError:  # rows of unequal lengths
        array = np.empty(0)
    possible = np.asarray(array == 1)
    if array.shape != tuple(shape) or not (possible | (array == 0)).all():
        raise ValueError(f"{name} must be {[*shape]} of 1 (possible) and 0 (not possible), got {mask!r}")
    if not (may_be_empty or possible.any(axis=-1).all()):
        raise ValueError(f"{name} must leave an action possible, got {mask!r}")
    return possible
