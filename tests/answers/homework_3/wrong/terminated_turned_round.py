"""Bootstraps only after the end."""

import numpy as np

CHECK = "aims_at_possible_actions"
SAYS = "the wrong way round: the target is r"


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    best = np.where(next_possible, next_online, -np.inf).argmax(axis=1)
    after = next_target[np.arange(len(best)), best]
    return rewards + np.where(terminated, gamma * after, 0)
