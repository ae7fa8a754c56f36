"""The checks of homework 1, a mouse with a memory."""

from course_lib.checks.homework_1.task_1 import goes_on_after_a_bump
from course_lib.checks.homework_1.task_2 import keeps_to_fresh_cells
from course_lib.checks.homework_1.task_3 import stops_by_itself

__all__ = ["goes_on_after_a_bump", "keeps_to_fresh_cells", "stops_by_itself"]
