"""Arrays that a learner's function gives: whether they are right, and which mistake they look like if they are not."""

from dataclasses import dataclass

import numpy as np

from course_lib.checks.check import NotYet
from course_lib.checks.learner import arrays_in
from course_lib.checks.plain import Strange, described

ANY = np.inf  # stands in a right array where anything will do
_TOLERANCE = 1e-4  # float32 will do, as torch computes in it
_TABLES = ("DataFrame", "Index", "Series")

MISTAKES_WITH_ARRAYS = {
    "requires grad": "a tensor still carries its gradient: `values.detach().numpy()`.",
    "same dtype|but expected Float|expected scalar type|but found Double|to be of type Float|!= (double|float)|"
    "data type Double": "numbers of two kinds meet: numpy has float64, torch's networks have float32. "
    "`torch.tensor(x, dtype=torch.float32)`.",
    "truth value of an array|Boolean value of Tensor": "a question is asked of a whole array, such as "
    "`if terminated`: `np.where(terminated, …, …)` answers it for each entry.",
    "with a bool tensor is not supported|numpy boolean (subtract|negative)": "Booleans are not subtracted: "
    "`~terminated` is the opposite of `terminated`.",
}


@dataclass(frozen=True)
class Case:
    """One call of the learner's function.

    arguments  what it is given
    name       which case it is, in a few words; empty if there is nothing to say
    shown      shown(index): text to be seen beside a wrong entry of the array that came
    """

    arguments: tuple
    name: str = ""
    shown: object = None


def check_arrays(call, cases, right, mistakes, wanted, *, names=()):
    """The learner's function gives the array that `right(*arguments)` gives, in each of the cases.

    mistakes  [(function, words)]: functions as `right`, each wrong in one way; the first that gives what came is named
    wanted    what the shape means, such as "a number for each row"
    names     of the arguments, which are to be as they were after the call; none: that is not looked at
    """
    came = []
    for case in cases:
        returned = call(*case.arguments)
        came.append(array_from(returned.value, wanted))
        if names:
            _check_untouched(case, returned, names)
    for case, array in zip(cases, came, strict=True):
        expected = right(*case.arguments)
        if not same(array, expected):
            likely = next((words for mistake, words in mistakes if _gives(mistake, cases, came)), "")
            _say_what_differs(case, array, expected, likely, wanted)


def array_from(value, wanted):
    """A plain value as a float array; `NotYet` if it is something else than numbers of one shape."""
    strange = _first_strange(value)
    likely = f"your function returns something else than an array of numbers, {wanted}."
    if value is None:
        likely = "your function ends without `return`."
    elif strange is not None and strange.type_name in ("Tensor", "Parameter"):
        likely = "your function returns a torch tensor. `.detach().numpy()` makes a numpy array of it."
    elif strange is not None and strange.type_name in _TABLES:
        likely = "your function returns a table of pandas. `.to_numpy()` makes a numpy array of it."
    elif isinstance(value, (np.ndarray, tuple, int, float)) and strange is None:
        try:
            array = np.array(value)
        except ValueError:
            array = np.array(None)
            likely = f"the lists that your function returns differ in length: what is wanted is {wanted}."
        if array.dtype.kind in "biuf":
            return array.astype(float)
    raise NotYet(described(value), likely)


def same(came, right):
    """Whether an array is the right one, as far as float32 can tell."""
    if came.shape != right.shape:
        return False
    return bool(np.all((right == ANY) | np.isclose(came, right, _TOLERANCE, _TOLERANCE, equal_nan=True)))


def numbers(row):
    """'[0.25, nan, 5]': a few numbers for a table."""
    return "[" + ", ".join(f"{number:.4g}" for number in np.ravel(row)) + "]"


def _gives(mistake, cases, came):
    """Whether a mistaken function gives what came, in all cases."""
    for case, array in zip(cases, came, strict=True):
        try:
            with np.errstate(all="ignore"):
                instead = mistake(*case.arguments)
        except (IndexError, ValueError):  # it fails where the learner's function did not
            return False
        if not same(array, np.asarray(instead, float)):
            return False
    return True


def _say_what_differs(case, came, right, likely, wanted):
    where = f"{case.name}: " if case.name else ""
    if came.shape != right.shape:
        likely = likely or _likely_of_shape(came, right, wanted)
        if came.ndim == 0:
            raise NotYet(f"{where}one number, {came:.4g}", likely)
        raise NotYet(f"{where}{described(came)}; {right.shape} is right", likely)
    index = tuple(np.argwhere((right != ANY) & ~np.isclose(came, right, _TOLERANCE, _TOLERANCE, equal_nan=True))[0])
    place = f"row {index[0]}, column {index[1]}" if len(index) == 2 else f"entry {index[0]}"
    words = f"{where}{place} is {came[index]:.4g}; {right[index]:.4g} is right"
    if 1 < right.shape[-1] <= 8:
        place = f"row {index[0]} is " if len(index) == 2 else ""
        words = f"{where}{place}{numbers(came[index[:-1]])}; {numbers(right[index[:-1]])} is right"
    raise NotYet(words, likely, case.shown(index) if case.shown else "")


def _likely_of_shape(came, right, wanted):
    if came.T.shape == right.shape:
        return f"rows and columns are exchanged: what is wanted is {wanted}."
    if came.size == right.size:
        return f"the numbers are as many as they should be, but in another shape: what is wanted is {wanted}."
    return f"the shape is another one than asked for: what is wanted is {wanted}."


def _check_untouched(case, returned, names):
    """All arrays that the function was given, also those in tuples, are as they were."""
    after = iter(returned.arrays)
    for name, argument in zip(names, case.arguments, strict=True):
        for array in arrays_in([argument]):
            if not np.array_equal(array, next(after), equal_nan=array.dtype.kind == "f"):
                raise NotYet(
                    f"after the call `{name}` is not what it was",
                    f"your function writes into `{name}`, which belongs to whoever called it: work in a copy, "
                    "`.copy()`, or make a new array.",
                )


def _first_strange(value):
    if isinstance(value, tuple):
        return next((found for item in value if (found := _first_strange(item)) is not None), None)
    return value if isinstance(value, Strange) else None
