"""Half of the money for each side."""

import numpy as np

CHECK = "trades_one_side_at_a_time"
SAYS = "gives half of its money to each side"


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
    return 0.5 * one_side(q_long, states) - 0.5 * one_side(q_short, states)
