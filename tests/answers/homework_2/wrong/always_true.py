"""Finds a leak everywhere."""

CHECK = "finds_the_leak"
SAYS = "never calls `encode`"


def looks_ahead(encode, close):
    return True
