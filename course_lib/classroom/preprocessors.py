"""Small steps of the course's own between nbgrader's; `nbgrader_config.py` says where each one stands."""

import re
from pathlib import Path

import nbformat
from nbgrader.preprocessors import ClearHiddenTests, NbGraderPreprocessor
from nbgrader.utils import is_grade

from course_lib.classroom.rebuild import rebuild
from course_lib.classroom.submissions import cells_of

# A link or a picture in Markdown or HTML, or a reference's target, that leads one folder up.
_UP = re.compile(r"""(\]\(|\b(?:src|href)=["']|^\[[^\]\n]+\]:\s*)\.\./""", re.MULTILINE)


class RelinkCells(NbGraderPreprocessor):
    """Links as seen from the learner's notebook, which lies one folder above its source."""

    def preprocess_cell(self, cell, resources, cell_index):  # noqa: ARG002 (nbconvert's signature)
        """Take one `../` from every relative link of a text."""
        if cell.cell_type == "markdown":
            cell.source = _UP.sub(r"\1", cell.source)
        return cell, resources


class TrimCells(NbGraderPreprocessor):
    """No blank lines at the end of a cell, where hidden tests have been."""

    def preprocess_cell(self, cell, resources, cell_index):  # noqa: ARG002 (nbconvert's signature)
        """Take what is blank from the end of a cell."""
        cell.source = cell.source.rstrip()
        return cell, resources


class RebuildCells(NbGraderPreprocessor):
    """A submission made anew against its release, whether it was laid out by `Course` or comes straight to nbgrader."""

    def preprocess(self, notebook, resources):
        """Rebuild the notebook; what was done to it is logged."""
        names = resources["nbgrader"]
        # nbgrader works in the folder of the class
        release = nbformat.read(Path("release", names["assignment"], f"{names['notebook']}.ipynb"), as_version=4)
        remarks = []
        rebuilt, changes = rebuild(cells_of(notebook, remarks), release)
        for remark in (*remarks, *changes):
            self.log.warning("%s: %s", names["student"], remark)
        return rebuilt, resources


class HideTests(ClearHiddenTests):
    """Hidden tests taken out of the check cells, and of no others.

    nbgrader's own step stops with an error at its markers in an ordinary cell: one comment would be enough for a
    learner to have no feedback page.
    """

    def preprocess_cell(self, cell, resources, cell_index):
        """Take the hidden tests from a check cell."""
        return super().preprocess_cell(cell, resources, cell_index) if is_grade(cell) else (cell, resources)
