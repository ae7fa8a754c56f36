"""Keeps the network as it was at the stop."""

CHECK = "stops_by_validation"
SAYS = "keep the best one up to then"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage, stage
