"""One stage sooner."""

CHECK = "stops_by_validation"
SAYS = "one stage too early"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        if stage - best >= patience - 1:
            break
    return stage, best
