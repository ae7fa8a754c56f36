"""What the benchmarks share: runs that take turns, medians, a table, and C compiled on the spot."""

import ctypes
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

FLAGS = ("-O3", "-shared", "-fPIC", "-ffp-contract=off")  # no contraction: a fused multiply-add would round differently


def seconds(work):
    """How long one call of `work` takes."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def medians(runs, repeats):
    """Time every run `repeats` times in turn (A B A B …), so that a slow moment of the machine hits all alike.

    runs: {name: function that returns the seconds it took}. Returns {name: median seconds}. A first round, in which
    memory is touched for the first time, is not counted.
    """
    taken = {name: [] for name in runs}
    for _ in range(repeats + 1):
        for name, run in runs.items():
            taken[name].append(run())
    return {name: statistics.median(times[1:]) for name, times in taken.items()}


def show(title, rows):
    """Print rows of text, the first of them the heading, as a Markdown table."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [" | ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)) for row in rows]
    lines.insert(1, " | ".join("-" * width for width in widths))
    print(f"\n{title}\n")
    print("\n".join(f"| {line} |" for line in lines))


def compiler():
    """The path of gcc, or None."""
    return shutil.which("gcc")


def compile_c(source, *options):
    """The shared library made of a C file beside this one; it is built in a temporary folder and gone afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "library.so")
        subprocess.run([compiler(), *FLAGS, *options, Path(__file__).with_name(source), "-o", library], check=True)
        return ctypes.CDLL(str(library))


def address(array):
    """An array's memory, as a C function takes it."""
    return ctypes.c_void_p(array.ctypes.data)
