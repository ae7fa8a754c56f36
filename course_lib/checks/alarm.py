"""An alarm clock for code that may run for ever."""

import ctypes
import signal
import sys
import threading
import time

_AGAIN_AFTER = 0.1  # seconds, should the code swallow what it is stopped by


class TimeIsUp(BaseException):
    """Raised into code that has run for too long. No `Exception`, so that `except Exception` lets it pass."""


def stopped_after(seconds):
    """A context manager that raises `TimeIsUp` into its block after `seconds`, and again each tenth of a second.

    On a main thread that has signals even a sleep is broken off; elsewhere the next line of Python is.
    """
    if hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread():
        return _BySignal(seconds)
    return _ByThread(seconds)


class _BySignal:
    def __init__(self, seconds):
        self._seconds, self._block = seconds, None

    def __enter__(self):
        self._block = sys._getframe(1)  # where the `with` is
        self._began = time.monotonic()
        self._handler_before = signal.signal(signal.SIGALRM, self._ring)
        self._timer_before = signal.setitimer(signal.ITIMER_REAL, self._seconds, _AGAIN_AFTER)

    def _ring(self, _, frame):
        """Raise it in the block and in what the block calls, but not while the block is being left."""
        while frame is not None and frame is not self._block:
            if frame.f_code is _BySignal.__exit__.__code__:
                return
            frame = frame.f_back
        if frame is not None:
            raise TimeIsUp

    def __exit__(self, *_):
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, self._handler_before or signal.SIG_DFL)
        self._block = None
        left, interval = self._timer_before
        if left:  # somebody else's alarm was set
            signal.setitimer(signal.ITIMER_REAL, max(1e-3, left - (time.monotonic() - self._began)), interval)


class _ByThread:
    def __init__(self, seconds):
        self._seconds, self._target, self._has_rung = seconds, threading.get_ident(), False
        self._over, self._turn = threading.Event(), threading.Lock()

    def __enter__(self):
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self):
        self._over.wait(self._seconds)
        while True:
            with self._turn:
                if self._over.is_set():
                    return
                self._ring()
            self._over.wait(_AGAIN_AFTER)

    def __exit__(self, *_):
        try:
            self._over.set()
            with self._turn:
                pass  # the watcher does not ring from here on
            if self._has_rung:
                # A ring may still be on its way. There is room for one: send another, and wait until it is here.
                # (Taking it back is no way: Python 3.11 then hangs wherever a debugger is at work.)
                self._ring()
                waited_enough = time.monotonic() + 1
                while time.monotonic() < waited_enough:
                    pass
        except TimeIsUp:
            pass

    def _ring(self):
        """Have the watched thread raise `TimeIsUp` before its next line."""
        self._has_rung = True
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._target), ctypes.py_object(TimeIsUp))
