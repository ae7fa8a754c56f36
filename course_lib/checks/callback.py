"""A function between judge and learner: the judge's side answers and counts, the learner's side asks."""

import inspect

import numpy as np

from course_lib.checks.plain import plain
from course_lib.checks.worlds import EnoughSteps


class Callback:
    """A function of the judge's as an argument: it arrives as a Python function of the same name that asks the judge.

    function   plain values in, a plain value out; a `ValueError` of its own is raised in the learner's code
    max_calls  calls after which `EnoughSteps` is raised
    """

    def __init__(self, function, *, max_calls=50_000):
        self.function, self.max_calls = function, max_calls
        self.name = function.__name__
        self.parameters = tuple(inspect.signature(function).parameters)
        self.calls = 0

    @property
    def exhausted(self):
        return self.calls >= self.max_calls

    def answer(self, *arguments):
        """What the learner's function asks for: the value for these arguments, whatever they are."""
        if self.exhausted:
            raise EnoughSteps(f"calling `{self.name}`")
        self.calls += 1
        if len(arguments) != len(self.parameters):
            raise ValueError(f"`{self.name}` takes {len(self.parameters)} arguments, got {len(arguments)}")
        return plain(self.function(*(plain(argument) for argument in arguments)))


def asking(name, parameters, ask):
    """The learner's side of a `Callback`: a function of these parameters.

    ask  the judge's `Callback.answer`, or a pipe that leads to it
    """
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    signature = inspect.Signature([inspect.Parameter(parameter, kind) for parameter in parameters])

    def function(*arguments, **named):
        given = signature.bind(*arguments, **named)
        return ask(*(_as_array(argument) for argument in given.args))

    function.__name__ = function.__qualname__ = name
    function.__signature__ = signature
    return function


def _as_array(argument):
    """What says that it can be an array (a pandas Series, a tensor) as one: a function of the learner's own could."""
    is_foreign = not isinstance(argument, (np.ndarray, np.generic)) and hasattr(type(argument), "__array__")
    return np.asarray(argument) if is_foreign else argument
