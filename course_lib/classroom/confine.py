"""What a learner's process may not do, held by the operating system: use more than its share, or touch other files."""

import ctypes
import os
import sys
import sysconfig
from pathlib import Path

import course_lib

# https://docs.kernel.org/userspace-api/landlock.html
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_EXECUTE, _WRITE_FILE, _READ_FILE, _READ_DIR = 1 << 0, 1 << 1, 1 << 2, 1 << 3
_ALL_FILE_RIGHTS = {1: (1 << 13) - 1, 2: (1 << 14) - 1, 3: (1 << 15) - 1, 5: (1 << 16) - 1}  # from version … on
_BIND_AND_CONNECT, _SIGNALS_AND_SOCKETS = 0b11, 0b11
_NO_NEW_PRIVILEGES = 38

_SYSTEM = ("/usr", "/lib", "/lib64", "/sys/devices/system/cpu")
_OF_PROCESSES = ("self", "cpuinfo", "meminfo", "stat", "sys")  # of /proc, which shows other processes too
_SETTINGS = ("ld.so.cache", "localtime", "passwd", "fonts", "mime.types")  # of /etc, which holds secrets too
_DEVICES = ("/dev/null", "/dev/zero", "/dev/random", "/dev/urandom")


class _Ruleset(ctypes.Structure):
    _fields_ = [("files", ctypes.c_uint64), ("network", ctypes.c_uint64), ("scopes", ctypes.c_uint64)]


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = [("allowed", ctypes.c_uint64), ("folder", ctypes.c_int32)]


def limit_resources(memory_limit, file_limit, processor_seconds):
    """No more than that many bytes of memory and of any file, and seconds of processor time; for good."""
    import resource

    limits = {
        resource.RLIMIT_AS: memory_limit,
        resource.RLIMIT_FSIZE: file_limit,
        resource.RLIMIT_CPU: processor_seconds,
        resource.RLIMIT_CORE: 0,
    }
    if sys.platform == "darwin":  # macOS knows the name and refuses the limit
        del limits[resource.RLIMIT_AS]
    for kind, limit in limits.items():
        most = resource.getrlimit(kind)[1]
        limit = limit if most == resource.RLIM_INFINITY else min(limit, most)
        resource.setrlimit(kind, (limit, limit))


def can_confine():
    """Whether this system has Landlock: Linux 5.13 or later, with the module switched on."""
    return _landlock_version() > 0


def confine_to(folder):
    """From now on this process and its children write in `folder` only, and read only that, Python and the system.

    With Linux 6.7 they also open no TCP connection, with 6.12 they signal nobody outside. For good; but where the
    system `can_confine` nothing, it does nothing.
    """
    version = _landlock_version()
    if version < 1:
        return
    everything = _ALL_FILE_RIGHTS[max(v for v in _ALL_FILE_RIGHTS if v <= version)]
    ruleset = _Ruleset(everything, _BIND_AND_CONNECT * (version >= 4), _SIGNALS_AND_SOCKETS * (version >= 6))
    size = 8 + 8 * (version >= 4) + 8 * (version >= 6)
    rules = _checked(_libc().syscall(_CREATE_RULESET, ctypes.byref(ruleset), ctypes.c_size_t(size), 0))
    _allow(rules, folder, everything)
    for path in _what_python_reads():
        _allow(rules, path, _EXECUTE | _READ_FILE | _READ_DIR)
    for path in filter(os.path.isdir, sys.path):
        _allow(rules, path, _READ_DIR)
    for device in _DEVICES:
        _allow(rules, device, _WRITE_FILE | _READ_FILE)
    _checked(_libc().prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0))
    _checked(_libc().syscall(_RESTRICT_SELF, rules, 0))
    os.close(rules)


def _what_python_reads():
    folders = {sys.prefix, sys.base_prefix, sys.exec_prefix, Path(course_lib.__file__).parent}
    folders |= {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    folders |= {path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")}
    folders |= {*_SYSTEM, *(f"/etc/{name}" for name in _SETTINGS), *(f"/proc/{name}" for name in _OF_PROCESSES)}
    return [folder for folder in folders if os.path.exists(folder)]


def _allow(rules, path, rights):
    if not os.path.isdir(path):
        rights &= _EXECUTE | _WRITE_FILE | _READ_FILE
    folder = os.open(path, os.O_PATH | os.O_CLOEXEC)
    try:
        rule = _Beneath(rights, folder)
        _checked(_libc().syscall(_ADD_RULE, rules, 1, ctypes.byref(rule), 0))
    finally:
        os.close(folder)


def _landlock_version():
    if sys.platform != "linux":
        return 0
    return _libc().syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), 1)


def _libc():
    return ctypes.CDLL(None, use_errno=True)


def _checked(result):
    if result < 0:
        raise OSError(ctypes.get_errno(), "the process could not be confined")
    return result
