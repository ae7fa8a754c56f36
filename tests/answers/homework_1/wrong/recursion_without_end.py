"""One call a step."""

CHECK = "goes_on_after_a_bump"
SAYS = "calls itself too often"


def play_on(maze, q_table, rng):
    maze.reset()
    return go_on(maze, q_table, rng, 0)


def go_on(maze, q_table, rng, steps):
    state, reward, terminated, truncated, info = maze.step(0)
    if terminated:
        return steps + 1
    return go_on(maze, q_table, rng, steps + 1)
