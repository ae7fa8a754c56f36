"""The value of holding stands for the best of the next row."""

CHECK = "learns_from_possible_actions"
SAYS = "your target looks at hold only"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    row = position * num_states + state
    next_row = next_position * num_states + next_state
    target = reward + gamma * q_table[next_row, 0]
    q_table[row, action] += alpha * (target - q_table[row, action])
