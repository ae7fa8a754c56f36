"""The row is state * 2 + position."""

CHECK = "learns_from_possible_actions"
SAYS = "numbered by `state * 2 + position`"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    row = 2 * state + position
    next_row = 2 * next_state + next_position
    possible = [0, 2] if next_position == 1 else [0, 1]
    best = q_table[next_row, possible].max()
    target = reward + gamma * best
    q_table[row, action] += alpha * (target - q_table[row, action])
