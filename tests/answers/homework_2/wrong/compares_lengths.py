"""Asks for the whole and the half, and compares lengths."""

CHECK = "finds_the_leak"
SAYS = "of the 89 places at which the future can begin"


def looks_ahead(encode, close):
    half = len(close) // 2
    return len(encode(close)[:half]) != len(encode(close[:half]))
