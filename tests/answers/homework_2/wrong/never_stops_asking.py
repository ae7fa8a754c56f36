"""Asks without end."""

CHECK = "finds_the_leak"
SAYS = "more than 10000 times"


def looks_ahead(encode, close):
    while True:
        try:
            if encode(close).no_such_thing:
                return True
        except Exception:
            pass
