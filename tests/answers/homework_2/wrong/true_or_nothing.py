"""No return where there is no leak."""

CHECK = "finds_the_leak"
SAYS = "ends without `return`, at least for this encoder"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] *= 2
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
