"""The best of all scores, also of those after the stop."""

CHECK = "stops_by_validation"
SAYS = "comes from all scores"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage, int(validation.argmax())
