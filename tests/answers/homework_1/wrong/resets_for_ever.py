"""Waits for the mouse to begin somewhere else."""

CHECK = "goes_on_after_a_bump"
SAYS = "plays episode after episode"


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    while state == 0 or state > 0:
        state, info = maze.reset()
    return 1
