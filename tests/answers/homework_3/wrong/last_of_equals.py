"""The last of equal scores."""

CHECK = "stops_by_validation"
SAYS = "of equal scores"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] >= validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage, best
