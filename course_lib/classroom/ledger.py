"""What is known about a class: who is in it, the points of nbgrader's gradebook, and remarks for the teacher."""

import csv
import io
import json
import os
import re
from dataclasses import dataclass
from urllib.parse import unquote

from course_lib.files import write_whole

NOTHING = "Nothing handed in."
# Folders that programs leave behind.
_NO_LEARNERS = {".ipynb_checkpoints", "__pycache__", "__MACOSX", ".git"}
# What nbgrader loses a learner over: its patterns for files, a hidden folder, space at the ends, what is no text.
_UNFIT = re.compile(r"^[.\s]|\s$|[%*?\[\]\\]|[^\S ]|[\x00-\x1f\x7f\ud800-\udfff]")
# A cell that begins so is a formula to a spreadsheet.
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")


@dataclass(frozen=True)
class Grade:
    """What a learner has in a homework: points by check cell, their sum less penalties, and remarks for the teacher."""

    learner: str
    homework: str
    points: dict[str, float]
    score: float
    max_score: float
    remarks: tuple[str, ...] = ()

    def row(self):
        """The same as one flat dict."""
        named = {"learner": self.learner, "homework": self.homework}
        total = {"score": self.score, "max_score": self.max_score, "remarks": " ".join(self.remarks)}
        return named | self.points | total


def student_id(learner):
    """The learner's name in nbgrader: the name itself, but for characters that nbgrader cannot work with (as %2A)."""
    return _UNFIT.sub(lambda found: "".join(f"%{byte:02X}" for byte in os.fsencode(found[0])), learner)


def learner_of(student):
    """The learner whose name in nbgrader is `student`."""
    return unquote(student, errors="surrogateescape")


class Ledger:
    """The records of the class in `folder`, whose gradebook is at `db_url`."""

    def __init__(self, folder, db_url):
        self.folder, self._db_url = folder, db_url
        self._remarks_path = folder / "remarks.json"

    def gradebook(self):
        """The gradebook of nbgrader, to be used in a `with`."""
        from nbgrader.api import Gradebook

        return Gradebook(self._db_url)

    def learners(self):
        """The names of all learners: in the roster, in the gradebook, or with a folder in `submitted`."""
        with self.gradebook() as gradebook:
            names = {learner_of(student.id) for student in gradebook.students}
        names |= set(self._roster())
        for path in (self.folder / "submitted").iterdir():
            if path.name not in _NO_LEARNERS and (path.is_dir() or path.is_symlink()):
                names.add(path.name)
        return sorted(names)

    def _roster(self):
        """The names in the column `learner` of roster.csv, where there is one, with commas or semicolons."""
        path = self.folder / "roster.csv"
        if not path.exists():
            return []
        text = path.read_text(encoding="utf-8-sig")
        header = text.partition("\n")[0]
        rows = csv.DictReader(io.StringIO(text), delimiter=";" if ";" in header else ",")
        if "learner" not in (rows.fieldnames or []):
            raise ValueError(f"{path} has no column called learner; its first line is {header.strip()!r}")
        return [row["learner"].strip() for row in rows if (row["learner"] or "").strip()]

    # --- points -------------------------------------------------------------------------------------------------------

    def grade(self, homework, learner):
        """The learner's `Grade` as the gradebook has it; zeros where nothing was handed in."""
        from nbgrader.api import MissingEntry

        points = dict.fromkeys(self._graded_cells(homework), 0.0)
        remarks = self.remarks(homework).get(learner, [])
        with self.gradebook() as gradebook:
            max_score, score = gradebook.find_assignment(homework).max_score, 0.0
            try:
                submission = gradebook.find_submission(homework, student_id(learner))
            except MissingEntry:
                remarks = remarks or [NOTHING]
            else:
                for notebook in submission.notebooks:
                    points |= {grade.name: grade.score for grade in notebook.grades}
                score = max(0.0, submission.score - submission.late_submission_penalty)
        return Grade(learner, homework, points, score, max_score, tuple(remarks))

    def zero(self, homework, learner):
        """No points from the judge for a submission that could not be graded; a teacher's own points stay."""
        with self.gradebook() as gradebook:
            gradebook.update_or_create_student(student_id(learner))
            submission = gradebook.update_or_create_submission(homework, student_id(learner))
            for notebook in submission.notebooks:
                notebook.late_submission_penalty = None
                for grade in notebook.grades:
                    grade.auto_score, grade.needs_manual_grade = 0.0, grade.manual_score is not None
            gradebook.db.commit()

    def _graded_cells(self, homework):
        """The names of the graded cells of a released homework, in their order."""
        names = []
        for path in sorted((self.folder / "release" / homework).glob("*.ipynb")):
            for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
                tag = cell["metadata"].get("nbgrader", {})
                names += [tag["grade_id"]] if tag.get("grade") or tag.get("task") else []
        return names

    # --- remarks ------------------------------------------------------------------------------------------------------

    def remarks(self, homework):
        """{learner: remarks} of a homework."""
        return self._all_remarks().get(homework, {})

    def remark(self, homework, learner, remarks):
        """Keep the remarks on a submission in place of those of an earlier grading."""
        kept = self._all_remarks()
        kept.setdefault(homework, {})[learner] = list(remarks)
        write_whole(self._remarks_path, json.dumps(kept, indent=1, sort_keys=True).encode())

    def _all_remarks(self):
        if not self._remarks_path.exists():
            return {}
        try:
            return json.loads(self._remarks_path.read_bytes())
        except ValueError as error:
            raise ValueError(f"{self._remarks_path} is damaged ({error}); without it, grade again") from None


# --- files ------------------------------------------------------------------------------------------------------------


def write_csv(path, rows):
    """Write `rows` (dicts) to `path` for a spreadsheet: every column of any of them, no text that acts as a formula."""
    first, last = ["learner", "homework"], ["score", "max_score", "remarks"]
    cells = dict.fromkeys(name for row in rows for name in row if name not in (*first, *last))
    table = io.StringIO()
    writer = csv.DictWriter(table, [*first, *cells, *last], restval="")
    writer.writeheader()
    writer.writerows({name: _harmless(value) for name, value in row.items()} for row in rows)
    # With a byte order mark, without which Excel takes it for its own old encoding.
    write_whole(path, table.getvalue().encode("utf-8-sig", errors="replace"))


def _harmless(value):
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value
