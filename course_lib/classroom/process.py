"""A learner's code in a process of its own, with limits; the judge plays the worlds and keeps the verdict."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from dataclasses import dataclass

import numpy as np

from course_lib.checks.callback import Callback
from course_lib.checks.learner import Fault, Kind, Learner, Returned, Seed, arrays_in
from course_lib.checks.plain import from_json, plain, to_json
from course_lib.checks.worlds import EnoughSteps, Watched

_START_SECONDS, _GRACE_SECONDS = 60, 2
_LONGEST_MESSAGE = 64_000_000
_OUT_OF_TURN = "it said something else than the value that was asked for"


@dataclass(frozen=True)
class Limits:
    """What a learner's process may use: seconds a cell or call, bytes of memory, of prints, of any file it writes."""

    time_limit: float = 30.0
    memory_limit: int = 4_000_000_000
    output_limit: int = 10_000_000
    file_limit: int = 50_000_000


class LearnerProcess:
    """One child process in `folder`, which it may write in, that runs cells and calls functions. A context manager.

    Whatever ends it early (its own doing, or ours when it oversteps a limit) appears as a `Fault` of kind DIED or
    TIME_UP, and `alive` is false from then on. `RuntimeError` where it does not even start, which is not their fault.
    """

    def __init__(self, folder, limits=Limits()):
        self.limits, self.alive, self._length = limits, True, 0
        self._socket, theirs = socket.socketpair()
        settings = {
            "memory_limit": limits.memory_limit,
            "file_limit": limits.file_limit,
            "processor_seconds": int(60 + 20 * limits.time_limit),
        }
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-m", "course_lib.classroom.child", str(theirs.fileno()), json.dumps(settings)],
                cwd=folder,
                env=_environment(folder),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )
        self._received = bytearray()
        threading.Thread(target=self._drain, daemon=True).start()
        self._deadline = time.monotonic() + _START_SECONDS
        try:
            self._hear()
        except Fault as fault:  # no code of the learner's has run yet
            raise RuntimeError(f"a process for the learner's code did not start: {fault}") from None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Kill the process and all that it has started in its session."""
        self.alive = False
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._socket.close()

    def run(self, source):
        """Run a notebook cell: the beginning of what it printed; what it raised, in words, or None."""
        said = self._ask({"run": source, "time_limit": self.limits.time_limit})
        match said.get("ran"):
            case (str(printed), str() | None as error):
                return printed, error
        raise self._died(_OUT_OF_TURN)

    def call(self, name, arguments, time_limit):
        """Call the learner's function of that name; a `Returned`, or a `Fault`."""
        here = [argument for argument in arguments if isinstance(argument, (Watched, Callback))]
        given = tuple(_crossing(argument, here) for argument in arguments)
        said = self._ask({"call": name, "arguments": given, "time_limit": time_limit}, here)
        try:
            if "fault" in said:
                kind, words = said["fault"]
                if kind == Kind.TIME_UP:  # it may have been stopped between a question and its answer
                    self.close()
                raise Fault(Kind(kind), str(words)[:600])
            value, arrays = said["returned"]
            number = len(list(arrays_in(arguments)))
            if [True] * number != [isinstance(array, np.ndarray) for array in arrays]:
                raise ValueError
        except (KeyError, TypeError, ValueError):
            raise self._died(_OUT_OF_TURN) from None
        return Returned(value, arrays)

    def _ask(self, request, here=()):
        """Send a request, answer what the child asks of the worlds and functions here, and give its last word."""
        self._deadline = time.monotonic() + request["time_limit"] + _GRACE_SECONDS
        self._say(request)
        while True:
            said = self._hear()
            if "ask" not in said:
                return said
            self._say(_answered(said["ask"], here))

    def _say(self, message):
        try:
            self._socket.settimeout(max(0.01, self._deadline - time.monotonic()))
            self._socket.sendall(to_json(message).encode() + b"\n")
        except TimeoutError:
            raise self._too_late() from None
        except OSError:
            raise self._died() from None

    def _hear(self):
        """The next message, a dict. A `Fault` if none comes in time or it is none."""
        while b"\n" not in self._received:
            try:
                self._socket.settimeout(max(0.01, self._deadline - time.monotonic()))
                more = self._socket.recv(1 << 16)
            except TimeoutError:
                raise self._too_late() from None
            except OSError:
                more = b""
            if not more:
                raise self._died()
            self._received += more
            if len(self._received) > _LONGEST_MESSAGE:
                raise self._died("it returned too much")
        line, _, self._received = self._received.partition(b"\n")
        try:
            said = from_json(line.decode())
        except ValueError:
            said = None
        if not isinstance(said, dict):
            raise self._died(_OUT_OF_TURN)
        return said

    def _too_late(self):
        self.close()
        return Fault(Kind.TIME_UP, "your code was still running when its time was up")

    def _died(self, why=""):
        """The fault to raise when the process has ended, or has to end."""
        if not why:
            with contextlib.suppress(subprocess.TimeoutExpired):
                why = _words_for_exit(self._process.wait(timeout=5))
        if self._length > self.limits.output_limit:
            why = f"it printed more than {self.limits.output_limit / 1e6:g} MB"
        self.close()
        return Fault(Kind.DIED, f"your code ended the process it ran in: {why}")

    def _drain(self):
        """Throw away what the process writes past Python's own prints, and end it when that is too much."""
        with self._process.stdout as prints:
            while more := prints.read1(1 << 16):
                self._length += len(more)
                if self._length > self.limits.output_limit:
                    with contextlib.suppress(ProcessLookupError):
                        os.killpg(self._process.pid, signal.SIGKILL)


