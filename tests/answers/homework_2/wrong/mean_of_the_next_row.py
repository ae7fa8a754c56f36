"""The mean of the possible values."""

CHECK = "learns_from_possible_actions"
SAYS = "the mean of the possible values"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    row = position * num_states + state
    next_row = next_position * num_states + next_state
    possible = [0, 2] if next_position == 1 else [0, 1]
    best = q_table[next_row, possible].mean()
    target = reward + gamma * best
    q_table[row, action] += alpha * (target - q_table[row, action])
