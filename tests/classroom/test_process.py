"""A learner's code in a process of its own: what it may do, what ends it, and that nothing it says is believed."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

from course_lib import LESSON_GRID, Maze
from course_lib.checks.learner import Fault, Kind, Seed
from course_lib.checks.plain import Strange
from course_lib.checks.worlds import Watched
from course_lib.classroom.confine import can_confine
from course_lib.classroom.process import LearnerProcess, Limits, There
from course_lib.classroom.session import Session

if sys.platform == "win32":
    pytest.skip("the judge needs a Unix system", allow_module_level=True)

confined = pytest.mark.skipif(not can_confine(), reason="this system has no Landlock")
QUICK = Limits(time_limit=1.0)


@pytest.fixture
def process(tmp_path):
    with LearnerProcess(tmp_path, Limits(time_limit=5.0)) as running:
        yield running


def call(process, source, *arguments, time_limit=5.0):
    """Run `source`, which defines f, and call f."""
    printed, error = process.run(source)
    assert error is None, error
    return process.call("f", arguments, time_limit)


class TestCells:
    def test_names_stay_from_cell_to_cell(self, process):
        assert process.run("x = 20") == ("", None)
        assert process.run("print(x + 1)") == ("21\n", None)

    def test_an_error_is_given_in_words(self, process):
        assert process.run("print('so far')\n1 / 0")[0] == "so far\n"
        assert process.run("1 / 0")[1].startswith("ZeroDivisionError: division by zero, in line 1")

    @pytest.mark.parametrize("source", ["if (", "def f(:", "  x = 1\n y = 2", "%no_such_magic", "\0"])
    def test_nonsense_is_an_error_and_no_more(self, process, source):
        assert process.run(source)[1] is not None
        assert process.run("1 + 1")[1] is None

    def test_ipython_is_at_hand(self, process):
        assert process.run("%time x = 1\nfrom IPython.display import display\ndisplay(x)")[1] is None

    def test_leaving_is_no_end(self, process):
        assert process.run("import sys; sys.exit()")[1].startswith("SystemExit")
        assert process.run("1 + 1")[1] is None

    def test_only_the_beginning_of_prints_is_kept(self, process):
        printed, _ = process.run("for i in range(100_000): print('print')")
        assert printed.startswith("print\nprint\n")
        assert len(printed) < 20_000

    def test_reading_from_the_keyboard_does_not_wait(self, process):
        assert process.run("input()")[1].startswith("EOFError")


class TestCalls:
    def test_values_cross_as_plain_values(self, process):
        returned = call(process, "def f(x): return x, [1, 2.5], None, 'words', True", 3)
        assert returned.value == (3, (1, 2.5), None, "words", True)

    def test_arrays_cross_and_their_changes_come_back(self, process):
        table = np.arange(6.0).reshape(3, 2)
        returned = call(process, "def f(t):\n    t[0] = 9\n    return t.sum(axis=0)", table)
        np.testing.assert_array_equal(returned.arrays[0][0], [9, 9])
        np.testing.assert_array_equal(returned.value, [15, 17])
        assert table[0, 0] == 0

    def test_a_generator_is_that_of_its_seed(self, process):
        drawn = call(process, "def f(rng): return rng.random()", Seed(7)).value
        assert drawn == np.random.default_rng(7).random()

    def test_the_world_is_played_here(self, process):
        world = Watched(Maze(LESSON_GRID))
        source = "def f(maze):\n    state, info = maze.reset()\n    return [maze.step(a)[0] for a in (3, 1, 1)]"
        assert call(process, source, world).value == (1, 5, 9)
        assert world.episodes[0].states == [0, 1, 5, 9]

    def test_the_learner_is_told_of_wrong_steps(self, process):
        source = "def f(maze):\n    maze.reset()\n    maze.step('up')"
        with pytest.raises(Fault, match="an action is 0, 1, 2 or 3"):
            call(process, source, Watched(Maze(LESSON_GRID)))

    def test_a_world_ends_a_walk_without_end(self, process):
        source = "def f(maze):\n    maze.reset()\n    while True:\n        maze.step(0)"
        with pytest.raises(Fault) as caught:
            call(process, source, Watched(Maze(LESSON_GRID), time_limit=10**9, max_steps=50))
        assert caught.value.kind is Kind.STEPS_UP

    def test_a_strange_value_is_only_named(self, process):
        always = "class Yes:\n    def __eq__(self, other): return True\ndef f(): return Yes()"
        assert call(process, always).value == Strange("Yes")

    def test_a_lying_number_becomes_the_number_that_it_is(self, process):
        always = "class Yes(int):\n    def __eq__(self, other): return True\ndef f(): return Yes(3)"
        value = call(process, always).value
        assert type(value) is int
        assert value == 3

    @pytest.mark.parametrize(
        ("source", "kind"),
        [
            ("def f(): raise NotImplementedError", Kind.NOT_STARTED),
            ("def f(x): pass", Kind.SIGNATURE),
            ("f = 3", Kind.NO_FUNCTION),
            ("def f(): 1 / 0", Kind.RAISED),
            ("def f(): return undefined", Kind.RAISED),
        ],
    )
    def test_every_fault_has_its_kind(self, process, source, kind):
        with pytest.raises(Fault) as caught:
            call(process, source)
        assert caught.value.kind is kind
        assert process.alive

    def test_a_name_that_is_not_there(self, process):
        with pytest.raises(Fault, match="defines no `g`"):
            process.call("g", (), 1.0)

    def test_a_teacher_can_call_it_like_a_function(self, process):
        process.run("def f(x): return x + 1")
        assert There("f", lambda: process)(2) == 3


ENDINGS = {
    "os._exit": ("import os; os._exit(0)", Kind.DIED),
    "killing itself": ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", Kind.DIED),
    "stopping itself": ("import os, signal; os.kill(os.getpid(), signal.SIGSTOP)", Kind.TIME_UP),
    "a loop that swallows interrupts": (
        "import signal\nsignal.signal(signal.SIGALRM, signal.SIG_IGN)\nwhile True: pass",
        Kind.TIME_UP,
    ),
    "a flood past Python's prints": ("import os\nwhile True: os.write(1, b'x' * 1_000_000)", Kind.DIED),
    "a flood from a program": ("import subprocess\nsubprocess.run(['yes'])", Kind.DIED),
    "words on the judge's line": (
        "import os\nfor number in range(3, 50):\n    try: os.write(number, b'nonsense\\n')\n    except OSError: pass",
        Kind.DIED,
    ),
    "the judge's line closed": ("import os; os.closerange(3, 100)", Kind.DIED),
    "a crash": ("import ctypes; ctypes.string_at(0)", Kind.DIED),
}


@pytest.mark.parametrize(("source", "kind"), ENDINGS.values(), ids=ENDINGS)
def test_what_ends_a_process_ends_in_time(tmp_path, source, kind):
    with LearnerProcess(tmp_path, QUICK) as process:
        began = time.monotonic()
        with pytest.raises(Fault) as caught:
            process.run(source)
        assert caught.value.kind is kind
        assert not process.alive
        assert time.monotonic() - began < 20  # not for ever; how fast is not the point


def test_a_call_that_was_stopped_leaves_no_answer_behind(tmp_path):
    source = "def walk(maze):\n    maze.reset()\n    while True: maze.step(0)\ndef add(x): return x + 1"
    with Session(tmp_path, QUICK) as session:
        session.run(source)
        for _ in range(5):
            world = Watched(Maze(LESSON_GRID), time_limit=10**9, max_steps=10**9)
            with pytest.raises(Fault) as caught:
                There("walk", session.process).call(world, time_limit=0.05)
            assert caught.value.kind is Kind.TIME_UP
            assert There("add", session.process)(1) == 2


def test_a_program_left_behind_holds_nothing_up(tmp_path):
    source = (
        "import os, time\n"
        "if os.fork() == 0:\n    os.setsid()\n    if os.fork() == 0: time.sleep(8)\n    os._exit(0)\n"
        "os._exit(0)"
    )
    with LearnerProcess(tmp_path, QUICK) as process:
        with pytest.raises(Fault):
            process.run(source)
        assert not process.alive


def test_memory_has_a_limit(tmp_path):
    with LearnerProcess(tmp_path, Limits(time_limit=20.0, memory_limit=1_500_000_000)) as process:
        assert process.run("hog = bytearray(2_000_000_000)")[1].startswith("MemoryError")
        assert process.run("hog = []\nwhile True: hog.append(bytearray(100_000_000))")[1].startswith("MemoryError")


def test_a_process_that_does_not_start_is_nobodys_fault(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", shutil.which("false"))
    with pytest.raises(RuntimeError, match="did not start"):
        LearnerProcess(tmp_path, QUICK)


def test_files_have_a_limit(tmp_path):
    with LearnerProcess(tmp_path, Limits(time_limit=5.0, file_limit=1_000_000)) as process:
        assert process.run("open('large', 'wb').write(bytes(2_000_000))")[1].startswith("OSError")


def test_a_slow_cell_is_stopped_and_the_process_lives(tmp_path):
    with LearnerProcess(tmp_path, QUICK) as process:
        assert process.run("x = 1\nwhile True: pass")[1].startswith("TimeIsUp")
        assert process.run("print(x)") == ("1\n", None)


def test_it_knows_nothing_of_the_teacher(tmp_path, monkeypatch):
    monkeypatch.setenv("SECRET_OF_THE_TEACHER", "1")
    with LearnerProcess(tmp_path, QUICK) as process:
        assert process.run("import os; print(os.environ.get('SECRET_OF_THE_TEACHER'))") == ("None\n", None)


def test_a_package_of_the_same_name_is_not_ours(tmp_path):
    (tmp_path / "course_lib").mkdir()
    (tmp_path / "course_lib" / "__init__.py").write_text("raise SystemExit('a fake')")
    with LearnerProcess(tmp_path, QUICK) as process:
        printed, error = process.run(
            "import sys; sys.path.insert(0, '.')\nimport course_lib; print(course_lib.__file__)"
        )
        assert error is None
        assert not printed.startswith(str(tmp_path))


@confined
class TestConfined:
    def test_it_writes_in_its_folder(self, process, tmp_path):
        assert process.run("open('mine.txt', 'w').write('mine')")[1] is None
        assert (tmp_path / "mine.txt").read_text() == "mine"

    @pytest.mark.parametrize(
        "deed",
        ["open(path, 'w')", "open(path).read()", "os.remove(path)", "os.rename(path, 'x')", "os.link(path, 'x')"],
    )
    def test_it_reaches_no_other_file(self, process, tmp_path_factory, deed):
        other = tmp_path_factory.mktemp("other") / "file"
        other.write_text("another's")
        assert "Error" in process.run(f"import os; path = {str(other)!r}; {deed}")[1]
        assert other.read_text() == "another's"

    def test_neither_do_its_children(self, process, tmp_path_factory):
        other = tmp_path_factory.mktemp("other") / "file"
        process.run(f"import subprocess; subprocess.run('echo x > {other}', shell=True)")
        assert not other.exists()

    def test_it_lists_no_other_folder(self, process, tmp_path_factory):
        folder = tmp_path_factory.mktemp("other")
        assert process.run(f"import os; os.listdir({str(folder)!r})")[1].startswith("PermissionError")

    def test_it_signals_nobody_outside(self, process):
        with subprocess.Popen(["sleep", "30"]) as bystander:
            try:
                error = process.run(f"import os; os.kill({bystander.pid}, 15)")[1]
                alive = bystander.poll() is None
            finally:
                bystander.send_signal(signal.SIGKILL)
        assert alive
        assert error.startswith("PermissionError")

    def test_it_opens_no_connection(self, process):
        with socket.create_server(("127.0.0.1", 0)) as server:
            address = server.getsockname()
            error = process.run(f"import socket; socket.create_connection({address!r}, timeout=2)")[1]
        assert error.startswith("PermissionError")

    def test_it_does_not_read_our_environment(self, process):
        assert process.run(f"open('/proc/{os.getpid()}/environ').read()")[1].startswith("PermissionError")

    def test_what_learners_need_can_be_imported(self, process):
        source = "import numpy, gymnasium, matplotlib.pyplot, course_lib.q_table\nmatplotlib.pyplot.plot([1, 2])"
        assert process.run(source)[1] is None


class TestSession:
    def test_the_cells_after_a_fatal_one_go_on(self, tmp_path):
        with Session(tmp_path, QUICK) as session:
            assert session.run("x = 1") == ("", None)
            assert session.run("import os; os._exit(1)")[1].startswith("died")
            assert session.run("print(x)") == ("1\n", None)

    def test_a_fatal_cell_is_not_run_again(self, tmp_path):
        with Session(tmp_path, QUICK) as session:
            session.run("open('runs', 'a').write('.')\nimport os; os._exit(1)")
            session.run("1")
            assert session.run("print(open('runs').read())") == (".\n", None)

    def test_a_fatal_call_leaves_the_rest(self, tmp_path):
        with Session(tmp_path, QUICK) as session:
            session.run("def f():\n    import os; os._exit(1)\ndef g(): return 2")
            with pytest.raises(Fault):
                There("f", session.process)()
            assert There("g", session.process)() == 2

    def test_a_submission_has_only_so_much_time(self, tmp_path):
        with Session(tmp_path, QUICK, total_time_limit=2.0) as session:
            killer = "import os, signal; os.kill(os.getpid(), signal.SIGSTOP)"
            assert session.run(killer)[1].startswith("time up")
            assert "used up its time" in session.run("1 + 1")[1]
            with pytest.raises(Fault, match="used up its time"):
                There("f", session.process)()

    def test_the_submission_is_copied_not_touched(self, tmp_path):
        (tmp_path / "data.csv").write_text("1,2")
        with Session(tmp_path, QUICK) as session:
            assert session.run("print(open('data.csv').read()); _ = open('data.csv', 'w')") == ("1,2\n", None)
        assert (tmp_path / "data.csv").read_text() == "1,2"
