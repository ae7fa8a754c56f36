"""What the learner's functions gave back, in any reasonable form; or `NotYet` in words that say which is wanted."""

import numpy as np

from course_lib.checks.check import NotYet
from course_lib.checks.plain import Strange, described

_NO_RETURN = "your function ends without `return`."


def states_of(value, length, warm_up):
    """int[length]: the states that were returned, as an array or a list of whole numbers.

    warm_up  number of bars without a state at the beginning
    """
    states = _row_of_numbers(value, length, warm_up, "state")
    if states.dtype.kind == "f":
        odd = states[~(np.isfinite(states) & (states == np.floor(states)))]
        if not odd.size:
            raise NotYet(
                "whole numbers, but of type float",
                "your states are floats, as they come from a division or from `np.zeros`. They are to number the rows "
                "of a table, and only an int can: `.astype(int)`.",
            )
        if np.isnan(odd).all():
            raise NotYet(
                f"NaN (no number) at t = {np.flatnonzero(np.isnan(states))[0]}",
                "NaN stands where there is no state yet: the task asks for −1 there, since a whole number cannot be "
                "NaN."
                if np.isnan(states[:warm_up]).any()
                else "a line of your code divides zero by zero, or takes the logarithm of a negative number.",
            )
        raise NotYet(f"{odd[0]:.4g} among the states", "a state is a whole number: it numbers a row of a table.")
    return states.astype(np.int64)


def positions_of(value, length):
    """float[length]: the positions that were returned, whole numbers or floats; each of them -1, 0 or 1."""
    if isinstance(value, tuple) and len(value) == 2 and length != 2:
        raise NotYet(
            f"two values: {described(value)}",
            "your function gives a position for each table. There is one trader: its position is 1 while it is long, "
            "−1 while it is short, else 0.",
        )
    positions = _row_of_numbers(value, length, 0, "position").astype(float)
    odd = positions[~np.isin(positions, (-1, 0, 1))]
    if odd.size:
        likely = "a position is −1 (short), 0 (out) or 1 (long)."
        if np.isin(np.abs(odd), (0.5,)).all():
            likely = (
                "your trader gives half of its money to each side. It is one trader: wholly long, wholly short, or out."
            )
        elif np.isin(odd, (2, 3)).all():
            likely = (
                "you return actions, or count trades: what is wanted is the position, −1 (short), 0 (out) or 1 (long)."
            )
        raise NotYet(f"{odd[0]:.4g} among the positions", likely)
    return positions


def number_of(value, what):
    """float: the number that was returned."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        likely = f"your function returns something else than a number, the {what}."
        raise NotYet(described(value), _NO_RETURN if value is None else likely)
    return float(value)


def _row_of_numbers(value, length, warm_up, what):
    """An int or float array of one dimension and that length."""
    if value is None:
        raise NotYet("None", _NO_RETURN)
    if isinstance(value, Strange):
        likely = "your function returns something else than an array of numbers."
        if value.type_name in ("Series", "DataFrame", "Index"):
            likely = "your function returns a pandas object: return the array in it, by `.to_numpy()`."
        raise NotYet(described(value), likely)
    if isinstance(value, tuple) and any(isinstance(item, tuple) or np.ndim(item) for item in value):
        likely = f"your function returns several arrays or lists: one is wanted, with a {what} for each bar."
        raise NotYet(described(value), likely)
    numbers = _as_numbers(value)
    if numbers is None:
        raise NotYet(described(value), f"your function returns something else than one {what} for each bar.")
    if numbers.ndim != 1:
        likely = f"the array has {numbers.ndim} dimensions: it is to have one, with a {what} for each bar."
        raise NotYet(f"an array of shape {numbers.shape}", likely)
    if len(numbers) != length:
        likely = f"one {what} is wanted for each bar."
        if len(numbers) == length - warm_up:
            likely = (
                "the bars without a state are cut off: `states[t]` is to belong to `close[t]`, and −1 stands where "
                "the window is not full."
            )
        elif len(numbers) == length - 1 and what == "state":
            likely = (
                f"there is one move less than there are closes: one {what} is wanted for each close, −1 for the first."
            )
        raise NotYet(f"{len(numbers)} values for {length} bars", likely)
    return numbers


def _as_numbers(value):
    """The numbers as an int or float array, or None."""
    try:
        numbers = np.array(value) if isinstance(value, (np.ndarray, tuple)) else None
    except ValueError:  # ragged
        return None
    return numbers if numbers is not None and numbers.dtype.kind in "iuf" and numbers.ndim else None
