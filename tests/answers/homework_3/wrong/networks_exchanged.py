"""The target network chooses, the online network says the value."""

import numpy as np

CHECK = "aims_at_possible_actions"
SAYS = "exchanged"


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    best = np.where(next_possible, next_target, -np.inf).argmax(axis=1)
    after = next_online[np.arange(len(best)), best]
    return rewards + np.where(terminated, 0, gamma * after)
