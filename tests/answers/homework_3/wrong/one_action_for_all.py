"""One best action for the whole batch."""

import numpy as np

CHECK = "aims_at_possible_actions"
SAYS = "once for the whole batch"


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    best = np.where(next_possible, next_online, -np.inf).max(axis=0).argmax()
    return rewards + np.where(terminated, 0, gamma * next_target[:, best])
