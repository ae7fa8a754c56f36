"""Thinks that the maze begins an episode by itself."""

CHECK = "goes_on_after_a_bump"
SAYS = "does not begin an episode"


def play_on(maze, q_table, rng):
    return 0
