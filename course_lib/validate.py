"""What every public function asks of its arguments: one clear `ValueError`, before anything is changed."""

import math
import operator


def number(name, value):
    """`value` as a finite float; `ValueError` when it is anything else (NaN, infinity, text, None)."""
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be a number, got {value!r}") from None
    if not math.isfinite(result):
        raise ValueError(f"{name} must be a finite number, got {value!r}")
    return result


def fraction(name, value, *, above_zero=False):
    """`value` as a float in [0, 1], or in (0, 1] where `above_zero`."""
    result = number(name, value)
    if not 0 <= result <= 1 or (above_zero and result == 0):
        interval = "(0, 1]" if above_zero else "[0, 1]"
        raise ValueError(f"{name} must be in {interval}, got {value!r}")
    return result


def whole_number(name, value, *, at_least=0, below=None):
    """`value` as an int, `at_least <= value < below`; a float such as 3.0 is not taken for one."""
    try:
        result = operator.index(value)
    except TypeError:
        raise ValueError(f"{name} must be a whole number, got {value!r}") from None
    if result < at_least or (below is not None and result >= below):
        wanted = f"at least {at_least}" if below is None else f"from {at_least} to {below - 1}"
        raise ValueError(f"{name} must be {wanted}, got {value!r}")
    return result
