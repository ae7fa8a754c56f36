"""The table loses a row."""

CHECK = "learns_from_possible_actions"
SAYS = "changes the form of the table"


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    q_table.resize((len(q_table) - 2, 3), refcheck=False)
    num_states = len(q_table) // 2
    state, next_state = state % num_states, next_state % num_states
    row = position * num_states + state
    next_row = next_position * num_states + next_state
    possible = [0, 2] if next_position == 1 else [0, 1]
    best = q_table[next_row, possible].max()
    target = reward + gamma * best
    q_table[row, action] += alpha * (target - q_table[row, action])
