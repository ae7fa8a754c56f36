"""The copy is forgotten, and both states are asked for after the change."""

CHECK = "finds_the_leak"
SAYS = "changes `close` itself, so that the first states, too"


def looks_ahead(encode, close):
    for t in range(len(close) - 1):
        other = close
        other[t + 1 :] += 10
        if (encode(other)[: t + 1] != encode(close)[: t + 1]).any():
            return True
    return False
