"""Learns in a copy, and returns it."""

CHECK = "learns_from_possible_actions"
SAYS = "learns in a copy"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    q_table = q_table.copy()
    num_states = len(q_table) // 2
    row = position * num_states + state
    next_row = next_position * num_states + next_state
    possible = [0, 2] if next_position == 1 else [0, 1]
    best = q_table[next_row, possible].max()
    target = reward + gamma * best
    q_table[row, action] += alpha * (target - q_table[row, action])
    return q_table
