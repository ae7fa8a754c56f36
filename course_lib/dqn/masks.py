"""Action masks of E agents at once: where a `VectorEnv` keeps them, and what they leave to choose from."""

import numpy as np

from course_lib.choice import checked_mask, possible_actions


def masks_in(infos, before, lanes, terminated):
    """The masks, bool[E, A], that `infos` of a `VectorEnv` hold for those lanes, bool[E]; `before` in the others.

    Where a lane has `terminated`, bool[E], nothing follows, and all actions count as possible if it has no mask, or
    one that rules out all of them. `ValueError` for any other such mask, and for one of another shape.
    """
    masks = np.asarray(infos.get("action_mask", np.zeros_like(before)))
    if masks.shape != before.shape:
        checked_mask(masks, before.shape)
    told = lanes & infos.get("_action_mask", "action_mask" in infos)
    needed = lanes & ~terminated
    if (needed & ~told).any():
        possible_actions({name: None for name in infos if not name.endswith("action_mask")}, before.shape[1])
    looked_at = told & (needed | (masks != 0).any(axis=1))
    possible = before | lanes[:, None]
    possible[looked_at] = checked_mask(masks[looked_at], (looked_at.sum(), before.shape[1]))
    return possible


def nth_possible(possible, drawn):
    """A possible action for each agent, the int(drawn * count)-th of them; possible bool[E, A], drawn float64[E]."""
    nth = (drawn * possible.sum(axis=1)).astype(np.int64)
    return (possible.cumsum(axis=1) > nth[:, None]).argmax(axis=1)
