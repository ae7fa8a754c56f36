"""The next five closes are changed, and the last five states compared."""

CHECK = "finds_the_leak"
SAYS = "Compare all states up to the change"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(1, len(close)):
        other = close.copy()
        other[t : t + 5] *= 2
        if (encode(other)[max(0, t - 5) : t] != states[max(0, t - 5) : t]).any():
            return True
    return False
