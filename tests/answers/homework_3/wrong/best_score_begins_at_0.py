"""The best score is 0 before the first stage."""

CHECK = "stops_by_validation"
SAYS = "begins at 0"


def best_moment(validation, patience):
    best_score, best = 0, 0
    for stage, score in enumerate(validation):
        if score > best_score:
            best_score, best = score, stage
        if stage - best >= patience:
            break
    return stage, best
