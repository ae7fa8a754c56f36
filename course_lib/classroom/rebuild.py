"""A learner's notebook made anew against the released one: the learner's own cells, and check cells that are ours.

The released notebook is cut into sections, each ending with a check cell. A learner's cell that answers to one of
the release (by its tag, or by its text where tags were lost) says where that section is; all others stay where they
are, as ordinary cells. Whatever happened to the check cells, each stands once, in our words, at its section's end.
"""

from collections import Counter
from copy import deepcopy
from typing import NamedTuple

from nbformat.v4 import new_code_cell, new_markdown_cell, new_raw_cell

_NEW = {"code": new_code_cell, "markdown": new_markdown_cell, "raw": new_raw_cell}


class Cell(NamedTuple):
    """A learner's cell: its type, its text, and what it says it is to nbgrader."""

    kind: str
    source: str
    tag: dict

    @property
    def tag_id(self):
        """The cell's name in nbgrader, or None."""
        name = self.tag.get("grade_id")
        return name if isinstance(name, str) else None


class _Place(NamedTuple):
    """One cell of the new notebook: the released cell that it answers to, if any, and what is written there.

    A check cell of the learner's leaves only a mark of where it stood: None.
    """

    index: int | None
    cell: object


def tags_of(release):
    """The names of all cells of a release that have one."""
    return {name for name in map(_name, release.cells) if name}


def rebuild(cells, release):
    """(notebook, remarks) from the learner's `cells`; None for cells that could not be read: the release, untouched."""
    notebook = deepcopy(release)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    if cells is None:
        return notebook, []
    sections, remarks = _sections(notebook.cells), []
    places = _match(cells, notebook.cells, remarks)
    _put_back_fixed(places, notebook.cells, sections, remarks)
    notebook.cells = _with_checks(places, notebook.cells, sections)
    _name_own_cells(notebook.cells)
    return notebook, remarks


# --- what a released cell is ------------------------------------------------------------------------------------------


def _name(cell):
    return cell.metadata.get("nbgrader", {}).get("grade_id")


def _is(cell, flag):
    return bool(cell.metadata.get("nbgrader", {}).get(flag))


def _is_check(cell):
    return _is(cell, "grade") and not _is(cell, "solution")


def _is_fixed(cell):
    """Whether a cell is ours but no check: a description, imports."""
    return (_is(cell, "locked") or _is(cell, "task")) and not _is(cell, "solution") and not _is_check(cell)


def _sections(released):
    """The number of the section that each released cell is in: how many check cells come before it."""
    numbers = [0]
    for cell in released:
        numbers.append(numbers[-1] + _is_check(cell))
    return numbers[:-1]


# --- which cell is which ----------------------------------------------------------------------------------------------


def _match(cells, released, remarks):
    """The learner's cells in their order, as places."""
    by_name = {_name(cell): index for index, cell in enumerate(released) if _name(cell)}
    # A cell without a tag is known by its text, but not a solution: all stubs read alike.
    by_text = {
        (cell.cell_type, cell.source.strip()): index for index, cell in enumerate(released) if not _is(cell, "solution")
    }
    found = [_find(cell, by_name, by_text) for cell in cells]
    last_answer = {index: at for at, index in enumerate(found) if index is not None}
    strangers = sum(1 for cell, index in zip(cells, found, strict=True) if cell.tag_id and index is None)
    if strangers:
        remarks.append(f"Tags that are not of this homework were taken from cells: {strangers}.")
    places, seen = [], set()
    for at, (cell, index) in enumerate(zip(cells, found, strict=True)):
        ours = None if index is None else released[index]
        if ours is None:
            places.append(_Place(None, _own(cell)))
        elif _is_check(ours):
            places.append(_Place(index, None))
        elif _is(ours, "solution"):
            # All copies of a solution run in their order, as they did for the learner. The tag, on which a teacher's
            # comments hang, goes to the last: what it says holds in the end. nbgrader decides the same.
            answer = deepcopy(ours) if last_answer[index] == at else _NEW[ours.cell_type]()
            answer.source = cell.source
            places.append(_Place(index, answer))
        elif index in seen:
            places.append(_Place(None, _own(cell)))
        else:
            seen.add(index)
            places.append(_Place(index, deepcopy(ours)))
            if ours.cell_type == cell.kind == "code" and cell.source.strip() != ours.source.strip():
                # Somebody may have added an import here, and their code needs it.
                places.append(_Place(None, _own(cell)))
    remarks.extend(_changes(cells, found, released))
    return places


