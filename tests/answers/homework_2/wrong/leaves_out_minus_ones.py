"""Compares states without their warm-up, so that they do not lie side by side."""

CHECK = "finds_the_leak"
SAYS = "only the states up to it have to"


def looks_ahead(encode, close):
    states = [state for state in encode(close) if state != -1]
    for t in range(1, len(close)):
        other = close.copy()
        other[t:] *= 2
        if [state for state in encode(other) if state != -1][:t] != states[:t]:
            return True
    return False
