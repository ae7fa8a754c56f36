"""Plain values: what crosses from the learner's code to the judge, and that nothing else does."""

import contextlib
import json
from enum import IntEnum

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from course_lib import Action
from course_lib.checks.plain import Strange, described, from_json, plain, to_json, type_name


class Hostile:
    """Raises at whatever it is asked."""

    def _raise(self, *_, **__):
        raise AssertionError("an object of the learner's was asked something")

    __eq__ = __hash__ = __repr__ = __str__ = __bool__ = __len__ = __iter__ = __getattr__ = __array__ = _raise
    __int__ = __index__ = __float__ = __getitem__ = __lt__ = __gt__ = __add__ = __radd__ = __format__ = _raise


class HostileInt(Hostile, int):
    __hash__ = None


class HostileFloat(Hostile, float):
    __hash__ = None


class HostileStr(Hostile, str):
    __hash__ = None


class HostileList(Hostile, list):
    __hash__ = None


class HostileTuple(Hostile, tuple):
    __hash__ = None


class HostileArray(Hostile, np.ndarray):
    __hash__ = None

    def __array_finalize__(self, obj):
        pass


class HostileFloat64(Hostile, np.float64):
    __hash__ = None


class HostileInt64(Hostile, np.int64):
    __hash__ = None


class LyingMeta(type):
    def __instancecheck__(cls, instance):
        return True

    def _raise(cls, *_):
        raise AssertionError("a metaclass was asked")

    __name__ = property(_raise)
    __eq__ = __hash__ = __subclasscheck__ = _raise


class Liar(metaclass=LyingMeta):
    @property
    def __class__(self):
        return int


def same(value, other):
    """Equal in value and in type, all the way down."""
    if isinstance(value, np.ndarray) or isinstance(other, np.ndarray):
        return type(value) is type(other) and value.dtype == other.dtype and np.array_equal(value, other, True)
    if isinstance(value, tuple):
        return type(other) is tuple and len(value) == len(other) and all(map(same, value, other))
    return type(value) is type(other) and (value == other or (value != value and other != other))


@pytest.mark.parametrize("value", [None, True, False, 0, -3, 2.5, float("inf"), "", "naïve ☃"])
def test_what_is_plain_stays_as_it_is(value):
    assert same(plain(value), value)


def test_what_holds_a_plain_value_becomes_it():
    held = [
        (HostileInt(7), 7),
        (HostileFloat(0.5), 0.5),
        (HostileStr("a" * 10), "a" * 10),
        (HostileList([1, HostileInt(2)]), (1, 2)),
        (HostileTuple((1, 2)), (1, 2)),
        (HostileFloat64(0.25), 0.25),
        (np.int8(-5), -5),
        (np.uint64(9), 9),
        (np.float32(0.5), 0.5),
        (np.longdouble(0.5), 0.5),
        (np.bool_(True), True),
        (np.str_("text"), "text"),
        (Action.LEFT, 2),
        (IntEnum("Colour", "RED")(1), 1),
        ([], ()),
        ([[1], (2.0, None)], ((1,), (2.0, None))),
    ]
    for value, expected in held:
        assert same(plain(value), expected), type_name(value)


def test_all_else_leaves_the_name_of_its_type():
    strange = [
        (Liar(), "Liar"),
        (HostileInt64(4), "HostileInt64"),
        (Hostile(), "Hostile"),
        ({"a": 1}, "dict"),
        ({1}, "set"),
        (b"bytes", "bytes"),
        (1j, "complex"),
        (np.complex64(1), "complex64"),
        (np.datetime64("2024-01-01"), "datetime64"),
        (np.timedelta64(1), "timedelta64"),
        (np.array([object()]), "ndarray"),
        (np.zeros(3, [("a", int)]), "ndarray"),
        (np.array(["a"]), "ndarray"),
        (np.zeros(2, complex), "ndarray"),
        (print, "builtin_function_or_method"),
        (10**400, "int"),
        (-(10**400), "int"),
    ]
    for value, name in strange:
        assert plain(value) == Strange(name)


def test_the_name_of_a_type_is_short_and_no_metaclass_is_asked_for_it():
    assert type_name(type("x" * 1000, (), {})()) == "x" * 60
    assert type_name(Liar()) == "Liar"


def test_an_array_becomes_a_new_one_of_a_plain_type():
    arrays = [
        (np.arange(6, dtype=np.int8).reshape(2, 3), np.int64),
        (np.zeros((2, 0), np.uint16), np.int64),
        (np.float16([1, np.nan]), np.float64),
        (np.array(True), np.bool_),
        (np.array(2.5), np.float64),
        (np.arange(12.0).reshape(3, 4)[::-1, ::2].T, np.float64),
        (np.ma.masked_array([1.0, 2.0], [True, False]), np.float64),
        (np.arange(4.0).view(HostileArray), np.float64),
        (np.broadcast_to(1.0, (3, 3)), np.float64),
        (np.array([1, 2], ">i4"), np.int64),
    ]
    for array, dtype in arrays:
        kept, content = plain(array), np.ndarray.view(array, np.ndarray)
        assert type(kept) is np.ndarray
        assert kept.dtype == dtype
        assert kept.flags.writeable
        assert np.array_equal(kept, content, equal_nan=dtype is np.float64)
        assert not np.shares_memory(kept, content)