def _find(cell, by_name, by_text):
    """The index of the released cell that a learner's cell answers to, or None."""
    if cell.tag_id in by_name:
        return by_name[cell.tag_id]
    return by_text.get((cell.kind, cell.source.strip()))


def _own(cell):
    return _NEW[cell.kind](cell.source)


def _same(cell, ours):
    """Whether a learner's cell still is what we gave out, its tag's promises included."""
    flags = ("grade", "solution", "locked", "points")
    tag = ours.metadata.get("nbgrader", {})
    return (
        cell.kind == ours.cell_type
        and cell.source.rstrip() == ours.source.rstrip()
        and all(cell.tag.get(flag) == tag.get(flag) for flag in flags)
    )


def _changes(cells, found, released):
    """Sentences on what was done to the cells that are ours."""
    count = Counter(index for index in found if index is not None)
    for index, ours in enumerate(released):
        copies = [cell for cell, other in zip(cells, found, strict=True) if other == index]
        if _is_check(ours):
            if not copies:
                yield f"The check cell {_name(ours)} had been deleted; it was put back."
            elif not all(_same(cell, ours) for cell in copies):
                yield f"The check cell {_name(ours)} had been changed; it was restored."
            if len(copies) > 1:
                yield f"The check cell {_name(ours)} was there {count[index]} times; it counts once."
        elif _is_fixed(ours):
            if copies and not _same(copies[0], ours):
                yield f"The read-only cell {_name(ours)} had been changed; it was restored."
        elif _is(ours, "solution") and len(copies) > 1:
            yield f"The solution cell {_name(ours)} was there {count[index]} times; all ran, in their order."


# --- putting it together ----------------------------------------------------------------------------------------------


def _put_back_fixed(places, released, sections, remarks):
    """Put back, in place, deleted cells that later ones or the gradebook need: read-only code and graded answers.

    A deleted description is not missed. Nor is the cell of a solution: its code may stand elsewhere by now, and the
    stub would undo it.
    """
    for index, ours in enumerate(released):
        needed = (_is_fixed(ours) and (ours.cell_type == "code" or _is(ours, "task"))) or (
            _is(ours, "grade") and _is(ours, "solution")
        )
        if not needed or any(place.index == index for place in places):
            continue
        remarks.append(f"The cell {_name(ours)} had been deleted; it was put back.")
        section = [
            (place.index, at)
            for at, place in enumerate(places)
            if place.index is not None and place.cell is not None and sections[place.index] == sections[index]
        ]
        before = [at for other, at in section if other < index]
        if before:
            at = max(before) + 1
        elif sections[index] == 0:
            at = 0
        else:
            at = min((at for _, at in section), default=_end_of(sections[index], places, sections))
        places.insert(at, _Place(index, deepcopy(ours)))


def _end_of(section, places, sections):
    """Where the checks of a section go: after its own last cell, before the next that is of another section.

    A learner's check cell tells where a section is only if nothing else of it is left.
    """
    numbers = [None if place.index is None else sections[place.index] for place in places]
    standing = {number for number, place in zip(numbers, places, strict=True) if place.cell is not None}
    tells = [place.cell is not None or number not in standing for number, place in zip(numbers, places, strict=True)]
    known = [(number, at) for at, number in enumerate(numbers) if number is not None and tells[at]]
    own = [at for number, at in known if number == section] or [at for number, at in known if number < section]
    last = max(own, default=-1)
    return next((at for number, at in known if number != section and at > last), len(places))


def _with_checks(places, released, sections):
    """The cells of the new notebook: those of `places`, and every check cell once."""
    checks = {}
    for index, ours in enumerate(released):
        if _is_check(ours):
            checks.setdefault(_end_of(sections[index], places, sections), []).append(ours)
    cells = []
    for at, place in enumerate([*places, _Place(None, None)]):
        cells += checks.get(at, [])
        if place.cell is not None:
            cells.append(place.cell)
    return cells


def _name_own_cells(cells):
    """Give the learner's own cells ids that are the same at every grading and nobody else's."""
    for number, cell in enumerate(cells):
        if "nbgrader" not in cell.metadata:
            cell.id = f"own-{number}"
