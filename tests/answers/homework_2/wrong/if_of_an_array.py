"""An array of comparisons as a condition."""

CHECK = "finds_the_leak"
SAYS = "a comparison of arrays gives an array"


def looks_ahead(encode, close):
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] *= 2
        if encode(other)[: t + 1] != encode(close)[: t + 1]:
            return True
    return False
