"""Looks for the best of all scores first, and adds patience to its stage."""

import numpy as np

CHECK = "stops_by_validation"
SAYS = "is not known yet when the training stops"


def best_moment(validation, patience):
    best = np.argmax(validation)
    return min(best + patience, len(validation) - 1), best
