"""Cuts the closes everywhere, but compares lengths."""

CHECK = "finds_the_leak"
SAYS = "your function had it before its eyes"


def looks_ahead(encode, close):
    states = encode(close)
    return any(len(states[:t]) != len(encode(close[:t])) for t in range(1, len(close)))
