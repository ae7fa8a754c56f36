"""Returns rows and columns."""

import numpy as np

CHECK = "finds_turns_on_a_grid"
SAYS = "your function returns several arrays"


def grid_states(close, n):
    rows = np.full(len(close), -1)
    columns = np.full(len(close), -1)
    for t in range(n - 1, len(close)):
        window = close[t - n + 1 : t + 1]
        low, high = window.min(), window.max()
        if high == low:
            row = n // 2
        else:
            row = min(n - 1, int(n * (close[t] - low) / (high - low)))
        if row >= n / 2:
            column = window[::-1].argmin()
        else:
            column = window[::-1].argmax()
        rows[t], columns[t] = row, column
    return rows, columns
