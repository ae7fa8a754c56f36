"""The online network says what its own choice is worth."""

import numpy as np

CHECK = "aims_at_possible_actions"
SAYS = "that of the online network"


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    best = np.where(next_possible, next_online, -np.inf).argmax(axis=1)
    after = next_online[np.arange(len(best)), best]
    return rewards + np.where(terminated, 0, gamma * after)
