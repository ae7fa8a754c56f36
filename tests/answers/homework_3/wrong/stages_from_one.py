"""Counts stages from 1."""

CHECK = "stops_by_validation"
SAYS = "count from 1"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage + 1, best + 1
