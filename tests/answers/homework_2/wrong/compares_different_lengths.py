"""Compares the states of a shorter series with those of the whole."""

CHECK = "finds_the_leak"
SAYS = "two arrays of different length"


def looks_ahead(encode, close):
    for t in range(30, len(close)):
        if (encode(close[:t]) != encode(close)).any():
            return True
    return False
