"""Each table trades by itself; the positions are added."""

import numpy as np

CHECK = "trades_one_side_at_a_time"
SAYS = "each table trades by itself"


def one_side(q_table, states):
    num_states = len(q_table) // 2
    position = 0
    positions = []
    for state in states:
        if state == -1:
            position = 0
        elif position == 0:
            position = int(q_table[state, 1] > q_table[state, 0])
        elif q_table[num_states + state, 2] > q_table[num_states + state, 0]:
            position = 0
        positions.append(position)
    return np.array(positions)


def trade(q_long, q_short, states):
    return one_side(q_long, states) - one_side(q_short, states)
