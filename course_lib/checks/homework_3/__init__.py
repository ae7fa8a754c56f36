"""The checks of homework 3, trading with networks."""

from course_lib.checks.homework_3.task_1 import scales_by_what_it_may_know
from course_lib.checks.homework_3.task_2 import passes_forward
from course_lib.checks.homework_3.task_3 import aims_at_possible_actions
from course_lib.checks.homework_3.task_4 import learns_with_a_target_that_holds_still
from course_lib.checks.homework_3.task_5 import stops_by_validation

__all__ = [
    "aims_at_possible_actions",
    "learns_with_a_target_that_holds_still",
    "passes_forward",
    "scales_by_what_it_may_know",
    "stops_by_validation",
]
