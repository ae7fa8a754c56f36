"""What runs in a learner's own process: their cells, and their functions when the judge calls one.

Started by `process.LearnerProcess`. It speaks JSON, a line a message, over the socket it is given; nothing that it says
is believed but as a plain value that the learner's code came up with.
"""

import contextlib
import json
import os
import socket
import sys

import numpy as np

from course_lib.checks.callback import asking
from course_lib.checks.here import Prints, TimeIsUp, guarded_call, stopped_after, words_for
from course_lib.checks.learner import Fault, Kind, arrays_in
from course_lib.checks.plain import from_json, plain, to_json
from course_lib.checks.worlds import EnoughSteps, World
from course_lib.classroom.confine import confine_to, limit_resources


def main():
    number, settings = int(sys.argv[1]), json.loads(sys.argv[2])
    line = Line(socket.socket(fileno=number))
    cells = Cells()
    limit_resources(settings["memory_limit"], settings["file_limit"], settings["processor_seconds"])
    confine_to(os.getcwd())
    line.say({"ready": True})
    while True:
        request = line.hear()
        if "run" in request:
            line.say({"ran": cells.run(request["run"], request["time_limit"])})
        else:
            line.say(cells.call(line, request["call"], request["arguments"], request["time_limit"]))


class Line:
    """Messages to and from the judge."""

    def __init__(self, connection):
        self._stream = connection.makefile("rwb")

    def say(self, message):
        self._stream.write(to_json(message).encode() + b"\n")
        self._stream.flush()

    def hear(self):
        said = self._stream.readline()
        if not said:
            os._exit(0)  # the judge has gone
        return from_json(said.decode())


class Cells:
    """The notebook's code cells and what they have defined, with all that IPython adds to Python."""

    def __init__(self):
        from IPython.core.interactiveshell import InteractiveShell
        from traitlets.config import Config

        quiet = Config({"HistoryManager": {"enabled": False}, "InteractiveShell": {"colors": "nocolor"}})
        self._shell = InteractiveShell.instance(config=quiet)
        self._shell.showtraceback = self._shell.showsyntaxerror = lambda *_, **__: None  # `run` says it in words

    def run(self, source, time_limit):
        """Run a cell: the beginning of what it printed; what it raised, in words, or None."""
        prints = Prints()
        with contextlib.redirect_stdout(prints), contextlib.redirect_stderr(prints), stopped_after(time_limit):
            result = self._shell.run_cell(source)
        error = result.error_before_exec or result.error_in_exec
        if isinstance(error, TimeIsUp):
            return prints.kept, f"TimeIsUp: this cell was still running after {time_limit:g} seconds"
        return prints.kept, None if error is None else words_for(error)

    def call(self, line, name, arguments, time_limit):
        """Call the function of that name; the message that says what came of it."""
        asked = []

        def ask_judge(number, *question):
            asked.append(number)
            line.say({"ask": (number, *(plain(item) for item in question))})
            answer = line.hear()
            if "enough" in answer:
                raise EnoughSteps(answer["enough"])
            if "error" in answer:
                raise ValueError(answer["error"])
            return answer["answer"]

        try:
            if name not in self._shell.user_ns:
                raise Fault(Kind.NO_FUNCTION, f"the notebook defines no `{name}`")
            given = [_argument(argument, ask_judge) for argument in arguments]
            passed = tuple(arrays_in(given))
            value = guarded_call(self._shell.user_ns[name], given, time_limit, was_anything_done=lambda: bool(asked))
            return {"returned": (plain(value), tuple(plain(array) for array in passed))}
        except Fault as fault:
            return {"fault": (str(fault.kind), str(fault))}


def _argument(argument, ask_judge):
    if not isinstance(argument, dict):
        return argument
    if "seed" in argument:
        return np.random.default_rng(argument["seed"])
    if "function" in argument:
        number, name, parameters = argument["function"]
        return asking(name, parameters, lambda *question: ask_judge(number, *question))
    number, rows, columns = argument["world"]
    return World(rows, columns, lambda *question: ask_judge(number, *question))


if __name__ == "__main__":
    main()
