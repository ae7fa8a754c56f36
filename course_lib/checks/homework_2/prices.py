"""Closes made for the purpose: float64[T], with nothing in them that rounding could decide."""

import numpy as np

_NEAR = 1e-6  # of a step between two levels


def closes(returns, first=100.0):
    """The closes that these log returns lead to; a return of 0 leaves a close as it is, to the last bit."""
    return first * np.exp(np.concatenate([[0.0], np.cumsum(returns)]))


def separated(rng, number, *, smallest=0.002, ratio=1.06):
    """Log returns of either sign, no two of which are alike in size: log or simple returns, they rank the same."""
    sizes = smallest * ratio ** rng.permutation(number)
    return sizes * rng.choice([-1, 1], number)


def lively(seed, number=59):
    """A market whose moves have all sizes."""
    return closes(separated(np.random.default_rng(seed), number))


def drowsy(seed, number=60):
    """A market that stands still in about half of its bars, so that a third of its moves is 0 or less in size."""
    rng = np.random.default_rng(seed)
    returns = separated(rng, number)
    returns[rng.permutation(number)[: number // 2]] = 0
    return closes(returns)


def wilder(seed):
    """(closes, num_train): a market with other moves after its training part.

    In training 13 moves are small and 25 are large: the 1/3 quantile lies at a third of the gap between them. Many of
    the later moves lie in the middle of that gap: flat by the quantile of one move more, and for half of them by the
    quantile of all moves.
    """
    rng = np.random.default_rng(seed)
    small, large = np.linspace(0.002, 0.004, 13), np.linspace(0.008, 0.03, 25)
    later = np.concatenate(
        [np.linspace(0.0022, 0.0038, 7), np.linspace(0.0056, 0.0064, 15), np.linspace(0.05, 0.1, 18)]
    )
    sizes = np.concatenate([rng.permutation(np.concatenate([small, large])), [0.07], rng.permutation(later)])
    return closes(sizes * rng.choice([-1, 1], len(sizes))), 1 + len(small) + len(large)


def walk(seed, length, windows):
    """A random walk of that many closes, clear of the edges between levels: windows (number of closes, levels)."""
    return _first_clear(seed, windows, lambda rng: closes(rng.normal(0, 0.01, length - 1)))


def ladder(seed, length, windows, rungs=5):
    """A walk up and down a few prices, so that lows and highs are reached again and again."""

    def climb(rng):
        steps = np.cumsum(rng.choice([-1, 0, 1], length, p=[0.45, 0.1, 0.45])) % (2 * rungs)
        return 100 * 1.013 ** np.minimum(steps, 2 * rungs - steps)

    return _first_clear(seed, windows, climb)


def resting(seed, length, windows, rest):
    """A walk that stands still for `rest` bars in its middle, and at its beginning."""

    def stroll(rng):
        returns = rng.normal(0, 0.01, length - 1)
        middle = length // 2
        returns[:rest] = returns[middle : middle + rest] = 0
        return closes(returns)

    return _first_clear(seed, windows, stroll)


def climbing(seed, length, up):
    """A price that rises in every bar, or falls for up = -1."""
    rng = np.random.default_rng(seed)
    return closes(up * rng.uniform(0.002, 0.02, length - 1))


def _first_clear(seed, windows, make):
    rng = np.random.default_rng(seed)
    while True:
        close = make(rng)
        if all(_is_clear(close, *window) for window in windows):
            return close


def _is_clear(close, number, levels):
    """Whether no close stands so near an edge between two levels of its window that rounding decides which it is."""
    window = np.lib.stride_tricks.sliding_window_view(close, number)
    low, high = window.min(axis=1), window.max(axis=1)
    inner = (window[:, -1] > low) & (window[:, -1] < high)
    step = levels * (window[inner, -1] - low[inner]) / (high - low)[inner]
    return bool((np.abs(step - np.round(step)) > _NEAR).all())


def other_future(close, t, seed):
    """The closes with others after t: as far from them as a market may go, up or down."""
    rng = np.random.default_rng(seed)
    changed = close.copy()
    number = len(close) - t - 1
    drift = rng.choice([-0.05, 0.05])
    changed[t + 1 :] = close[t] * np.exp(np.cumsum(drift + rng.normal(0, 0.02, number)))
    return changed
