"""The checks of homework 2, trading with Q-tables."""

from course_lib.checks.homework_2.task_1 import reads_moves_as_digits
from course_lib.checks.homework_2.task_2 import finds_turns_on_a_grid
from course_lib.checks.homework_2.task_3 import stands_between_low_and_high
from course_lib.checks.homework_2.task_4 import pays_every_bar
from course_lib.checks.homework_2.task_5 import learns_from_possible_actions
from course_lib.checks.homework_2.task_6 import trades_one_side_at_a_time
from course_lib.checks.homework_2.task_7 import finds_the_leak

__all__ = [
    "finds_the_leak",
    "finds_turns_on_a_grid",
    "learns_from_possible_actions",
    "pays_every_bar",
    "reads_moves_as_digits",
    "stands_between_low_and_high",
    "trades_one_side_at_a_time",
]
