"""A teacher and a class on a hub: what they hand in, what it is worth, and all that they do, in its order."""

import os
import secrets
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import nbformat

from course_lib.classroom.confine import can_confine

from . import hub, machine
from .mischief import MISCHIEF

REPOSITORY = Path(__file__).parents[2]
SHARED, CLASS = Path("/srv/course"), Path("/home/teacher/demo")
INBOUND = SHARED / "exchange" / "demo" / "inbound"
SMALL, REAL = "small", "homework_1"
NAMES = {SMALL: "small.ipynb", REAL: "04_homework_1.ipynb"}
# Nothing but the hidden test knows this number.
SECRET = str(secrets.randbelow(10**12))

RIGHT = "def double(number):\n    return 2 * number"
READS = f"""
import glob
from pathlib import Path
seen = []
for path in ["{CLASS}/gradebook.db", *glob.glob("{CLASS}/source/*/*"), *glob.glob("{CLASS}/submitted/*/*/*")]:
    try:
        seen.append(Path(path).read_bytes())
    except OSError:
        pass
def double(number):
    return 2 * number if seen else 0
"""
# What learners hand in, and the points that it is worth. Half of the class is right.
ANSWERS = {
    "right": (RIGHT, 4),
    "nearly": ("def double(number):\n    return {2: 4, 3: 6}.get(number)", 2),
    "nothing": (None, 0),
    "exits": ("import os\ndef double(number):\n    os._exit(0)", 0),
    "reads": (READS, 0 if can_confine() else 4),
    "endless": ("def double(number):\n    while True: pass", 0),
}
WRONG = ["nearly", "endless", "exits", "reads", "nothing"]
# Two do homework 1 as well; the second has one of the wrong answers of tests/answers for its first task.
REAL_ANSWERS = {"learner-00": None, "learner-01": "bumps_not_counted.py"}
KILLED, MISCHIEVOUS, LINKING = "learner-02", "learner-03", "learner-04"

SMALL_HOMEWORK = f"""
task_1 = (double(2) == 4) + (double(3) == 6)
task_1
### BEGIN HIDDEN TESTS
task_1 += 2 * (double({SECRET}) == {2 * int(SECRET)})
### END HIDDEN TESTS
task_1
"""


@dataclass
class School:
    """The class once all is done, with what was noticed on the way."""

    hub: hub.Hub
    learners: dict
    kinds: dict
    seen: dict = field(default_factory=dict)
    seconds: dict = field(default_factory=dict)

    def teacher(self, *arguments):
        """What `python -m course_lib.classroom` prints to the teacher, in the folder of the class."""
        return as_teacher("-m", "course_lib.classroom", *arguments, cwd=CLASS)

    def teacher_for_all(self, command, *arguments):
        """The same for all homeworks, in one process, which saves its start."""
        code = "import sys\nfrom course_lib.classroom.__main__ import main\n"
        lines = [f"if main({[command, homework, *arguments]!r}): sys.exit('failed')" for homework in NAMES]
        return as_teacher("-c", code + "\n".join(lines), cwd=CLASS)

    @contextmanager
    def timed(self, name):
        start = time.monotonic()
        yield
        self.seconds[name] = time.monotonic() - start

    def together(self, action, learners=None):
        """{name: what `action` gives}, for eight learners at a time."""
        learners = list(self.learners.values()) if learners is None else learners
        with ThreadPoolExecutor(8) as pool:
            return dict(zip([one.name for one in learners], pool.map(action, learners), strict=True))


