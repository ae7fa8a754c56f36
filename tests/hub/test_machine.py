"""The machine of the tests' own: nothing of it is left, whatever happens in it."""

import os
import pwd
import subprocess
import sys

import pytest

from . import machine


def fail_in_the_middle(left):
    with machine.own_machine():
        machine.account("somebody-of-the-tests", password="a word")
        assert os.listdir("/home") == ["somebody-of-the-tests"]
        left.append(subprocess.Popen(["sleep", "1000"], start_new_session=True))
        left.append(subprocess.Popen(["runuser", "-u", "somebody-of-the-tests", "--", "sleep", "1000"]))
        raise RuntimeError("in the middle")


def test_after_a_failure_nothing_is_left(ready):  # noqa: ARG001 (it decides whether to skip)
    left, homes, home = [], os.listdir("/home"), os.listdir(os.path.expanduser("~"))
    with pytest.raises(RuntimeError, match="in the middle"):
        fail_in_the_middle(left)
    assert [process.wait(10) for process in left] == [-9, -9]
    assert (os.listdir("/home"), os.listdir(os.path.expanduser("~"))) == (homes, home)
    with pytest.raises(KeyError):
        pwd.getpwnam("somebody-of-the-tests")


def test_accounts_can_run_what_the_tests_run(ready):  # noqa: ARG001
    with machine.own_machine():
        machine.account("somebody-of-the-tests")
        command = [
            "runuser",
            "-u",
            "somebody-of-the-tests",
            "--",
            sys.executable,
            "-c",
            "import course_lib, jupyterhub",
        ]
        assert subprocess.run(command, cwd="/").returncode == 0


def test_one_in_another_has_nothing_of_it(ready):  # noqa: ARG001
    folder = os.getcwd()
    with machine.own_machine():
        machine.account("of-the-first")
        first = pwd.getpwnam("of-the-first").pw_uid
        with machine.own_machine():
            assert os.listdir("/home") == []
            machine.account("of-the-second")
            assert pwd.getpwnam("of-the-second").pw_uid != first
        assert os.listdir("/home") == ["of-the-first"]
        assert os.getcwd() == folder
    assert os.getcwd() == folder
