"""Open and close are exchanged among the possible actions."""

CHECK = "learns_from_possible_actions"
SAYS = "the possible actions are exchanged"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    row = position * num_states + state
    next_row = next_position * num_states + next_state
    possible = [0, 1] if next_position == 1 else [0, 2]
    best = q_table[next_row, possible].max()
    target = reward + gamma * best
    q_table[row, action] += alpha * (target - q_table[row, action])
