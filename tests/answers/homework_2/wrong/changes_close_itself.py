"""The copy is forgotten: the past changes with the future."""

CHECK = "finds_the_leak"
SAYS = "changes `close` itself, so that after the first change the past"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(len(close) - 1):
        other = close
        other[t + 1 :] *= 2
        if (encode(other)[: t + 1] != states[: t + 1]).any():
            return True
    return False
