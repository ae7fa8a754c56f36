"""Compares the state of the first changed close too."""

CHECK = "finds_the_leak"
SAYS = "only the states up to it have to"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(1, len(close)):
        other = close.copy()
        other[t:] *= 2
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
    return False
