"""Finished cells on disk, so that a study goes on where it was stopped."""

import dis
import hashlib
import inspect
from pathlib import Path

import numpy as np

import course_lib
from course_lib.files import load_arrays, save_arrays
from course_lib.study.plan import as_text, plain

_KIND, _FORMAT = "study cell", 1


class Kept:
    """A folder of finished cells, a file each, named by all that its numbers depend on.

    That is the function (its module, name, text and compiled form, and what it reads from outside where that is plain),
    the settings, the seeds, the version of the package and the format's. Another version of Python compiles otherwise,
    and so trains anew. A cell is read only from the file of its own name and only if the file says the same inside;
    where there is none, or a damaged one, the cell is trained and the file written anew. Files of other studies are
    left alone, so a folder may hold several, a grid may grow, and two processes may work in it: each file is renamed
    into its place whole, and both would write the same. `ValueError` where the folder cannot be made.
    """

    def __init__(self, folder, train):
        self.folder = Path(folder)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ValueError(f"folder must be one that can be made, got {str(folder)!r}: {error}") from None
        self._about = {"format": _FORMAT, "course_lib": course_lib.__version__}
        self._about |= {"function": f"{train.__module__}.{train.__qualname__}", "text": _digest_of(train)}

    def path(self, cell):
        """Where the cell's file is, if there is one."""
        digest = hashlib.sha256(as_text(self._told(cell)).encode()).hexdigest()
        return self.folder / f"cell-{digest[:32]}.safetensors"

    def read(self, cell):
        """The cell's arrays, or None: no file, a damaged one, or one that says that it is of another cell."""
        try:
            arrays, told = load_arrays(self.path(cell), kind=_KIND)
        except (FileNotFoundError, ValueError):
            return None
        whole = arrays and all(
            array.dtype == np.float64 and array.ndim in (1, 2) and len(array) == len(cell.seeds)
            for array in arrays.values()
        )
        return {name: arrays[name] for name in told["names"]} if whole and self._is_of(told, cell, arrays) else None

    def write(self, cell, arrays):
        """Keep the arrays of a finished cell."""
        arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
        save_arrays(self.path(cell), arrays, {"cell": self._told(cell), "names": list(arrays)}, kind=_KIND)

    def _is_of(self, told, cell, arrays):
        return (
            isinstance(told, dict)
            and told.get("cell") == self._told(cell)
            and isinstance(told.get("names"), list)
            and sorted(map(str, told["names"])) == sorted(arrays)
        )

    def _told(self, cell):
        return self._about | {"settings": cell.settings, "seeds": list(cell.seeds)}


def _digest_of(train):
    """A digest of the function: its text, if it is to be had, its compiled form, and the plain values that it reads.

    The text alone would not do: functions of one factory share it, and a file that was edited and not loaded again has
    another text than the code that runs.
    """
    try:
        text = inspect.getsource(train)
    except (OSError, TypeError):
        text = None
    parts = [text, _compiled(train.__code__), _plain_values(train)]
    return hashlib.sha256(as_text(parts).encode()).hexdigest()


def _compiled(code):
    """What a function does, as text that is the same in every process of one version of Python."""
    return repr((code.co_code.hex(), code.co_names, code.co_varnames, _constant(code.co_consts)))


def _constant(value):
    """A constant as text: sets in one order, functions within without their addresses."""
    if inspect.iscode(value):
        return _compiled(value)
    if isinstance(value, tuple):
        return [_constant(part) for part in value]
    if isinstance(value, frozenset):
        return ["set", *sorted(map(repr, value))]
    return repr(value)


def _plain_values(train):
    """{where: text} of its defaults, and of the variables of outer functions and of the module that it reads."""
    values = {f"default {i}": value for i, value in enumerate(train.__defaults__ or ())}
    values |= {f"default {name}": value for name, value in (train.__kwdefaults__ or {}).items()}
    for name, variable in zip(train.__code__.co_freevars, train.__closure__ or (), strict=True):
        try:
            values[f"outer {name}"] = variable.cell_contents
        except ValueError:  # not set yet
            continue
    shared = train.__globals__
    values |= {f"global {name}": shared[name] for name in _globals_read(train.__code__) if name in shared}
    texts = {where: _text_if_plain(value) for where, value in values.items()}
    return {where: text for where, text in texts.items() if text is not None}


def _globals_read(code):
    """The names of the module's variables that a function reads, or a function within it."""
    names = {part.argval for part in dis.get_instructions(code) if part.opname in ("LOAD_GLOBAL", "LOAD_NAME")}
    return names.union(*(_globals_read(part) for part in code.co_consts if inspect.iscode(part)))


def _text_if_plain(value):
    try:
        return as_text(plain("", value))
    except (ValueError, RecursionError):
        return None
