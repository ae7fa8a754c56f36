"""The loops that must be fast, written plainly and compiled by numba at their first call.

Nothing uses fastmath, so results equal plain Python's to the last bit.
"""

from course_lib.kernels.compile import compiled
from course_lib.kernels.learning import q_learning, q_learning_along, q_learning_side_by_side
from course_lib.kernels.planning import (
    all_action_values,
    follow_policy,
    spread_news,
    sweep_best,
    sweep_policy,
)

__all__ = [
    "all_action_values",
    "compiled",
    "follow_policy",
    "q_learning",
    "q_learning_along",
    "q_learning_side_by_side",
    "spread_news",
    "sweep_best",
    "sweep_policy",
]
