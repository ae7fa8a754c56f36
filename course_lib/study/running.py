"""Run a study: share its cells out, gather what comes in whatever order, keep what is finished."""

import os
import threading
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor, as_completed
from contextlib import closing, contextmanager

from course_lib.study.kept import Kept
from course_lib.study.plan import (
    cells_of,
    check_importable,
    described,
    seeds_in,
    settings_in,
    takes_blocks,
)
from course_lib.study.results import Results
from course_lib.study.work import CellFailed, check_alike, run_cell
from course_lib.validate import whole_number


def run(train, grid, *, seeds=10, block=25, executor=None, folder=None, progress=False):
    """The same training for every setting of `grid` and every seed; returns the `Results`.

    train     train(seed, **settings) of one agent, which gives {name: number or curve [N]}; or train(seeds, **settings)
              of a block of them, int64[B], which gives {name: [B] or [B, N]}. What it gives must depend on nothing but
              its arguments, so it makes its environment itself: threads would share one made outside. Then results are
              the same to the last bit wherever and in whatever order it is called, on computers of one kind with the
              same versions of Python, numpy and numba
    grid      {name: values}: every combination; a list, tuple, range or array is several values, anything else one. Or
              a list of dictionaries, the settings themselves. Values are plain: numbers, text, None, lists of them, …
    seeds     how many (0, 1, 2, …), or which
    block     how many seeds are one piece of work, a cell: given to one worker, finished and kept as a whole. Where a
              training takes minutes, take few or 1, so that all workers have something to do and little is lost
    executor  any `concurrent.futures.Executor`; None: threads, one for each core. They share the work where training is
              compiled, as in `train_tables`; what is Python, or torch, is better off in a `ProcessPoolExecutor`. Where
              other processes may work, `train` must be importable there
    folder    where finished cells are kept, and read instead of being trained again (see `Kept`). What the
              function uses from outside is noticed where it is plain (numbers, texts, lists); functions that it calls
              are not: change those, and take a new folder
    progress  shows a bar

    Stopped (Ctrl-C, or a failure), it cancels what has not begun, and threads give up after the call of `train` that
    they are at; with a folder the same call then goes on. A cell that fails raises `CellFailed`, which names setting
    and seed; with a folder the others are finished first. `ValueError`, before anything is trained, for a grid, seeds
    or a function that cannot be meant, and afterwards where cells gave different measures.
    """
    settings, seeds = settings_in(grid), seeds_in(seeds)
    at_once, cells = takes_blocks(train, settings), cells_of(settings, seeds, block)
    if executor is not None and not isinstance(executor, Executor):
        raise ValueError(f"executor must be a concurrent.futures.Executor, got {executor!r}")
    threads = executor is None or type(executor) is ThreadPoolExecutor  # one derived from it may send work elsewhere
    if not threads:
        check_importable(train)
    kept = None if folder is None else Kept(folder, train)

    found = {i: kept.read(cell) for i, cell in enumerate(cells)} if kept else {}
    arrays = {i: cell for i, cell in found.items() if cell is not None}
    missing = [i for i in range(len(cells)) if i not in arrays]
    finished = _finished(train, at_once, cells, missing, executor, threads, keep_on=kept is not None)
    with closing(finished), _bar(len(settings) * len(seeds), progress) as move_bar:
        move_bar(sum(len(cells[i].seeds) for i in arrays))
        for i, cell in finished:
            if kept:
                kept.write(cells[i], cell)
            arrays[i] = cell
            move_bar(len(cells[i].seeds))
    in_order = [arrays[i] for i in range(len(cells))]
    check_alike(cells, in_order)
    return Results(settings, seeds, cells, in_order)


def _finished(train, at_once, cells, missing, executor, threads, *, keep_on):
    """(number, arrays) of each missing cell as it comes; a failure is raised at once, or at the end to `keep_on`."""
    failures, futures, stop = {}, {}, threading.Event()
    more = (stop.is_set,) if threads else ()
    with _pool_of(executor, len(missing)) as pool:
        try:
            for i in missing:
                cell = cells[i]
                try:
                    future = pool.submit(run_cell, train, at_once, cell.settings, cell.seeds, *more)
                except BrokenExecutor as error:
                    raise _broken() from error
                futures[future] = i
            for future in as_completed(list(futures)):
                i = futures.pop(future)
                try:
                    yield i, _result(future, cells[i])
                except CellFailed as error:
                    failures[i] = error
                    if not keep_on:
                        raise
        finally:
            stop.set()
            for future in futures:
                future.cancel()
    if failures:
        first = min(failures)
        if len(failures) > 1:
            failures[first].add_note(f"{len(failures) - 1} more of {len(cells)} cells failed; the others are kept")
        raise failures[first]


def _result(future, cell):
    """The arrays of a cell; `CellFailed` for whatever its training, or the executor on its behalf, raised."""
    try:
        return future.result()
    except CellFailed:
        raise
    except BrokenExecutor as error:
        raise _broken() from error
    except Exception as error:
        raise CellFailed(f"{described(cell.settings, cell.seeds)}: {type(error).__name__}: {error}") from error


def _broken():
    """The error for an executor that does no more work."""
    return RuntimeError(
        "the executor broke: a process ended, or did not find the function that trains, which must be importable"
        " there; what is finished is kept if there is a folder, and the same call goes on with a new executor"
    )


@contextmanager
def _pool_of(executor, num_cells):
    """The executor, or threads of our own that nobody waits for when the study is stopped."""
    if executor is not None:
        yield executor
        return
    pool = ThreadPoolExecutor(max(1, min(_cores(), num_cells)), thread_name_prefix="study")
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _cores():
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def workers(address=None, *, threads=None):
    """A `with` block's executor: threads of this process, or the workers of the Dask cluster at `address`.

    address   None, or the scheduler's, such as "tcp://192.168.0.7:8786"
    threads   how many, where there is no address; None: one for each core
    `ValueError` where Dask is not installed, and for an address where no scheduler answers.
    """
    if address is None:
        with ThreadPoolExecutor(_cores() if threads is None else whole_number("threads", threads, at_least=1)) as pool:
            yield pool
        return
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(f'a cluster at {address!r} needs Dask: pip install -e ".[scale]"') from None
    try:
        client = Client(address, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ValueError(f"address must be that of a Dask scheduler, got {address!r}: {error}") from None
    with client:
        yield client.get_executor(pure=False)  # what failed is tried again, not remembered


@contextmanager
def _bar(total, progress):
    """A function that moves the bar on, or one that does nothing."""
    if not progress:
        yield lambda _: None
        return
    from tqdm.auto import tqdm

    with tqdm(total=total, unit="agent", leave=False) as bar:
        yield bar.update
