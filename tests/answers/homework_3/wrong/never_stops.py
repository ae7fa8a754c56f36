"""Looks at all scores, then takes the best."""

CHECK = "stops_by_validation"
SAYS = "never stops before the last"


def best_moment(validation, patience):
    best = 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
    return stage, best
