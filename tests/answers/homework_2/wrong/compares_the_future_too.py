"""States after the change are compared too."""

CHECK = "finds_the_leak"
SAYS = "only the states up to it have to"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] *= 2
        if (encode(other) != states).any():
            return True
    return False
