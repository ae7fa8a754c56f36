"""Of two equal advantages the long one is taken."""

import numpy as np

CHECK = "trades_one_side_at_a_time"
SAYS = "where both sides gain the same, the long one opens"


def trade(q_long, q_short, states):
    num_states = len(q_long) // 2
    position = 0
    positions = []
    for state in states:
        closed = 0
        if state == -1:
            positions.append(0)
            continue
        if position != 0:
            table = q_long if position == 1 else q_short
            row = table[num_states + state]
            if row[2] > row[0]:
                closed = position
                position = 0
        if position == 0:
            long = q_long[state, 1] - q_long[state, 0]
            short = q_short[state, 1] - q_short[state, 0]
            wanted = 0
            if long > 0 and long >= short:
                wanted = 1
            elif short > 0:
                wanted = -1
            if wanted != closed:
                position = wanted
        positions.append(position)
    return np.array(positions)
