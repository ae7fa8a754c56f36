"""Returns from inside the loop only."""

CHECK = "stops_by_validation"
SAYS = "ends without `return`"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        if stage - best >= patience:
            return stage, best
