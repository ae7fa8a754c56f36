"""The maximum goes over all three actions."""

CHECK = "learns_from_possible_actions"
SAYS = "the maximum goes over impossible actions as well"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    row = position * num_states + state
    next_row = next_position * num_states + next_state
    best = q_table[next_row].max()
    target = reward + gamma * best
    q_table[row, action] += alpha * (target - q_table[row, action])
