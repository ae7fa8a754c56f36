"""Changes the last close, and compares the state before it."""

CHECK = "finds_the_leak"
SAYS = "your function changes the last close only"


def looks_ahead(encode, close):
    other = close.copy()
    other[-1] *= 2
    return bool(encode(other)[-2] != encode(close)[-2])
