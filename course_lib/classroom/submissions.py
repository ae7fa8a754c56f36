"""What a learner handed in, read without trust: every file here is one that anybody could have written.

`read_submission` raises for none of them. It finds the notebook, takes the texts of its cells and nothing else (no
outputs, no metadata but nbgrader's tag), and rebuilds it against the released notebook.
"""

import json
import os
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from course_lib.classroom.rebuild import Cell, rebuild, tags_of

# A notebook that printed too much is still an honest one; far more than any lesson prints is not read.
LARGEST_FILE = 128_000_000
# In JSON every list or object costs twenty times its bytes once parsed: few files need a million, hostile ones do.
MOST_BRACKETS = 3_000_000
# A whole homework is a tenth of this. Much more keeps the judge and the feedback page busy, above all long texts: one
# of 100,000 opening brackets costs a Markdown renderer a minute, twice as many cost four.
MOST_CELLS, MOST_TEXT, LONGEST_WORDS = 500, 200_000, 20_000
# Zip files often unpack into a folder in the folder.
DEEPEST_FOLDER, MOST_NOTEBOOKS, MOST_FILES = 3, 20, 10_000

_TYPES = {"code": "code", "markdown": "markdown", "heading": "markdown", "raw": "raw"}


@dataclass(frozen=True)
class Submission:
    """A learner's `notebook`, rebuilt so that its check cells are ours, and `remarks` on it for the teacher."""

    notebook: Any
    remarks: tuple[str, ...]


class Unreadable(Exception):
    """A file that cannot be read as a notebook; the message goes on after its name: "is empty"."""


def read_submission(folder, release, name):
    """The `Submission` of the notebook called `name` in `folder`, against the notebook `release` that was given out.

    Where nothing can be read it is the released notebook itself, which earns nothing, with a remark.
    """
    folder, remarks = Path(folder), []
    tags = tags_of(release)
    chosen, others = _choose(folder, name, tags, remarks)
    cells = []
    if chosen:
        path, cells = chosen
        if path.relative_to(folder) != Path(name):
            remarks.append(f"{name} was not there or not readable; {printable(path.relative_to(folder))} was graded.")
        if others:
            listed = ", ".join(printable(other.relative_to(folder)) for other in others[:3])
            remarks.append(f"Other notebooks were handed in as well and not graded: {listed}.")
        if not any(cell.tag_id in tags for cell in cells):
            remarks.append("No cell of it has a tag of this homework.")
    notebook, changes = rebuild(cells if chosen else None, release)
    return Submission(notebook, (*remarks, *changes))


def printable(text, longest=80):
    """`text` fit for a remark: learners choose file names, and a terminal obeys what it is sent."""
    text = "".join(character if character.isprintable() else "?" for character in str(text))
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


# --- files ------------------------------------------------------------------------------------------------------------


def regular_files(folder):
    """The regular files in `folder` and a few folders down, sorted, following no link; hidden folders are left out."""
    found = []
    if os.path.islink(folder):
        return found
    for place, folders, files in os.walk(folder):
        deep = len(Path(place).relative_to(folder).parts) >= DEEPEST_FOLDER
        folders[:] = [] if deep else sorted(name for name in folders if not name.startswith((".", "__")))
        for name in sorted(files)[: MOST_FILES - len(found)]:
            path = Path(place, name)
            try:
                if stat.S_ISREG(path.lstat().st_mode):
                    found.append(path)
            except OSError:
                continue
    return found


def read_bytes(path, largest=LARGEST_FILE):
    """The content of a regular file; `Unreadable` for what is none, is too large or cannot be opened."""
    no_links, no_waiting = getattr(os, "O_NOFOLLOW", 0), getattr(os, "O_NONBLOCK", 0)
    try:
        if path.is_symlink():
            raise Unreadable("is a link, and links are not followed")
        if path.is_dir():
            raise Unreadable("is a folder")
        with open(os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0) | no_links | no_waiting), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise Unreadable("is not a regular file")
            if status.st_size > largest:
                raise Unreadable(f"is larger than {largest // 1_000_000} MB")
            return file.read(largest + 1)[:largest]
    except OSError as error:
        raise Unreadable(f"cannot be opened ({error.strerror})") from None


