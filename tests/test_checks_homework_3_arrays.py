"""Arrays that come back from a learner's function: which are right, and what is said of those that are not."""

import numpy as np
import pytest

from course_lib.checks.check import Call, NotYet
from course_lib.checks.here import Here
from course_lib.checks.homework_3.arrays import ANY, Case, array_from, check_arrays, same
from course_lib.checks.plain import plain


def calling(function):
    return Call(Here(function), 5.0)


@pytest.mark.parametrize("value", [[[1, 2], [3, 4]], ((1, 2.0), [3, True]), np.array([[1, 2], [3, 4]], np.float32)])
def test_numbers_in_any_form_are_an_array(value):
    array = array_from(plain(value), "rows")
    assert array.shape == (2, 2)
    assert array.dtype == float


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "ends without `return`"),
        ("done", "something else than an array of numbers, rows."),
        ([["1", "2"]], "something else than an array"),
        ([[1, None]], "something else than an array"),
        ([[1, 2], [3]], "differ in length"),
        ([1, [2, 3]], "differ in length"),
        ({"a": 1}, "something else than an array"),
        (np.array([1j, 2]), "something else than an array"),
        (np.array(["a"]), "something else than an array"),
        (10**400, "something else than an array"),
        ([10**100], "something else than an array"),
        (object(), "something else than an array"),
        (lambda: 3, "something else than an array"),
    ],
)
def test_what_is_no_array_of_numbers_is_told_so(value, words):
    with pytest.raises(NotYet) as finding:
        array_from(plain(value), "rows")
    assert words in finding.value.likely


def test_tensors_and_tables_are_told_how_to_become_arrays():
    torch, pandas = pytest.importorskip("torch"), pytest.importorskip("pandas")
    for value, words in (
        (torch.ones(2, 2), "`.detach().numpy()`"),
        ([torch.ones(2), torch.ones(2)], "`.detach().numpy()`"),
        (torch.nn.Parameter(torch.ones(2)), "`.detach().numpy()`"),
        (pandas.DataFrame(np.eye(2)), "`.to_numpy()`"),
        (pandas.Series([1.0]), "`.to_numpy()`"),
    ):
        with pytest.raises(NotYet) as finding:
            array_from(plain(value), "rows")
        assert words in finding.value.likely


def test_what_float32_cannot_tell_is_the_same():
    right = np.array([1.0, -300.0, np.nan, ANY])
    assert same(np.array([1.0 + 1e-5, -300.0 - 1e-3, np.nan, np.nan]), right)
    for wrong in ([1.001, -300, np.nan, 0], [1, -300, 0, 0], [np.nan, -300, np.nan, 0], [1, -300, np.nan]):
        assert not same(np.array(wrong, float), right)


@pytest.mark.parametrize(
    ("change", "came", "likely"),
    [
        (lambda rows: rows + 1, "first: row 0 is [1, 2, 3]; [0, 1, 2] is right", ""),
        (lambda rows: rows.T, "an array of shape (3, 4)", "exchanged"),
        (lambda rows: rows.ravel(), "an array of shape (12,)", "in another shape"),
        (lambda rows: rows[1:], "an array of shape (3, 3); (4, 3) is right", "another one than asked for"),
        (lambda rows: rows[0, 0], "one number, 0", "another one than asked for"),
        (lambda rows: np.where(rows == 7, np.nan, rows), "row 2 is [6, nan, 8]; [6, 7, 8] is right", ""),
        (lambda rows: -rows, "row 0 is [-0, -1, -2]", "the sign."),
    ],
)
def test_what_differs_is_shown(change, came, likely):
    rows = np.arange(12.0).reshape(4, 3)
    cases = [Case((rows,), "first"), Case((rows + 20,))]
    mistakes = [(lambda rows: -rows, "the sign."), (lambda rows: rows[9], "never")]
    check_arrays(calling(lambda rows: rows), cases, lambda rows: rows, mistakes, "rows")
    with pytest.raises(NotYet) as finding:
        check_arrays(calling(change), cases, lambda rows: rows, mistakes, "rows")
    assert came in finding.value.came
    assert likely in finding.value.likely
    assert bool(likely) == bool(finding.value.likely)


def test_a_mistake_is_named_if_it_explains_all_cases_only():
    cases = [Case((np.ones(3),)), Case((np.zeros(3),))]
    mistakes = [(lambda x: x * 0 + 7, "seven.")]
    for function, words in ((lambda x: 0 * x + 7, "seven."), (lambda x: 6 * x + 1, "")):
        with pytest.raises(NotYet) as finding:
            check_arrays(calling(function), cases, lambda x: x + 1, mistakes, "x")
        assert finding.value.likely == words


@pytest.mark.parametrize("wide", [9, 30])
def test_of_long_rows_one_entry_is_shown(wide):
    with pytest.raises(NotYet, match=r"row 0, column 2 is 5; 2 is right"):
        check_arrays(
            calling(lambda x: np.where(x == 2, 5, x)),
            [Case((np.arange(float(wide))[None],))],
            lambda x: x,
            [],
            "rows",
        )


def test_arrays_that_were_given_are_to_stay_as_they_are():
    layers = ((np.eye(2), np.zeros(2)), (np.eye(2), np.ones(2)))
    x, nan = np.ones((3, 2)), np.array([np.nan, 1.0])

    def check(function):
        names = ("x", "layers", "nan", "gamma")
        check_arrays(calling(function), [Case((x, layers, nan, 0.9))], lambda x, *_: x, [], "rows", names=names)

    def writes(where):
        def function(x, layers, nan, _):
            given = {"x": x, "layers": layers[1][1], "nan": nan}
            result = x.copy()
            given[where][0] = 3
            return result

        return function

    check(lambda x, *_: x.copy())
    for name in ("x", "layers", "nan"):
        with pytest.raises(NotYet) as finding:
            check(writes(name))
        assert finding.value.came == f"after the call `{name}` is not what it was"
    np.testing.assert_array_equal(layers[1][1], [1, 1])
