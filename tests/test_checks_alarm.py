"""The alarm clock: code that runs for ever is stopped, and everything else is as it was before."""

import contextlib
import signal
import time

import pytest
from test_checks_here import call, everywhere, fault_of

from course_lib.checks.alarm import TimeIsUp, stopped_after
from course_lib.checks.learner import Kind

needs_signals = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no alarm signals")


def runs_for_ever():
    while True:
        pass


def lets_errors_pass():
    while True:
        with contextlib.suppress(Exception):
            runs_for_ever()


def lets_the_first_stop_pass():
    try:
        runs_for_ever()
    except BaseException:
        runs_for_ever()


def prints_for_ever():
    while True:
        print("x" * 1000)


@everywhere
@pytest.mark.parametrize("function", [runs_for_ever, lets_errors_pass, lets_the_first_stop_pass, prints_for_ever])
def test_time_is_up(function, on):
    fault = on(lambda: fault_of(function, time_limit=0.05))
    assert fault.kind is Kind.TIME_UP
    assert str(fault) == "your code was still running after 0.05 seconds"


@needs_signals
def test_even_a_sleep_is_broken_off():
    started = time.monotonic()
    assert fault_of(lambda: time.sleep(60), time_limit=0.05).kind is Kind.TIME_UP
    assert time.monotonic() - started < 30


@everywhere
def test_after_a_call_no_alarm_rings(on):
    def work():
        fault_of(runs_for_ever, time_limit=0.02)
        call(lambda: 1, time_limit=0.02)
        if hasattr(signal, "getitimer"):
            assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
        ends = time.monotonic() + 0.3
        while time.monotonic() < ends:
            sum(range(100))
        return "undisturbed"

    assert on(work) == "undisturbed"


@needs_signals
def test_the_handler_and_the_timer_of_others_are_as_before():
    rung = []
    before = signal.signal(signal.SIGALRM, lambda *_: rung.append(True))
    ours = signal.getsignal(signal.SIGALRM)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        fault_of(runs_for_ever, time_limit=0.05)
        assert signal.getsignal(signal.SIGALRM) is ours
        assert 0 < signal.getitimer(signal.ITIMER_REAL)[0] < 0.2
        ends = time.monotonic() + 10
        while not rung and time.monotonic() < ends:
            sum(range(100))
        assert rung == [True]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@everywhere
def test_an_alarm_within_an_alarm(on):
    def work():
        with stopped_after(5):
            with pytest.raises(TimeIsUp), stopped_after(0.05):
                runs_for_ever()
            return "the outer one did not ring"

    assert on(work) == "the outer one did not ring"


def test_an_alarm_lets_pass_as_little_as_it_can():
    assert not issubclass(TimeIsUp, Exception)
