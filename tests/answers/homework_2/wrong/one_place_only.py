"""Cuts in the middle only."""

CHECK = "finds_the_leak"
SAYS = "of the 89 places at which the future can begin"


def looks_ahead(encode, close):
    half = len(close) // 2
    other = close.copy()
    other[half:] *= 3
    return bool((encode(other)[:half] != encode(close)[:half]).any())