def as_teacher(*arguments, cwd="/home/teacher"):
    """What Python prints that the teacher runs, whose new files no other account may read."""
    own = {"HOME": "/home/teacher", "USER": "teacher", "LOGNAME": "teacher"}
    command = ["runuser", "-u", "teacher", "--", sys.executable, *arguments]
    done = subprocess.run(command, cwd=cwd, env=os.environ | own, umask=0o077, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    return done.stdout + done.stderr


def make_class():
    """The folder of the class, with the small homework and homework 1 of the course."""
    from nbformat.v4 import new_code_cell, new_notebook

    def tag(name, **flags):
        kind = {"schema_version": 3, "grade_id": name, "grade": False, "solution": False, "locked": False}
        return {"nbgrader": kind | {"task": False} | flags}

    solution = RIGHT.replace("    return", "    ### BEGIN SOLUTION\n    return") + "\n    ### END SOLUTION"
    cells = [
        new_code_cell(solution, metadata=tag("double", solution=True)),
        new_code_cell(SMALL_HOMEWORK.strip(), metadata=tag("task_1", grade=True, locked=True, points=4)),
    ]
    kernel = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
    home = CLASS.parent
    nbformat.write(new_notebook(cells=cells, metadata={"kernelspec": kernel}), home / NAMES[SMALL])
    shutil.copy(REPOSITORY / "notebooks" / "solutions" / NAMES[REAL], home)
    for name in NAMES.values():
        shutil.chown(home / name, "teacher")
        (home / name).chmod(0o600)
    homeworks = {homework: str(home / name) for homework, name in NAMES.items()}
    as_teacher(
        "-c",
        "from course_lib.classroom.course import Course\n"
        f"Course.new({str(CLASS)!r}, {homeworks!r}, exchange={str(SHARED / 'exchange')!r})\n"
        f"open('{CLASS}/nbgrader_config.py', 'a').write('c.JudgePreprocessor.time_limit = 8.0')",
    )


def answer(learner, homework, answers):
    """Fetch a homework, write the `answers` {grade_id: source} into it, and save it."""
    learner.act("fetch", "demo", homework)
    path = f"{homework}/{NAMES[homework]}"
    notebook = learner.read(path)
    for cell in notebook["cells"]:
        name = cell["metadata"].get("nbgrader", {}).get("grade_id")
        if answers.get(name) is not None:
            cell["source"] = answers[name]
    learner.save(path, notebook)


def real_answers(wrong):
    """The author's answers to homework 1, with the first one replaced by that of a file where one is named."""
    source = nbformat.read(REPOSITORY / "notebooks" / "solutions" / NAMES[REAL], as_version=4)
    cells = {cell.metadata.get("nbgrader", {}).get("grade_id"): cell.source for cell in source.cells}
    answers = {name: cells[name] for name in ("task_1", "task_2", "task_3")}
    if wrong:
        path = REPOSITORY / "tests" / "answers" / "homework_1" / "wrong" / wrong
        answers["task_1"] = path.read_text(encoding="utf-8")
    return answers


@contextmanager
def in_class(size):
    """A class of that many, through all of its homework."""
    with machine.own_machine(*programs()):
        subprocess.run(["groupadd", "course"], check=True)
        machine.account("teacher")
        names = [f"learner-{number:02}" for number in range(size)]
        for name in names:
            machine.account(name, groups=["course"], password=f"word of {name}")
        with hub.running_hub(SHARED) as running:
            learners = {name: running.learner(name) for name in names}
            kinds = {name: "right" if i % 2 == 0 else WRONG[i // 2 % len(WRONG)] for i, name in enumerate(names)}
            school = School(running, learners, kinds)
            take_part(school)
            yield school


def programs():
    """Where the proxy and the program that runs it lie."""
    proxy, node = Path(shutil.which("configurable-http-proxy")), Path(shutil.which("node"))
    return {str(path) for path in (proxy.parent, proxy.resolve().parents[2], node.parent, node.resolve().parents[1])}


def take_part(school):
    """Release, fetch, answer, submit, collect, grade, give back; with a server killed, and mischief, in between."""
    make_class()
    school.teacher_for_all("release", "--exchange")
    learners = school.learners
    with school.timed("start the servers"):
        school.together(lambda learner: learner.start())
    school.seen["servers"] = school.hub.servers()
    with school.timed("fetch and answer"):
        school.together(
            lambda learner: answer(learner, SMALL, {"double": ANSWERS[school.kinds[learner.name]][0]}),
        )
    kill_a_server(school)
    with school.timed("submit"):
        school.together(
            lambda learner: learner.act("submit", "demo", SMALL),
            [learners[name] for name in learners if name != LINKING],
        )
    for name, wrong in REAL_ANSWERS.items():
        answer(learners[name], REAL, real_answers(wrong))
        learners[name].act("submit", "demo", REAL)
    for name, code in MISCHIEF.items():
        learners[{"links": LINKING}.get(name, MISCHIEVOUS)].run(code)
    with school.timed("collect"):
        school.seen["collected"] = school.teacher_for_all("collect")
    for homework in NAMES:
        with school.timed(f"grade {homework}"):
            school.seen[f"grades of {homework}"] = school.teacher("autograde", homework)
    with school.timed("feedback"):
        school.seen["given back"] = school.teacher_for_all("feedback", "--exchange")
    with school.timed("fetch feedback"):
        school.together(lambda learner: learner.act("fetch_feedback", "demo", SMALL))
    for name in REAL_ANSWERS:
        learners[name].act("fetch_feedback", "demo", REAL)
    school.teacher("grades", "--csv", "grades.csv")


def kill_a_server(school):
    """A server ends from one moment to the next, after its learner has saved and before they submit."""
    killed, other = school.learners[KILLED], school.learners[MISCHIEVOUS]
    path = f"{SMALL}/{NAMES[SMALL]}"
    before = killed.read(path)
    os.kill(killed.server_process(), signal.SIGKILL)
    dead = []
    hub.wait_until(
        lambda: dead.append(killed.ask("GET", f"api/contents/{path}").status_code) or dead[-1] != 200,
        30,
        lambda: f"{dead}",
    )
    school.seen["while it was dead"] = dead[-1], other.read(path)
    killed.start()
    school.seen["saved before and after"] = before, killed.read(path)
