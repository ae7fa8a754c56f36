"""A learner's function in this very process, called so that nothing it does can break the check."""

import contextlib
import inspect
import io
import linecache
import os
import sysconfig
import types
from pathlib import Path

import numpy as np

from course_lib.checks.alarm import TimeIsUp, stopped_after
from course_lib.checks.callback import Callback, asking
from course_lib.checks.learner import Fault, Kind, Learner, Returned, Seed, arrays_in
from course_lib.checks.plain import described, plain, type_name
from course_lib.checks.worlds import EnoughSteps, Watched, World

__all__ = ["Here", "Prints", "TimeIsUp", "guarded_call", "stopped_after", "words_for"]

_KEPT_PRINTS = 2_000
_OURS = (str(Path(__file__).parents[1]), *(sysconfig.get_path(name) for name in ("stdlib", "purelib")))
_NOT_THE_LEARNERS = (*(folder + os.sep for folder in _OURS), "<frozen")


class Here(Learner):
    """The learner's `function`, called in this process."""

    def __init__(self, function):
        self.function = function
        self.name = _name_of(function)
        self._prints = Prints()

    @property
    def printed(self):
        return self._prints.shown

    def call(self, *arguments, time_limit):
        given = [_handed_over(argument) for argument in arguments]
        arrays = tuple(arrays_in(given))
        with contextlib.redirect_stdout(self._prints), contextlib.redirect_stderr(self._prints):
            value = guarded_call(
                self.function, given, time_limit, was_anything_done=lambda: any(map(_was_asked, arguments))
            )
        return Returned(plain(value), tuple(plain(array) for array in arrays))


def _handed_over(argument):
    if isinstance(argument, Watched):
        return World(argument.rows, argument.columns, argument.answer)
    if isinstance(argument, Callback):
        return asking(argument.name, argument.parameters, argument.answer)
    if isinstance(argument, Seed):
        return np.random.default_rng(argument.number)
    return _copied(argument)


def _copied(argument):
    """The argument with all its arrays anew: no call can change those of the check."""
    if isinstance(argument, tuple):
        return tuple(_copied(item) for item in argument)
    return argument.copy() if isinstance(argument, np.ndarray) else argument


def _was_asked(argument):
    """Whether the learner's code has played in this world, or called this function."""
    return bool(argument.episodes if isinstance(argument, Watched) else getattr(argument, "calls", 0))


def guarded_call(function, arguments, time_limit, was_anything_done):
    """The value of `function(*arguments)`, or a `Fault`, whatever it raises."""
    _check_signature(function, arguments)
    try:
        with stopped_after(time_limit):
            value = function(*arguments)
    except NotImplementedError as error:
        raise _not_written(error, was_anything_done()) from error
    except TimeIsUp as error:
        raise Fault(Kind.TIME_UP, f"your code was still running after {time_limit:g} seconds") from error
    except EnoughSteps as error:
        raise Fault(Kind.STEPS_UP, f"your code did not stop {error or 'taking steps'}") from error
    except KeyboardInterrupt as error:
        raise Fault(Kind.INTERRUPTED, "you stopped it") from error
    except BaseException as error:
        raise Fault(Kind.RAISED, words_for(error)) from error
    word = "yield" if type(value) is types.GeneratorType else "async" if type(value) is types.CoroutineType else ""
    if word:
        value.close()
        raise Fault(Kind.RAISED, f"a {type_name(value)}, and nothing in it has run: that is what `{word}` does")
    return value


def _not_written(error, was_anything_done):
    """The fault of a `raise NotImplementedError`: the function's own, or that of another one which it calls."""
    frames = _learners_frames(error)
    if len(frames) > 1:
        name = frames[-1].tb_frame.f_code.co_name
        return Fault(Kind.RAISED, f"`{name}`, which your code calls, is not written yet: it raises NotImplementedError")
    if was_anything_done:
        words = "your code ran, and then came to the `raise NotImplementedError` that is still in it"
        return Fault(Kind.LEFT_OVER, words)
    return Fault(Kind.NOT_STARTED, "`raise NotImplementedError` still stands in the place of your code")


def _check_signature(function, arguments):
    if not callable(function):
        raise Fault(Kind.NO_FUNCTION, f"not a function, but {described(plain(function))}")
    try:
        signature = inspect.signature(function)
        shown = f"{_name_of(function)}{signature}"[:120]
    except Exception:  # some builtins have none, and it is the learner's code that says what a class of theirs has
        return
    try:
        signature.bind(*arguments)
    except TypeError as error:
        raise Fault(Kind.SIGNATURE, f"`{shown}` cannot take {len(arguments)} arguments: {error}") from error


def _name_of(function):
    try:
        name = plain(function.__name__)
    except Exception:
        name = None
    return name if isinstance(name, str) else type_name(function)


def words_for(error):
    """'ValueError: no such cell, in line 7 of `look`: `cells[state]`; called from line 12 of `play`: `look(state)`'.

    The lines are the learner's: the last that was at work and, where that is another function, the first.
    """
    words = f"{type_name(error)}: {_text(error)}".rstrip(": ")
    frames = _learners_frames(error)
    if frames:
        words += f", in {_line_of(frames[-1])}"
    if len(frames) > 1:
        words += f"; called from {_line_of(frames[0])}"
    return words


def _line_of(frame):
    code = frame.tb_frame.f_code
    line = linecache.getline(code.co_filename, frame.tb_lineno).strip().replace("`", "'")
    where = "" if code.co_name.startswith("<") else f" of `{code.co_name}`"
    return f"line {frame.tb_lineno}{where}" + (f": `{line[:100]}`" if line else "")


def _learners_frames(error):
    """The traceback's frames that are in code of the learner's, outermost first."""
    frames, frame = [], BaseException.__traceback__.__get__(error)
    while frame is not None:
        file = frame.tb_frame.f_code.co_filename
        if not file.startswith(_NOT_THE_LEARNERS) and not file.endswith(".pyx"):  # numpy's, compiled
            frames.append(frame)
        frame = frame.tb_next
    return frames


def _text(error):
    try:
        return plain(str(error))[:300]
    except Exception:  # a learner's own exception may fail to say what it is
        return ""


class Prints(io.TextIOBase):
    """Takes the place of stdout: keeps the beginning, counts the rest, and slows nobody down."""

    def __init__(self):
        self.kept, self.length = "", 0

    @property
    def shown(self):
        """What was kept, and how much was not."""
        more = self.length - len(self.kept)
        return self.kept + (f" … and {more:,} characters more" if more else "")

    def writable(self):
        return True

    def write(self, text):
        if not isinstance(text, str):
            raise TypeError(f"write() takes text, got {type_name(text)}")
        if self.length < _KEPT_PRINTS:
            self.kept += plain(text)[: _KEPT_PRINTS - self.length]
        self.length += len(text)
        return len(text)
