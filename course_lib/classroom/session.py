"""A learner's notebook at work: its cells in a process that is started again when one of them has killed it."""

import shutil
import tempfile
import time
from pathlib import Path

from course_lib.checks.learner import Fault, Kind
from course_lib.classroom.process import LearnerProcess, Limits


class Session:
    """The cells of one submission, run in order in a copy of its `folder`. A context manager.

    A cell that ends the process, or does not end, costs what depends on it and no more: the next cell, or the next
    check, finds a new process in which all the others have been run.
    """

    def __init__(self, folder, limits=Limits(), total_time_limit=300.0):  # noqa: B008 (frozen)
        self._folder, self._limits = folder, limits
        self._deadline = time.monotonic() + total_time_limit
        self._process, self._ran = None, []

    def __enter__(self):
        self._own = tempfile.mkdtemp(prefix="learner-")
        self._work = Path(self._own, "work")
        shutil.copytree(self._folder, self._work, symlinks=True, ignore=shutil.ignore_patterns("*.ipynb"))
        return self

    def __exit__(self, *_):
        self._stop()
        shutil.rmtree(self._own, ignore_errors=True)

    def process(self):
        """The running process. A `Fault` when the submission has used up its time."""
        while self._process is None or not self._process.alive:
            if time.monotonic() > self._deadline:
                raise Fault(Kind.TIME_UP, "your notebook has used up its time")
            self._stop()
            self._process = LearnerProcess(self._work, self._limits)
            self._run_again()
        return self._process

    def run(self, source):
        """Run a cell: what it printed, and what it raised, in words, or None."""
        try:
            printed, error = self.process().run(source)
        except Fault as fault:
            return "", f"{fault.kind}: {fault}"
        self._ran.append(source)
        return printed, error

    def _run_again(self):
        for source in list(self._ran):
            try:
                self._process.run(source)
            except Fault:
                self._ran.remove(source)  # it went well the first time, and not again
                return

    def _stop(self):
        if self._process is not None:
            self._process.close()
            self._process = None
