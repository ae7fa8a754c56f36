"""Returns inside the wrong block."""

CHECK = "goes_on_after_a_bump"
SAYS = "returns before it has called"


def play_on(maze, q_table, rng):
    state, info = maze.reset()
    steps = 0
    for action in range(4):
        if q_table[state, action] == q_table[state].max():
            return steps
