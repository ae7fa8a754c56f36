"""The last reward is lost."""

import numpy as np

CHECK = "aims_at_possible_actions"
SAYS = "the last reward still counts"


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    best = np.where(next_possible, next_online, -np.inf).argmax(axis=1)
    after = next_target[np.arange(len(best)), best]
    return np.where(terminated, 0, rewards + gamma * after)
