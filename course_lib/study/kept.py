"""Finished cells on disk, so that a study goes on where it was stopped."""

import hashlib
import inspect
from pathlib import Path

import numpy as np

import course_lib
from course_lib.files import load_arrays, save_arrays
from course_lib.study.plan import as_text

_KIND, _FORMAT = "study cell", 1


class Kept:
    """A folder of finished cells, a file each, named by all that its numbers depend on.

    That is the function (its module, name and text), the settings, the seeds, the version of the package and the
    format's. A cell is read only from the file of its own name and only if the file says the same inside; where there
    is none, or a damaged one, the cell is trained and the file written anew. Files of other studies are left alone, so
    a folder may hold several, a grid may grow, and two processes may work in it: each file is renamed into its place
    whole, and both would write the same. `ValueError` where the folder cannot be made.
    """

    def __init__(self, folder, train):
        self.folder = Path(folder)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ValueError(f"folder must be one that can be made, got {str(folder)!r}: {error}") from None
        self._about = {"format": _FORMAT, "course_lib": course_lib.__version__}
        self._about |= {"function": f"{train.__module__}.{train.__qualname__}", "text": _text_of(train)}

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


def _text_of(train):
    """A digest of the function's text, or of its compiled form where the text is not to be had."""
    try:
        text = inspect.getsource(train)
    except (OSError, TypeError):
        text = repr((train.__code__.co_code, train.__code__.co_names, _constants(train.__code__)))
    return hashlib.sha256(text.encode()).hexdigest()


def _constants(code):
    """A function's constants without the addresses of functions within it."""
    return [_constants(part) if inspect.iscode(part) else part for part in code.co_consts]
