"""The two numbers in the other order."""

CHECK = "stops_by_validation"
SAYS = "two numbers are exchanged"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return best, stage
