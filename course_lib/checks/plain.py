"""Plain values: all that may pass from the learner's code to the judge, so that no object of theirs is ever asked.

Whatever a value says of itself (its `__class__`, `==`, `repr`, `__array__`) is the learner's code, and so is what its
type says. So types are compared by `is` and `issubclass` alone, and contents read by methods of the plain type beneath.
"""

import json
from dataclasses import dataclass

import numpy as np

_LONGEST_TEXT, _LARGEST_INT, _DEEPEST = 100_000, 2**1000, 6
_MOST_ITEMS = 4_000_000  # entries of arrays and of lists, in one value
_KINDS = {"b": np.bool_, "i": np.int64, "u": np.int64, "f": np.float64}
_SCALARS = [np.dtype(code).type for code in "?" + np.typecodes["AllInteger"] + np.typecodes["Float"]]


@dataclass(frozen=True)
class Strange:
    """Stands for a value that is not plain; all that is kept of it is the name of its type."""

    type_name: str


def plain(value):
    """`value` as None, bool, int, float, str, tuple or a new int64, float64 or bool array; else a `Strange`.

    A subclass (an int whose == always says yes, an array that counts its readers) becomes the plain thing it holds.
    """
    return _plain(value, _DEEPEST, _Room(_MOST_ITEMS))


def type_name(value):
    """The name of a value's type, at most 60 characters; no metaclass is asked for it."""
    return type.__dict__["__name__"].__get__(type(value))[:60]


class _Room:
    """How many items there is still room for: lists that hold one another can be far larger than they look."""

    def __init__(self, left):
        self.left = left

    def has(self, size):
        if size > self.left:
            return False
        self.left -= size
        return True


def _plain(value, depth, room):
    kind = type(value)
    if value is None or kind is bool or kind is float:
        return value
    if issubclass(kind, str):
        # A lone surrogate can be in a str but in no file.
        return str.__getitem__(value, slice(_LONGEST_TEXT)).encode("utf-8", "replace").decode()
    if issubclass(kind, int):
        number = int.__index__(value)
        return number if -_LARGEST_INT < number < _LARGEST_INT else Strange(type_name(value))
    if issubclass(kind, float):
        return float.__add__(value, 0.0)
    if any(kind is scalar for scalar in _SCALARS):  # numpy can crash on subclasses of these
        return value.astype(_KINDS[value.dtype.kind]).item()
    if issubclass(kind, np.ndarray):
        dtype, size = np.ndarray.dtype.__get__(value), np.ndarray.size.__get__(value)
        if dtype.kind in _KINDS and room.has(size):
            return np.array(value, _KINDS[dtype.kind], subok=False)
    for sequence in (tuple, list):
        if issubclass(kind, sequence) and depth > 0 and room.has(sequence.__len__(value)):
            return tuple(_plain(item, depth - 1, room) for item in sequence.__iter__(value))
    return Strange(type_name(value))


def described(value):
    """A plain value in a few words, for a table."""
    if isinstance(value, Strange):
        return f"a value of type {value.type_name}"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if isinstance(value, tuple):
        if len(value) <= 4 and any(isinstance(item, (tuple, np.ndarray, Strange)) for item in value):
            return "(" + ", ".join(described(item) for item in value) + ("," if len(value) == 1 else "") + ")"
        if len(value) > 4:
            return f"{len(value)} values, {', '.join(described(item) for item in value[:2])} and so on"
    text = repr(value[:60] if isinstance(value, str) else value)
    return text if len(text) <= 60 else text[:59] + "…"


def counted(number, noun):
    """'1 episode', '2 episodes'."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def to_json(value):
    """A plain value as one line of JSON."""
    return json.dumps(_packed(value))


def from_json(line):
    """The plain value in one line of JSON. `ValueError` for anything else, since it may come from anywhere."""
    try:
        return _unpacked(json.loads(line))
    except (AttributeError, KeyError, MemoryError, OverflowError, RecursionError, TypeError) as error:
        raise ValueError(f"not a plain value: {error!r}") from None


def _packed(value):
    if isinstance(value, np.ndarray):
        return {"array": value.ravel().tolist(), "shape": value.shape, "kind": value.dtype.kind}
    if isinstance(value, Strange):
        return {"strange": value.type_name}
    if isinstance(value, dict):
        return {"dict": {key: _packed(item) for key, item in value.items()}}
    return [_packed(item) for item in value] if isinstance(value, (tuple, list)) else value


def _unpacked(value):
    if isinstance(value, list):
        return tuple(_unpacked(item) for item in value)
    if not isinstance(value, dict):
        return value
    if "array" in value:
        shape = tuple(value["shape"])
        if not all(type(length) is int and length >= 0 for length in shape):
            raise ValueError(f"not the shape of an array: {shape!r}")
        return np.array(value["array"], _KINDS[value["kind"]]).reshape(shape).copy()  # one that owns its numbers
    if "strange" in value:
        return Strange(str(value["strange"])[:60])
    return {str(key): _unpacked(item) for key, item in value["dict"].items()}
