"""Returns how many states differ."""

CHECK = "finds_the_leak"
SAYS = "your function returns a number"


def looks_ahead(encode, close):
    differ = 0
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] *= 2
        differ += (encode(other)[: t + 1] != encode(close)[: t + 1]).sum()
    return differ
