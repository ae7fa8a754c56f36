"""The count of worse stages is never set back."""

CHECK = "stops_by_validation"
SAYS = "goes on after a new best"


def best_moment(validation, patience):
    worse = best = 0
    for stage in range(1, len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        else:
            worse += 1
        if worse == patience:
            return stage, best
    return len(validation) - 1, best
