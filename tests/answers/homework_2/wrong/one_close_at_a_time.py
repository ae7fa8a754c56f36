"""One close is changed, and those after it stay."""

CHECK = "finds_the_leak"
SAYS = "your function changes one close at a time"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1] *= 1.5
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
    return False
