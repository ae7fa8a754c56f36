"""Looks for the best of all scores first, adds patience, and does not mind where the scores end."""

import numpy as np

CHECK = "stops_by_validation"
SAYS = "is not known yet when the training stops"


def best_moment(validation, patience):
    best = int(np.argmax(validation))
    return best + patience, best
