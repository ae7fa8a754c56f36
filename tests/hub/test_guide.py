"""The teacher's guide, tried by a new teacher: every command as it is printed, on a machine where nobody has been."""

import os
import re
import shutil
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from nbformat import read, write

from . import machine
from .hub import Visitor, free_ports, stop, wait_until
from .school import REAL, REPOSITORY, programs, real_answers

GUIDE = REPOSITORY / "course_lib" / "classroom" / "GUIDE.md"
NOTEBOOK = "homework_1/04_homework_1.ipynb"
BIN = Path(sys.executable).parent


def blocks():
    """{name: commands} of the guide; blocks of one name are parts of one thing."""
    found = {}
    for name, commands in re.findall(r"^```sh([^\n]*)\n(.*?)^```", GUIDE.read_text(encoding="utf-8"), re.M | re.S):
        found.setdefault(name.strip(), []).append(commands)
    return found


def shell(commands, account, folder):
    """What the commands print; they run in the environment that the guide has made, and end at the first error."""
    home = {"HOME": f"/home/{account}", "USER": account, "PATH": f"{BIN}:{os.environ['PATH']}"}
    start = [] if account == "root" else ["runuser", "-u", account, "--"]
    done = subprocess.run(
        [*start, "bash", "-euo", "pipefail", "-c", commands],
        cwd=folder,
        env=os.environ | (home if account != "root" else {"PATH": home["PATH"]}),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def answered(notebook):
    for cell in notebook["cells"]:
        name = cell["metadata"].get("nbgrader", {}).get("grade_id")
        cell["source"] = real_answers(None).get(name, cell["source"])
    return notebook


def copy_of_the_repository(folder):
    """As a teacher has it, but for what lessons and tests are about."""
    for name in ("course_lib", "notebooks"):
        shutil.copytree(REPOSITORY / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@contextmanager
def started(commands):
    """The hub, on ports that are free here."""
    settings = Path(commands.split()[-1])
    port, hub_port, proxy_port = free_ports(3)
    with settings.open("a") as file:
        file.write(f"c.JupyterHub.bind_url = 'http://127.0.0.1:{port}'\nc.JupyterHub.hub_port = {hub_port}\n")
        file.write(f"c.ConfigurableHTTPProxy.api_url = 'http://127.0.0.1:{proxy_port}'\n")
    with (settings.parent / "state" / "log").open("wb") as log:
        environment = os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"}
        process = subprocess.Popen(["bash", "-c", f"exec {commands}"], env=environment, stdout=log, stderr=log)
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        stop(process)


@pytest.fixture(scope="module")
def guide():
    return blocks()


def test_every_block_is_tried(guide):
    tried = {"folders", "root", "start", "teacher", "learner", "grading", "fetching", "seed", "links"}
    assert set(guide) - tried == {"", "install"} & set(guide), "but for installing, which CI does"
    assert tried <= set(guide)


def test_homework_as_files(guide, ready, tmp_path):  # noqa: ARG001 (it decides whether to skip)
    with machine.own_machine(*programs()):
        copy = copy_of_the_repository(tmp_path / "repository")
        shell(guide["folders"][0], "root", copy)
        folder = tmp_path / "my_class"
        shell(guide["seed"][0] + "python -m course_lib.classroom release homework_1", "root", folder)
        for source in (folder / "source").rglob("*.ipynb"):
            assert "seed=4711" in source.read_text()
            assert "1989" not in source.read_text()
        released = read(folder / "release" / NOTEBOOK, as_version=4)
        place = folder / "submitted" / "ann" / NOTEBOOK
        place.parent.mkdir(parents=True)
        write(answered(released), place)
        (folder / "roster.csv").write_text("learner\nann\nben\n")
        said = shell(guide["folders"][1], "root", folder)
        assert re.search(r"ann +homework_1 +17 of 17\n", said)
        assert re.search(r"ben +homework_1 +0 of 17 +Nothing handed in\.\n", said)
        assert (folder / "feedback" / "ann" / REAL / "04_homework_1.html").is_file()
        assert (folder / "grades.csv").is_file()


def test_a_class_on_the_hub(guide, ready):  # noqa: ARG001 (it decides whether to skip)
    with machine.own_machine(*programs()):
        for commands in guide["root"]:
            shell(commands, "root", REPOSITORY)
        with started(guide["start"][0]) as address:
            teachers = copy_of_the_repository(Path("/home/teacher/course"))
            shell(guide["teacher"][0], "teacher", teachers)
            wait_until(lambda: Visitor.answers(address), 60, Path("/srv/course/state/log").read_text)
            ann, ben = (Visitor(address, name, f"a-word-for-{name}") for name in ("ann", "ben"))
            for learner in (ann, ben):
                learner.start()
            fetch, submit = guide["learner"][0].splitlines()
            ann.run_in_terminal(fetch)
            ann.save(NOTEBOOK, answered(ann.read(NOTEBOOK)))
            ann.run_in_terminal(submit)
            ben.act("fetch", "my_class", REAL)
            ben.act("submit", "my_class", REAL)
            said = shell(guide["grading"][0], "teacher", "/home/teacher")
            assert "new work of ann, ben\n" in said
            assert re.search(r"ann +homework_1 +17 of 17\n", said)
            assert re.search(r"ben +homework_1 +0 of 17\n", said)
            assert "given back to 2 of 2\n" in said
            ann.run_in_terminal(guide["fetching"][0])
            ben.act("fetch_feedback", "my_class", REAL)
            for learner, score in ((ann, "17.0"), (ben, "0.0")):
                (taken,) = learner.read(f"{REAL}/feedback")
                assert f"(Score: {score} / 17.0)" in learner.read(f"{taken['path']}/04_homework_1.html")
            # A server that hears nothing any more does not keep the hub from its end.
            os.kill(ben.server_process(), signal.SIGSTOP)


def test_links(guide):
    said = subprocess.run(
        ["bash", "-ec", guide["links"][0].replace("REPOSITORY", "REPOSITORY --commit v1")],
        cwd=REPOSITORY,
        env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
    ).stdout
    assert "git+https://github.com/OWNER/REPOSITORY@v1" in said
