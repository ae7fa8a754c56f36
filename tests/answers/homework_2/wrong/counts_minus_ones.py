"""A leak is when the bars without a state change in number."""

CHECK = "finds_the_leak"
SAYS = "your function had it before its eyes"


def looks_ahead(encode, close):
    missing = (encode(close) == -1).sum()
    for t in range(len(close) - 1):
        other = close.copy()
        other[t + 1 :] *= 2
        if (encode(other) == -1).sum() != missing:
            return True
    return False
