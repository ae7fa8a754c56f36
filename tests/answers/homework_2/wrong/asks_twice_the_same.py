"""Asks twice about the same closes."""

CHECK = "finds_the_leak"
SAYS = "never asks about another future"


def looks_ahead(encode, close):
    return bool((encode(close) != encode(close.copy())).any())
