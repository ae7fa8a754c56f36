"""The row is the state."""

CHECK = "learns_from_possible_actions"
SAYS = "the position has no part in your row"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    row = state
    next_row = next_state
    possible = [0, 2] if next_position == 1 else [0, 1]
    best = q_table[next_row, possible].max()
    target = reward + gamma * best
    q_table[row, action] += alpha * (target - q_table[row, action])
