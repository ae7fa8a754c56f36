"""As if the score were a loss."""

CHECK = "stops_by_validation"
SAYS = "looks for the lowest"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] < validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage, best
