"""An alarm clock for code that may run for ever."""

import ctypes
import signal
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
        self._seconds, self._over = seconds, False

    def __enter__(self):
        self._began = time.monotonic()
        self._handler_before = signal.signal(signal.SIGALRM, self._ring)
        self._timer_before = signal.setitimer(signal.ITIMER_REAL, self._seconds, _AGAIN_AFTER)

    def _ring(self, _, frame):
        leaving = frame is not None and frame.f_code is _BySignal.__exit__.__code__
        if not self._over and not leaving:
            raise TimeIsUp

    def __exit__(self, *_):
        self._over = True
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, self._handler_before or signal.SIG_DFL)
        left, interval = self._timer_before
        if left:  # somebody else's alarm was set
            signal.setitimer(signal.ITIMER_REAL, max(1e-3, left - (time.monotonic() - self._began)), interval)


class _ByThread:
    def __init__(self, seconds):
        self._seconds, self._target = seconds, threading.get_ident()
        self._over, self._turn = threading.Event(), threading.Lock()

    def __enter__(self):
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self):
        self._over.wait(self._seconds)
        while True:
            with self._turn:
                if self._over.is_set():
                    return
                self._raise(TimeIsUp)
            self._over.wait(_AGAIN_AFTER)

    def __exit__(self, *_):
        try:
            self._stop()
        except TimeIsUp:  # it was on its way
            self._stop()

    def _stop(self):
        self._over.set()
        with self._turn:
            self._raise(None)  # one may still be on its way

    def _raise(self, kind):
        """Have the watched thread raise `kind` before its next line; None takes back what it has not yet raised."""
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._target), kind and ctypes.py_object(kind))