def _choose(folder, name, tags, remarks):
    """((path, cells) or None, other notebooks): the file of that name, else the one that holds most of `tags`."""
    if os.path.islink(folder):
        remarks.append("Nothing to grade: the submission's folder is a link, and links are not followed.")
        return None, []
    expected = folder / name
    notebooks = [path for path in regular_files(folder) if path.suffix.lower() == ".ipynb" and path.name[0] != "."]
    others = [path for path in notebooks if path != expected]
    if os.path.lexists(expected):
        cells = _read_or_say(expected, folder, remarks)
        if cells is not None:
            return (expected, cells), others
    elif not others:
        remarks.append("Nothing to grade: the submission's folder holds no notebook.")
        return None, []
    found = []
    for path in others[:MOST_NOTEBOOKS]:
        said = []
        cells = _read_or_say(path, folder, said)
        rank = path.name.lower() == name.lower(), len({cell.tag_id for cell in cells or ()} & tags)
        if cells is None:
            remarks += said
        elif any(rank):
            found.append((rank, path, cells, said))
    if not found:
        remarks.append("Nothing to grade: no notebook of this homework can be read.")
        return None, []
    _, path, cells, said = max(found, key=lambda one: one[0])
    remarks += said
    return (path, cells), [other for _, other, _, _ in found if other != path]


# --- notebooks --------------------------------------------------------------------------------------------------------


def _read_or_say(path, folder, remarks):
    """The cells of the notebook at `path`, or None and a remark."""
    try:
        return _read_cells(path, remarks)
    except Unreadable as error:
        remarks.append(f"{printable(path.relative_to(folder))} {error}.")
        return None


def _read_cells(path, remarks):
    """The cells of the notebook at `path`, of any nbformat; `Unreadable` where there is none."""
    content = read_bytes(path)
    if not content.strip():
        raise Unreadable("is empty")
    if content.count(b"{") + content.count(b"[") > MOST_BRACKETS:
        raise Unreadable("holds far more than a notebook does")
    try:
        text = content.decode(json.detect_encoding(content), errors="replace")
        parsed = json.loads(text)
    except (ValueError, RecursionError, MemoryError):
        raise Unreadable("is not JSON (damaged, or cut short)") from None
    if _list_of_cells(parsed) is None:
        raise Unreadable("is not a notebook")
    if "\ufffd" in text and "\ufffd".encode() not in content:
        remarks.append(f"{printable(path.name)} holds bytes that are no text; each was read as \ufffd.")
    return cells_of(parsed, remarks)


def cells_of(notebook, remarks):
    """The cells, as far as they are valid, of a parsed notebook; `remarks` gets a sentence on the others."""
    cells = [_cell(cell) for cell in _list_of_cells(notebook)]
    if None in cells:
        remarks.append(f"{cells.count(None)} of its cells were not valid and are left out.")
    return _few_enough([cell for cell in cells if cell], remarks)


def _list_of_cells(notebook):
    """The list of a notebook's cells, up to nbformat 3 kept in worksheets, or None where there is none."""
    if not isinstance(notebook, dict):
        return None
    if isinstance(notebook.get("cells"), list):
        return notebook["cells"]
    sheets = notebook.get("worksheets")
    if not isinstance(sheets, list):
        return None
    sheets = [sheet["cells"] for sheet in sheets if isinstance(sheet, dict) and isinstance(sheet.get("cells"), list)]
    return [cell for sheet in sheets for cell in sheet]


def _cell(cell):
    """A `Cell` of the learner's, or None where it is not valid."""
    if not isinstance(cell, dict):
        return None
    kind = cell.get("cell_type")
    source = cell.get("source", cell.get("input"))  # nbformat 3 calls a code cell's text its input
    if isinstance(source, list) and all(isinstance(line, str) for line in source):
        source = "".join(source)
    if not isinstance(source, str) or not isinstance(kind, str) or kind not in _TYPES:
        return None
    metadata = cell.get("metadata")
    tag = metadata.get("nbgrader") if isinstance(metadata, dict) else None
    # JSON can spell half a character (a lone surrogate), which no file can hold.
    source = source.encode(errors="replace").decode()
    return Cell(_TYPES[kind], source, tag if isinstance(tag, dict) else {})


def _few_enough(cells, remarks):
    """The first cells, as many as the judge is ready to run."""
    kept, length = [], 0
    for cell in cells:
        if cell.kind != "code" and len(cell.source) > LONGEST_WORDS:
            cell = cell._replace(source=cell.source[:LONGEST_WORDS])
            remarks.append(f"A text of it is cut after {LONGEST_WORDS} characters.")
        length += len(cell.source)
        if len(kept) == MOST_CELLS or length > MOST_TEXT:
            remarks.append(f"It is far longer than a homework: all after its first {len(kept)} cells is left out.")
            break
        kept.append(cell)
    return kept
