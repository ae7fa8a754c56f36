"""What the benchmarks share: runs that take turns, medians, a table, and C compiled on the spot."""

import ctypes
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).parent
FLAGS = ("-O3", "-shared", "-fPIC", "-ffp-contract=off")  # no contraction: a fused multiply-add would round differently


def seconds(work):
    """How long one call of `work` takes."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def medians(runs, repeats):
    """Time every run `repeats` times in turn (A B A B …), so that a slow moment of the machine hits all alike.

    runs: {name: function that returns the seconds it took}. Returns {name: median seconds}.
    """
    taken = {name: [] for name in runs}
    for _ in range(repeats):
        for name, run in runs.items():
            taken[name].append(run())
    return {name: statistics.median(times) for name, times in taken.items()}


def show(title, rows):
    """Print rows of text, the first of them the heading, in columns."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    print(f"\n{title}\n")
    for i, row in enumerate(rows):
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
        if i == 0:
            print("  ".join("-" * width for width in widths))


def compiler():
    """The path of gcc, or None."""
    return shutil.which("gcc")


def compile_c(source, *options):
    """The shared library made of a C file beside this one; it is built in a temporary folder and gone afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "library.so")
        subprocess.run([compiler(), *FLAGS, *options, HERE / source, "-o", library], check=True)
        return ctypes.CDLL(str(library))


def address(array):
    """An array's memory, as a C function takes it."""
    return ctypes.c_void_p(array.ctypes.data)
