"""Calls of a learner's function: a value, or a fault in words, and everything else as it was before."""

import contextlib
import functools
import io
import sys
import threading

import numpy as np
import pytest

from course_lib import Maze, QAgent
from course_lib.checks.here import Here, Prints, words_for
from course_lib.checks.learner import Fault, Kind, Seed
from course_lib.checks.plain import Strange
from course_lib.checks.worlds import Watched


def call(function, *arguments, time_limit=5.0):
    return Here(function).call(*arguments, time_limit=time_limit)


def fault_of(function, *arguments, time_limit=5.0):
    with pytest.raises(Fault) as caught:
        call(function, *arguments, time_limit=time_limit)
    return caught.value


def on_another_thread(work):
    """What `work()` returns when it is done by another thread than the main one."""
    done, failed = [], []

    def keep():
        try:
            done.append(work())
        except BaseException as error:
            failed.append(error)

    thread = threading.Thread(target=keep)
    thread.start()
    thread.join()
    assert not failed, failed
    return done[0]


everywhere = pytest.mark.parametrize("on", [lambda work: work(), on_another_thread], ids=["main", "other thread"])


# --- values -----------------------------------------------------------------------------------------------------------


@everywhere
def test_a_value_is_plain_and_arrays_are_seen_as_they_are_after_the_call(on):
    def learn(table, factor, rng):
        table[0] = factor
        return {"not": "plain"}, rng.integers(1000), table

    table = np.zeros(3)
    returned = on(lambda: call(learn, table, 2.0, Seed(7)))
    expected = np.array([2.0, 0.0, 0.0])
    assert returned.value[:2] == (Strange("dict"), np.random.default_rng(7).integers(1000))
    np.testing.assert_array_equal(returned.value[2], expected)
    np.testing.assert_array_equal(returned.arrays[0], expected)
    assert not table.any(), "the caller's own array is never passed on"
    assert not np.shares_memory(returned.value[2], returned.arrays[0])


def test_each_call_gets_arrays_and_a_generator_of_its_own():
    kept = []

    def keep(table, rng):
        kept.append(table)
        return rng.random()

    table = np.zeros(3)
    first, second = call(keep, table, Seed(1)), call(keep, table, Seed(1))
    assert first.value == second.value
    assert not np.shares_memory(*kept)
    kept[0][:] = 5
    assert not first.arrays[0].any(), "what was returned cannot be changed later"


def test_a_maze_is_a_world_without_a_map():
    judge = Watched(Maze())

    def play(maze):
        assert not isinstance(maze, (Maze, Watched))
        maze.reset()
        return maze.step(0)[0]

    assert call(play, judge).value == 0
    assert judge.steps == 1


class Callable:
    def __call__(self, number):
        return number + 1


class Silent:
    def __getattr__(self, name):
        raise RuntimeError("it says nothing")

    def __call__(self, number):
        return number + 1


def test_whatever_can_be_called_is_a_function():
    functions = [
        (lambda number: number + 1, "<lambda>"),
        (Callable(), "Callable"),
        (Callable().__call__, "__call__"),
        (functools.partial(lambda a, b: a + b, 1), "partial"),
        (functools.lru_cache(lambda number: number + 1), "<lambda>"),
        (np.frompyfunc(lambda number: number + 1, 1, 1), "<lambda> (vectorized)"),
        ((1).__add__, "__add__"),
        (Silent(), "Silent"),
    ]
    for function, name in functions:
        assert Here(function).name == name
        assert call(function, 2).value == 3


# --- faults -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("thing", [None, 12, "play", np.zeros(3), [print]], ids=str)
def test_what_is_no_function(thing):
    fault = fault_of(thing, 1)
    assert fault.kind is Kind.NO_FUNCTION
    assert str(fault).startswith("not a function, but ")


class Unfinished:
    def __call__(self, maze):
        raise NotImplementedError


def not_started(maze):
    raise NotImplementedError  # your code here


def left_over(maze):
    maze.reset()
    raise NotImplementedError


def another():
    raise NotImplementedError


def calls_another(maze):
    maze.reset()
    return another()


def test_what_is_not_written():
    maze = Watched(Maze())
    assert fault_of(not_started, maze).kind is Kind.NOT_STARTED
    assert fault_of(Unfinished(), maze).kind is Kind.NOT_STARTED
    assert fault_of(left_over, maze).kind is Kind.LEFT_OVER
    fault = fault_of(calls_another, maze)
    assert fault.kind is Kind.RAISED
    assert str(fault) == "`another`, which your code calls, is not written yet: it raises NotImplementedError"


@pytest.mark.parametrize(
    "function", [lambda: 1, lambda a: a, lambda a, b, c: a + b + c, lambda a, b, *, c: a + b + c, len]
)
def test_another_signature(function):
    fault = fault_of(function, 1, 2)
    assert fault.kind is Kind.SIGNATURE
    assert "cannot take 2 arguments" in str(fault)