def test_what_is_too_large_is_strange_and_is_not_even_copied():
    assert plain(np.broadcast_to(0.0, (10**6, 10**6))) == Strange("ndarray")
    assert plain([0] * 4_000_001) == Strange("list")
    assert len(plain("x" * 1_000_000)) == 100_000


def test_lists_that_hold_one_another_are_cut():
    circle = []
    circle.append(circle)
    assert repr(plain(circle)).count("(") < 10
    bomb = [0] * 3000
    for _ in range(4):
        bomb = [bomb] * 3000
    assert plain(bomb)[0][0][-1] == Strange("list")
    assert isinstance(plain([[[[[1]]]]])[0][0][0][0], tuple)


def test_text_that_no_file_could_hold_is_mended():
    assert plain("a\ud800b") == "a?b"


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "None"),
        (3, "3"),
        ("text", "'text'"),
        ("x" * 100_000, "'" + "x" * 58 + "…"),
        (Strange("dict"), "a value of type dict"),
        (np.zeros((2, 3)), "an array of shape (2, 3)"),
        ((np.zeros(2), 3), "(an array of shape (2,), 3)"),
        ((Strange("set"),), "(a value of type set,)"),
        ((1, 2), "(1, 2)"),
        (tuple(range(20)), "20 values, 0, 1 and so on"),
        ((), "()"),
    ],
)
def test_a_value_in_a_few_words(value, words):
    assert described(value) == words
    assert len(words) < 80


# --- JSON -------------------------------------------------------------------------------------------------------------

numbers = st.integers(-(2**70), 2**70) | st.floats() | st.booleans() | st.none()
arrays = hnp.arrays(
    st.sampled_from([np.float64, np.int64, np.bool_]), hnp.array_shapes(min_dims=0, min_side=0, max_side=3)
)
plain_values = st.recursive(
    numbers | st.text() | arrays | st.builds(Strange, st.text(max_size=60)),
    lambda inner: st.lists(inner, max_size=4).map(tuple),
    max_leaves=8,
)


@settings(derandomize=True, deadline=None)
@given(plain_values)
def test_json_there_and_back(value):
    line = to_json(value)
    assert "\n" not in line
    assert same(from_json(line), value)


@settings(derandomize=True, deadline=None)
@given(st.dictionaries(st.text(), plain_values, max_size=3))
def test_a_message_is_a_dict_of_plain_values(message):
    back = from_json(to_json(message))
    assert back.keys() == message.keys()
    assert all(same(back[key], message[key]) for key in message)


DAMAGED = [
    "",
    "{",
    "nonsense",
    "[1,",
    "{}",
    '{"dict": 3}',
    '{"dict": [1]}',
    '{"array": [1]}',
    '{"array": [1], "shape": [1]}',
    '{"array": [1], "shape": [1], "kind": "O"}',
    '{"array": [1], "shape": [1], "kind": []}',
    '{"array": [1], "shape": [2], "kind": "f"}',
    '{"array": [1], "shape": [-1], "kind": "f"}',
    '{"array": [1], "shape": null, "kind": "f"}',
    '{"array": [1], "shape": ["1"], "kind": "f"}',
    '{"array": [1], "shape": [true], "kind": "f"}',
    '{"array": ["x"], "shape": [1], "kind": "f"}',
    '{"array": [[1], [1, 2]], "shape": [2], "kind": "f"}',
    '{"array": [1e999], "shape": [1], "kind": "i"}',
    '{"array": [99999999999999999999], "shape": [1], "kind": "i"}',
    '{"array": {}, "shape": [1], "kind": "f"}',
    '{"array": [], "shape": [0, 99999999999999999999], "kind": "f"}',
    "[" * 100_000,
    "9" * 10_000,
]


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("line", DAMAGED, ids=[line[:40] or "empty" for line in DAMAGED])
def test_damaged_json_is_a_value_error_and_nothing_else(line):
    with pytest.raises(ValueError):  # noqa: PT011 (json's own words, or ours)
        from_json(line)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["array", "shape", "kind", "strange", "dict", "x"]), inner, max_size=4)
    ),
    max_leaves=8,
)


@pytest.mark.filterwarnings("ignore")
@settings(derandomize=True, deadline=None, max_examples=300)
@given(json_values)
def test_any_json_is_a_plain_value_or_a_value_error(value):
    with contextlib.suppress(ValueError):
        from_json(json.dumps(value))
