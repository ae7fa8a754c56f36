"""Calls a function that is not written yet."""

CHECK = "goes_on_after_a_bump"
SAYS = "`choose_another`, which your code calls, is not written yet"


def choose_another(q_table, state, bumped, rng):
    raise NotImplementedError  # your code here


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    bumped = set()
    return choose_another(q_table, state, bumped, rng)
