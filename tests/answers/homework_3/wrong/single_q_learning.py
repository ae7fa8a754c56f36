"""The max of the target network."""

import numpy as np

CHECK = "aims_at_possible_actions"
SAYS = "not a double one"


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    after = np.where(next_possible, next_target, -np.inf).max(axis=1)
    return rewards + np.where(terminated, 0, gamma * after)
