"""What one waits for: the import, and the first call of what is compiled.

    python tests/benchmarks/startup.py

Every figure is of a fresh process. Compiled code is kept on disk; for the first call without it the cache is pointed at
an empty folder.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time

from measure import show

IMPORTS = ("numpy", "gymnasium", "course_lib")
CALLS = {
    "value_iteration": "work = lambda: course_lib.value_iteration(maze.mdp, 0.9).values.sum()",
    "QAgent.train": "work = lambda: course_lib.QAgent(maze).train(100).episode_length.sum()",
}
TIMED_CALL = """
import time, course_lib
maze = course_lib.Maze()
{work}
started = time.perf_counter()
first = work()
between = time.perf_counter()
again = work()
print(between - started, time.perf_counter() - between, first, again)
"""


def fresh_process(code, **environment):
    """Run `code` in a Python process of its own: what it printed, its wall seconds, its user seconds."""
    started = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=os.environ | environment
    )
    printed = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    process.stdout.close()
    if process.returncode:
        raise RuntimeError(f"this code ended with exit status {process.returncode}:\n{code}")
    return printed, time.perf_counter() - started, usage.ru_utime


def race_imports(repeats):
    programs = {"python, nothing imported": "pass"} | {f"import {name}": f"import {name}" for name in IMPORTS}
    taken = {name: [] for name in programs}
    for _ in range(repeats):
        for name, code in programs.items():
            taken[name].append(fresh_process(code)[1:])
    wall = {name: statistics.median(times[0] for times in taken[name]) for name in programs}
    user = {name: statistics.median(times[1] for times in taken[name]) for name in programs}
    peer = wall["import gymnasium"]
    rows = [("process", "wall seconds", "user seconds", "wall, over import gymnasium")]
    rows += [(name, f"{wall[name]:.3f}", f"{user[name]:.3f}", f"{wall[name] / peer:.2f}") for name in programs]
    show(f"Imports, medians of {repeats} processes in turn", rows)


def time_calls(names, repeats):
    rows = [("call", "first ever", "first, compiled before", "second in the same process")]
    for name in names:
        compiling, cached, warm, results = [], [], [], set()
        for _ in range(repeats):
            with tempfile.TemporaryDirectory() as cache:
                for first_calls in (compiling, cached):
                    printed, _, _ = fresh_process(TIMED_CALL.format(work=CALLS[name]), NUMBA_CACHE_DIR=cache)
                    first, second, *result = printed.split()
                    first_calls.append(float(first))
                    warm.append(float(second))
                    results.add(tuple(result))
        if len(results) != 1:
            raise ValueError(f"{name} gave {results}: it depends on whether it was compiled just now")
        rows.append((name, *(f"{statistics.median(times):.4f}" for times in (compiling, cached, warm))))
    show(f"Calls in the lesson's maze, seconds, medians of {repeats} processes", rows)


def main(repeats=10, calls=tuple(CALLS), call_repeats=3):
    race_imports(repeats)
    time_calls(calls, call_repeats)


if __name__ == "__main__":
    main()