def test_a_signature_that_cannot_be_shown_is_let_pass():
    class Odd:
        @property
        def __signature__(self):
            raise RuntimeError

        def __call__(self, a):
            return a

    class Unspeakable:
        def __repr__(self):
            raise RuntimeError

    unspeakable = Unspeakable()
    assert call(Odd(), 4).value == 4
    assert call(lambda a, b=unspeakable: (a, b), 4).value == (4, Strange("Unspeakable"))
    assert len(str(fault_of(lambda a=list(range(10_000)): a, 1, 2))) < 300


class Wordless(Exception):
    def __str__(self):
        raise ValueError


class Wordy(str):
    def __getitem__(self, key):
        raise AssertionError("a string of the learner's was asked")


class Strung(Exception):
    def __str__(self):
        return Wordy("its words")


def raises(error):
    def function():
        raise error

    return function


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ValueError("no such cell"), "ValueError: no such cell, in line"),
        (ValueError(), "ValueError, in line"),
        (Wordless(), "Wordless, in line"),
        (Strung(), "Strung: its words, in line"),
        (SystemExit(3), "SystemExit: 3, in line"),
        (GeneratorExit(), "GeneratorExit, in line"),
        (BaseException("any"), "BaseException: any, in line"),
        (ExceptionGroup("two", [ValueError(), TypeError()]), "ExceptionGroup: two (2 sub-exceptions), in line"),
        (ValueError("x" * 10_000), "ValueError: " + "x" * 300 + ", in line"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_an_error_is_told_in_words_with_the_line(error, words):
    fault = fault_of(raises(error))
    assert fault.kind is Kind.RAISED
    assert str(fault).startswith(words)
    assert str(fault).endswith(": `raise error`")


def test_the_line_is_the_last_of_the_learners_own():
    def play(maze, rng):
        maze.reset()
        return rng.choice([])

    def calls(maze, rng):
        return play(maze, rng)

    fault = str(fault_of(play, Watched(Maze()), Seed(0)))
    assert fault.endswith(" of `play`: `return rng.choice([])`")
    assert "called from" not in fault
    fault = str(fault_of(calls, Watched(Maze()), Seed(0)))
    assert " of `play`: `return rng.choice([])`; called from line " in fault
    assert fault.endswith(" of `calls`: `return play(maze, rng)`")
    assert str(fault_of(lambda maze: maze.step("up"), Watched(Maze()))).startswith(
        "ValueError: an action is 0, 1, 2 or 3"
    )


def test_code_without_a_file_is_told_by_its_line():
    names = {}
    exec("def play():\n    return [][1]\n", names)
    assert str(fault_of(names["play"])) == "IndexError: list index out of range, in line 2 of `play`"


def test_an_error_raised_by_nobodys_line():
    assert words_for(KeyError("a")) == "KeyError: 'a'"


def test_recursion_without_end():
    def again(number):
        return again(number + 1)

    assert str(fault_of(again, 0)).startswith("RecursionError: maximum recursion depth")


def test_an_interrupt_stops_the_call_and_not_the_notebook():
    assert fault_of(raises(KeyboardInterrupt())).kind is Kind.INTERRUPTED


def generator(number):
    yield number


async def coroutine(number):
    return number


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("function", "word"), [(generator, "yield"), (coroutine, "async")])
def test_what_does_not_run_when_it_is_called(function, word):
    fault = fault_of(function, 1)
    assert fault.kind is Kind.RAISED
    assert f"that is what `{word}` does" in str(fault)


def test_a_walk_that_does_not_stop():
    def walk(maze):
        maze.reset()
        while True:
            with contextlib.suppress(Exception):
                maze.step(0)

    fault = fault_of(walk, Watched(Maze(), time_limit=10**9, max_steps=100))
    assert fault.kind is Kind.STEPS_UP


# --- prints -----------------------------------------------------------------------------------------------------------


def test_prints_are_kept_and_the_streams_put_back():
    def talk():
        print("hello", flush=True)
        print("a mistake", file=sys.stderr)
        sys.stdout.write("no end of line")
        return sys.stdout.isatty()

    streams = sys.stdout, sys.stderr
    learner = Here(talk)
    assert learner.call(time_limit=5).value is False
    assert (sys.stdout, sys.stderr) == streams
    assert learner.printed == "hello\na mistake\nno end of line"


def test_streams_are_put_back_after_a_fault_too():
    def lose():
        sys.stdout = io.StringIO()
        raise ValueError

    streams = sys.stdout, sys.stderr
    fault_of(lose)
    assert (sys.stdout, sys.stderr) == streams


def test_of_a_flood_the_beginning_is_kept():
    def flood(lines):
        for number in range(lines):
            print(f"line {number}")

    learner = Here(flood)
    learner.call(100_000, time_limit=30)
    assert learner.printed.startswith("line 0\nline 1\n")
    assert learner.printed.endswith(" … and 1,086,890 characters more")
    assert len(learner.printed) < 2100


def test_what_stands_in_for_stdout_takes_text_only():
    prints = Prints()
    print("a", 1, file=prints)
    with pytest.raises(TypeError, match="takes text, got bytes"):
        prints.write(b"a")
    prints.writelines(["b", "\ud800"])
    assert prints.kept == "a 1\nb?"
    assert prints.writable()


def test_the_courses_own_classes_run_as_ever():
    def train(maze):
        return QAgent(maze).train(2).episode_length

    assert len(call(train, Watched(Maze())).value) == 2
