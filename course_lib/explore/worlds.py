"""Mazes of an explorer's own, and their numbers in words."""

from course_lib.maze import Action, Maze
from course_lib.plots.board import acting_states


def own_maze(maze, **changed):
    """A maze of one's own by the same rules, since to walk in it changes it; None: the course's, where bumps cost 1.

    changed   rules that are to be others. `ValueError` for what is no `Maze`.
    """
    if maze is None:
        return Maze(**{"wall_ends_episode": False} | changed)
    if not isinstance(maze, Maze):
        raise ValueError(f"a Maze is needed, got a {type(maze).__name__}")
    return Maze(**maze.spec.kwargs | changed)


def value_span(maze):
    """(lowest, highest) of the colours of a table: from 0 or the worst reward to 0 or the best one."""
    return min(0.0, float(maze.mdp.reward.min())), max(0.0, float(maze.mdp.reward.max()))


def table_in_words(maze, q):
    """All that differs from 0 in a table float[S, A], cell by cell."""
    told = []
    for s in acting_states(maze):
        known = [f"{a.name.lower()} {q[s, a]:z.2f}" for a in Action if q[s, a]]
        if known:
            told.append(f"cell {s}: {', '.join(known)}")
    return f"Q, where it is not 0: {'; '.join(told)}." if told else "All of Q is 0."


def plain(value):
    """A slider's value as it is written."""
    return f"{value:g}"


def counted(count, thing):
    """So many things in words, such as "1 move" and "2 moves"; count: a number, or one that is written already."""
    return f"{count} {thing}" + "s" * (str(count) != "1")
