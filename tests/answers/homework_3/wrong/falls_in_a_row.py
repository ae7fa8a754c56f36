"""Stops after `patience` falls in a row."""

CHECK = "stops_by_validation"
SAYS = "counts falls in a row"


def best_moment(validation, patience):
    falls = best = 0
    for stage in range(len(validation)):
        if stage > 0 and validation[stage] < validation[stage - 1]:
            falls += 1
        else:
            falls = 0
        if validation[stage] > validation[best]:
            best = stage
        if falls == patience:
            break
    return stage, best
