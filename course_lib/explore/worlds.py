"""Mazes of an explorer's own, and their numbers in words."""

from course_lib.explore.numerals import two_places
from course_lib.maze import Action, Maze
from course_lib.plots.board import acting_states


def own_maze(maze, *, most=8, **rules):
    """An explorer's maze: one like `maze`, since to walk in a maze changes it; None: the course's, by these rules.

    most   rows and columns that have room. `ValueError` for what is no `Maze`, and for a larger one.
    """
    if maze is None:
        return Maze(**rules)
    if not isinstance(maze, Maze):
        raise ValueError(f"a Maze is needed, got a {type(maze).__name__}")
    if max(maze.rows, maze.columns) > most:
        raise ValueError(f"at most {most} rows and columns have room for numbers, got {maze.rows} x {maze.columns}")
    return with_rules(maze)


def with_rules(maze, **changed):
    """Another maze by the same rules, but for those that are changed."""
    return Maze(**maze.spec.kwargs | changed)


def value_span(maze):
    """(lowest, highest) of the colours of a table: from 0 or the worst reward to 0 or the best one."""
    return min(0.0, float(maze.mdp.reward.min())), max(0.0, float(maze.mdp.reward.max()))


def table_in_words(maze, q):
    """All that differs from 0 in a table float[S, A], cell by cell."""
    told = []
    for s in acting_states(maze):
        known = [f"{a.name.lower()} {two_places(q[s, a])}" for a in Action if q[s, a]]
        if known:
            told.append(f"cell {s}: {', '.join(known)}")
    return f"Q, where it is not 0: {'; '.join(told)}." if told else "All of Q is 0."


def counted(count, thing):
    """So many things in words, such as "1 move" and "2 moves"; count: a number, or one that is written already."""
    return f"{count} {thing}" + "s" * (str(count) != "1")
