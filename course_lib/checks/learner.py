"""The small interface that every check is written against: call the learner's function, get plain values or a `Fault`.

`here.Here` serves it beside the learner's code, in one process; `classroom.process.There` serves it across a pipe.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np


class Kind(StrEnum):
    """What can become of a call."""

    NOT_STARTED = "not started"  # raise NotImplementedError, before anything was done
    LEFT_OVER = "left over"  # the same, after something was done
    NO_FUNCTION = "no function"
    SIGNATURE = "signature"
    RAISED = "raised"
    TIME_UP = "time up"
    STEPS_UP = "steps up"
    INTERRUPTED = "interrupted"
    DIED = "died"


class Fault(Exception):
    """The learner's function gave no value. `str` says why, in words for the learner."""

    def __init__(self, kind, words):
        super().__init__(words)
        self.kind = kind


@dataclass(frozen=True)
class Seed:
    """An argument that arrives as `numpy.random.default_rng(number)`."""

    number: int


@dataclass(frozen=True)
class Returned:
    """What came of a call: its plain value, and each array that was passed as it is after the call.

    Arrays in a tuple that was passed are among them, in order.
    """

    value: object
    arrays: tuple


def arrays_in(arguments):
    """Each array among the arguments, and in tuples among them, in order."""
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            yield argument
        elif isinstance(argument, tuple):
            yield from arrays_in(argument)


class Learner:
    """A function of the learner's, wherever it runs."""

    name: str

    def call(self, *arguments, time_limit):
        """Call it; give a `Returned` or raise a `Fault`.

        Arguments are numbers, arrays (copied), tuples of these, `Seed`s, `Watched` mazes and `Callback`s.
        """
        raise NotImplementedError

    printed = ""  # the beginning of what it has printed so far
