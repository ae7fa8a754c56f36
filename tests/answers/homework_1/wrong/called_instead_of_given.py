"""Gives the check what the function returned."""

CHECK = "goes_on_after_a_bump"
SAYS = "something else than your function"


play_on = 12  # from checks.goes_on_after_a_bump(play_on(maze, q_table, rng))
