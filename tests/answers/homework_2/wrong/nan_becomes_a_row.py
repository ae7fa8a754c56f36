"""NaN is turned into an integer where the price stands still."""

import numpy as np

CHECK = "finds_turns_on_a_grid"
SAYS = "divides by zero, or gives another level than the middle one"


def grid_states(close, n):
    windows = np.lib.stride_tricks.sliding_window_view(close, n)
    low, high = windows.min(1), windows.max(1)
    with np.errstate(invalid="ignore"):
        row = np.minimum(n - 1, n * (windows[:, -1] - low) / (high - low)).astype(int)
    newest_first = windows[:, ::-1]
    column = np.where(row >= n / 2, newest_first.argmin(1), newest_first.argmax(1))
    return np.concatenate([np.full(n - 1, -1), row * n + column])
