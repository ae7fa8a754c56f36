"""What training needs around it: one thread, no denormal numbers, no gradient tape, and no stop in mid-step."""

import signal
import threading
from contextlib import contextmanager

import torch


@contextmanager
def small_tensors():
    """How small networks want torch to be; everything is put back afterwards.

    One thread, since these tensors are too small to share out, and since sums then do not depend on the machine's
    number of cores. Denormal numbers, which Adam's averages fade into and which processors add up a hundred times more
    slowly, are taken for zero. No gradients are recorded: ours are written out.
    """
    threads, flushed = torch.get_num_threads(), float(torch.full((8,), 1e-39).mul_(0.5).max()) == 0.0
    torch.set_num_threads(1)
    torch.set_flush_denormal(True)
    try:
        with torch.no_grad():
            yield
    finally:
        torch.set_flush_denormal(flushed)
        torch.set_num_threads(threads)


@contextmanager
def whole_steps():
    """Gives a function that raises `KeyboardInterrupt` if one was asked for meanwhile: Ctrl-C waits for it.

    So the agent is never stopped between two halves of a step. A second Ctrl-C does not wait. Where there are no
    signals to be had (another thread, a handler of somebody else's) nothing is changed.
    """
    on_main_thread = threading.current_thread() is threading.main_thread()
    if not on_main_thread or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield lambda: None
        return
    asked = []

    def note(number, frame):
        if asked:
            signal.default_int_handler(number, frame)
        asked.append(number)

    def look():
        if asked:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, note)
    try:
        yield look
        look()
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
