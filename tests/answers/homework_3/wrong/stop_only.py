"""Returns the other number."""

CHECK = "stops_by_validation"
SAYS = "the best stage is missing"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage
