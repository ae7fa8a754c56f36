"""Asks an array as if it were one Boolean."""

import numpy as np

CHECK = "aims_at_possible_actions"
SAYS = "asked of a whole array"


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    best = np.where(next_possible, next_online, -np.inf).argmax(axis=1)
    after = next_target[np.arange(len(best)), best]
    if terminated:
        return rewards
    return rewards + gamma * after
