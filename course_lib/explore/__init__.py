"""Pictures that answer: each function gives an `Explorer`, which shows itself as the last value of a cell.

An explorer is one state without any widget in it (`BlindMaze`, …), drawn by `board` and `chart` over `sketch`, and
shown by the one widget of `explorer`. It can be worked by mouse and by keyboard, and says in words what it shows.
"""

from course_lib.explore.explorer import Explorer
from course_lib.explore.mouse import KEPT_IN, BlindMaze

__all__ = ["BlindMaze", "Explorer", "be_the_mouse"]


def be_the_mouse(maze=None):
    """A maze in the dark, to be walked with buttons or arrow keys; by default the course's.

    In the course's maze finished walks are kept in my_mouse.json in the current folder, for lesson 3.
    """
    return Explorer(BlindMaze(maze, keep=KEPT_IN if maze is None else None))
