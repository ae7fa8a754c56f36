"""A class on nbgrader's exchange: homework published, collected, and given back to learners of the same machine."""

import os
from functools import cached_property
from pathlib import Path

from course_lib.classroom.course import SETTINGS, problem_of
from course_lib.classroom.ledger import student_id
from course_lib.classroom.submissions import printable

NOT_GIVEN = "The feedback page could not be given back"

__all__ = ["Exchange"]


class Exchange:
    """Where `course` meets its learners: `publish` homework, `collect` it, `give_back` its pages.

    `ValueError` where the settings of the class name no exchange.
    """

    def __init__(self, course):
        self.course, self._api = course, course.nbgrader
        if not self._api.coursedir.course_id or not self._api.config.Exchange.root:
            raise ValueError(f"this class has no exchange: {SETTINGS.name} names no Exchange.root and course_id")

    @cached_property
    def folder(self):
        """The folder of the class on the exchange."""
        return Path(self._api.config.Exchange.root, self._api.coursedir.course_id)

    def publish(self, homework):
        """Let learners fetch a released homework, also in place of an earlier one; the folder that they fetch."""
        self.course.released(homework)
        problem = problem_of(self._api.release_assignment(homework))
        if problem:
            raise RuntimeError(f"{homework} is not on the exchange: {problem}")
        os.chmod(self.folder / "inbound", 0o3733)  # nobody lists it, nobody removes what is not their own
        return self.folder / "outbound" / homework

    def collect(self, homework):
        """Bring what learners submitted into `submitted`: the names of those with new work, and notes on what is odd.

        Work that was collected before stays until its author submits again. No submission stops the others.
        """
        from nbgrader.utils import capture_log, temp_attrs

        api = self._api
        self.course.released(homework)
        with temp_attrs(api.coursedir, assignment_id=homework, submitted_directory="submitted"):
            collect = api.exchange.Collect(coursedir=api.coursedir, authenticator=api.authenticator, parent=api)
            collect.update = True
            result = capture_log(collect)
        problem = problem_of(result)
        if problem:
            raise RuntimeError(f"{homework} was not collected: {problem}")
        return collect.collected, collect.notes

    def give_back(self, homework):
        """Lay out the feedback pages, each where only its learner finds it; the learners who have one now."""
        self.course.released(homework)
        given = []
        for learner in self.course.learners:
            student, ledger = student_id(learner), self.course.ledger
            if not (self.course.folder / "feedback" / student / homework).is_dir():
                continue
            problem = problem_of(self._api.release_feedback(homework, student))
            remarks = [said for said in ledger.remarks(homework).get(learner, []) if not said.startswith(NOT_GIVEN)]
            if problem:
                remarks.append(f"{NOT_GIVEN}: {printable(problem, 200)}")
            else:
                given.append(learner)
            ledger.remark(homework, learner, remarks)
        return given
