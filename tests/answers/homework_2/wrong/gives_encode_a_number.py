"""Gives the encoder one close."""

CHECK = "finds_the_leak"
SAYS = "`encode` is given something else than closes"


def looks_ahead(encode, close):
    return any(encode(price) != encode(close)[t] for t, price in enumerate(close))
