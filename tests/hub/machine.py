"""A machine of the tests' own: accounts, homes and /srv of which nothing is left, and nothing seen, outside.

A mount namespace (https://man7.org/linux/man-pages/man7/mount_namespaces.7.html), which root alone may make.
"""

import ctypes
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from functools import cache
from itertools import count
from pathlib import Path

import course_lib

_NEW_MOUNTS = 0x00020000  # CLONE_NEWNS
_OWN_FOLDER = 0x00000200  # CLONE_FS; a thread that shares its working folder with others cannot go elsewhere
_OURS = "/proc/thread-self/ns/mnt"
_MACHINES = count()


def why_not():
    """What keeps this machine from having another one in it; empty where nothing does."""
    if sys.platform != "linux" or os.geteuid() != 0:
        return "accounts for learners can be made by root on Linux only"
    for program in ("unshare", "useradd", "groupadd", "chpasswd", "runuser"):
        if not shutil.which(program):
            return f"needs {program}"
    tried = subprocess.run(["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/srv"], capture_output=True)
    return "" if tried.returncode == 0 else "root may make no mount namespace here (in a container without rights?)"


@contextmanager
def own_machine(*programs):
    """This thread, and what it starts, sees a copy of /etc, and empty /home and /srv; `programs` stay where they are.

    Whatever runs in it is killed in the end. One that is made in another has nothing of it.
    """
    outside, before = _outside(), os.open(_OURS, os.O_RDONLY)
    _checked(_libc().unshare(_OWN_FOLDER))
    _enter(outside)
    stash = tempfile.mkdtemp(prefix="machine-")
    umask = os.umask(0o022)
    _checked(_libc().unshare(_NEW_MOUNTS))
    try:
        _mount("--make-rprivate", "/")
        _mount("-t", "tmpfs", "-o", "mode=711", "tmpfs", stash)
        shutil.copytree("/etc", f"{stash}/etc", symlinks=True)
        _own_numbers(Path(stash, "etc", "login.defs"))
        _mount("--bind", f"{stash}/etc", "/etc")
        needed = {sys.prefix, sys.base_prefix, *_open_parts(Path(course_lib.__file__).parents[1]), *programs}
        _empty({"/home", "/srv", *_closed(needed)}, needed, f"{stash}/kept")
        yield
    finally:
        os.umask(umask)
        _end_all_in(os.readlink(_OURS))
        _enter(before)
        os.close(before)
        os.rmdir(stash)


@cache
def _libc():
    return ctypes.CDLL(None, use_errno=True)


@cache
def _outside():
    """What is mounted where no machine has been made yet."""
    return os.open(_OURS, os.O_RDONLY)


def _enter(mounts):
    """See these mounts, in the same folder: the kernel goes to / otherwise."""
    folder = os.getcwd()
    _checked(_libc().setns(mounts, _NEW_MOUNTS))
    os.chdir(folder)


def account(name, *, groups=(), password=None):
    """Make an account with a home as the machine makes them."""
    subprocess.run(["useradd", "--create-home", "--shell", "/bin/bash", "--groups", ",".join(groups), name], check=True)
    if password:
        subprocess.run(["chpasswd"], input=f"{name}:{password}", text=True, check=True)


def _own_numbers(settings):
    """User ids that no other machine of the tests has: processes and ports are seen across all of them."""
    first = 100_000 + os.getpid() % 1000 * 1000 + next(_MACHINES) % 10 * 100
    with settings.open("a") as file:
        file.writelines(f"\n{kind}_MIN {first}\n{kind}_MAX {first + 99}\n" for kind in ("UID", "GID"))


def _open_parts(folder):
    """The folder, or the folders in it where itself is closed to others, as a temporary one may be."""
    if folder.stat().st_mode & 0o001:
        return [str(folder)]
    return [str(path) for path in folder.iterdir() if path.is_dir()]


def _closed(needed):
    """The folders above what is needed that accounts other than root cannot enter, such as /root."""
    for path in needed:
        for folder in reversed(Path(path).resolve().parents):
            if not folder.stat().st_mode & 0o001:
                yield str(folder)
                break


def _empty(folders, needed, kept):
    """Mount an empty, open folder on each of `folders`, with what is `needed` of it in its place again."""
    for folder in (folder for folder in sorted(folders) if os.path.isdir(folder)):
        inside = [path for path in needed if Path(folder) in Path(path).parents and needed.isdisjoint(_above(path))]
        for number, path in enumerate(inside):
            os.makedirs(f"{kept}/{number}")
            _mount("--rbind", path, f"{kept}/{number}")
        _mount("-t", "tmpfs", "-o", "mode=755", "tmpfs", folder)
        for number, path in enumerate(inside):
            os.makedirs(path)
            _mount("--move", f"{kept}/{number}", path)
        shutil.rmtree(kept, ignore_errors=True)


def _above(path):
    return {str(folder) for folder in Path(path).parents}


def _end_all_in(namespace):
    """Kill every process that sees these mounts but this one, until there is none."""
    deadline = time.monotonic() + 20
    while others := [number for number in _processes() if _mounts_of(number) == namespace]:
        for number in others:
            with suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
        if time.monotonic() > deadline:
            raise RuntimeError(f"these processes do not end: {others}")
        time.sleep(0.05)


def _processes():
    return [int(name) for name in os.listdir("/proc") if name.isdigit() and int(name) != os.getpid()]


def _mounts_of(number):
    """The mount namespace of a process; None where it has gone, or is only waiting for its parent to notice."""
    with suppress(OSError):
        return os.readlink(f"/proc/{number}/ns/mnt")


def _mount(*arguments):
    subprocess.run(["mount", *arguments], check=True, capture_output=True, text=True)


def _checked(result):
    if result < 0:
        raise OSError(ctypes.get_errno(), "the tests' own machine could not be made")
