"""Passes names of actions, and hides what the maze says to that."""

CHECK = "goes_on_after_a_bump"
SAYS = "Does an `except` hide an error"


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    over = False
    while not over:
        try:
            state, reward, terminated, truncated, info = maze.step("up")
            over = terminated or truncated
        except ValueError:
            print("bump?")
    return 1
