"""A class of learners and their homework: templates to fill in, submissions read without trust, grades, feedback.

For teachers; a learner needs none of it. Grading rests on nbgrader, which `pip install -e ".[teach]"` brings:
`python -m course_lib.classroom --help` says what it can do.
"""

from importlib.util import find_spec


def require_nbgrader():
    """`ModuleNotFoundError` with the one command that helps, where nbgrader is not installed."""
    if not find_spec("nbgrader"):
        raise ModuleNotFoundError('this needs nbgrader: pip install -e ".[teach]"', name="nbgrader")