def _environment(folder):
    """Nothing of the teacher's; what writes, writes in the learner's folder."""
    own = {"HOME": folder, "TMPDIR": folder, "IPYTHONDIR": folder, "MPLCONFIGDIR": folder, "NUMBA_CACHE_DIR": folder}
    fixed = {"LANG": "C.UTF-8", "MPLBACKEND": "Agg", "PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1"}
    return {"PATH": os.environ.get("PATH", os.defpath), **{name: str(path) for name, path in own.items()}, **fixed}


def _crossing(argument, here):
    """An argument as it crosses: a world or a function by its number, a generator by its seed."""
    number = next((i for i, other in enumerate(here) if other is argument), None)
    if isinstance(argument, Watched):
        return {"world": (number, argument.rows, argument.columns)}
    if isinstance(argument, Callback):
        return {"function": (number, argument.name, argument.parameters)}
    if isinstance(argument, Seed):
        return {"seed": argument.number}
    return plain(argument)


def _answered(question, here):
    """What a world or a function here answers to a question of the child's, which may be anything."""
    try:
        number, *arguments = question
        if not isinstance(number, int) or not 0 <= number < len(here):
            raise ValueError("there is nothing to ask by that number")
        return {"answer": here[number].answer(*arguments)}
    except EnoughSteps as error:
        return {"enough": str(error)}
    except (TypeError, ValueError) as error:
        return {"error": str(error)}


def _words_for_exit(code):
    if code >= 0:
        return f"it left with exit code {code}"
    if -code == signal.SIGXCPU:
        return "it used too much processor time"
    return f"it was stopped by signal {-code}"


class There(Learner):
    """The learner's function `name` in another process. `process` gives the process, a new one if the last has died."""

    def __init__(self, name, process):
        self.name, self._process = name, process

    def call(self, *arguments, time_limit):
        return self._process().call(self.name, arguments, time_limit)

    def __call__(self, *arguments):
        """The plain value of a call, for checks that a teacher writes as plain assertions."""
        process = self._process()
        return process.call(self.name, arguments, process.limits.time_limit).value
