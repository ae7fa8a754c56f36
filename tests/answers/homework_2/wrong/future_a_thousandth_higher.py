"""The future is higher by a thousandth."""

CHECK = "finds_the_leak"
SAYS = "only if the future changes a lot"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] *= 1.001
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
    return False
