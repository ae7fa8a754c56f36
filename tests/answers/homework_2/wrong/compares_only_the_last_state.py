"""Compares only the last state before the change."""

CHECK = "finds_the_leak"
SAYS = "your function had it before its eyes"


def looks_ahead(encode, close):
    states = encode(close)
    for t in range(0, len(close) - 1):
        other = close.copy()
        other[t + 1 :] *= 2
        if encode(other)[0] != states[0]:
            return True
    return False
