"""Adds next to nothing."""

CHECK = "finds_the_leak"
SAYS = "your change is too small"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] += 1e-9
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
    return False
