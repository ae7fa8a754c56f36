"""Waits for something that does not come."""

CHECK = "goes_on_after_a_bump"
SAYS = "a loop in your code never ends"
TIME_LIMIT = 0.5


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    steps = 0
    while state is not None:
        steps += 1
    return steps
