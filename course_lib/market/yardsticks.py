"""What a trader is measured by: those who do nothing, hold, guess, or know the future; and what to count."""

from dataclasses import asdict, dataclass

import numpy as np
import pandas as pd

from course_lib.market.accounting import POSITIONS, RUIN, account, checked_positions, growth_in
from course_lib.market.parts import as_part
from course_lib.market.prices import PriceDataError
from course_lib.validate import whole_number

BARS_PER_YEAR = 252


def flat(part):
    """Who never trades: int8[N] zeros."""
    return np.zeros(len(as_part(part)), np.int8)


def buy_and_hold(part):
    """Who buys on the first bar and waits: int8[N] ones."""
    return np.ones(len(as_part(part)), np.int8)


def oracle(part, *, cost=0.0005, fill=None, sides=(-1, 1)):
    """The positions that make the most of a part, its future known, int8[N]: the bound that nobody passes.

    Exact, by dynamic programming over bars and positions with costs, from the last bar backwards (Bellman, 1957). At no
    cost it earns in every bar the better side's log growth: |log move| of what is held, be it the share or the short.

    sides  1 and -1, or one of them only
    """
    part = as_part(part)
    if not isinstance(sides, (tuple, list, set)) or not sides or any(side not in (1, -1) for side in sides):
        raise PriceDataError(f"sides must be (1,), (-1,) or both, (-1, 1), got {sides!r}")
    growth = growth_in(part, cost, fill)
    goes_on = growth > np.log(RUIN)  # after ruin nothing more is earned
    left_out = [position + 1 for position in POSITIONS if position and position not in sides]
    growth[:, :, left_out] = -np.inf
    best = np.zeros((len(growth), 3), np.int64)
    worth = np.zeros(3)
    for bar in range(len(growth) - 1, -1, -1):
        by_move = growth[bar] + worth * goes_on[bar]
        best[bar] = by_move.argmax(axis=1)
        worth = by_move.max(axis=1)
    positions, held = np.zeros(len(part), np.int8), 1
    for bar in range(len(growth)):
        held = best[bar, held]
        positions[bar] = held - 1
    positions[-1] = positions[-2]
    return positions


def random_shifts(positions, number=200, *, seed=0):
    """The same trading at the wrong times: circular shifts of positions int[N] by 1 to N - 1 bars, int8[number, N].

    They have the trader's trades (but for those at the seam), its holding times, and none of its timing.
    """
    positions = checked_positions(positions)
    if positions.ndim != 1 or len(positions) < 2:
        raise PriceDataError(f"positions must be those of one trader, int[N], got shape {positions.shape}")
    rng = np.random.default_rng(whole_number("seed", seed))
    shifts = rng.integers(1, len(positions), whole_number("number", number, at_least=1))
    return positions[(np.arange(len(positions)) - shifts[:, None]) % len(positions)].astype(np.int8)


def percentile(part, positions, *, number=200, seed=0, cost=0.0005, fill=None):
    """How many of 100 `random_shifts` of a trader's positions end with less money than it (equal ones count half)."""
    part = as_part(part)
    growth = growth_in(part, cost, fill)
    own = account(part, positions, growth=growth).log_equity[-1]
    others = account(part, random_shifts(positions, number, seed=seed), growth=growth).log_equity[:, -1]
    below, equal = np.mean(others < own - 1e-12), np.mean(np.abs(others - own) <= 1e-12)
    return float(100 * (below + equal / 2))


@dataclass(frozen=True, eq=False)
class Metrics:
    """What an account amounts to; arrays where there are several.

    total_return   what 1 unit of money has gained
    sharpe         mean of a bar's return over its standard deviation, times sqrt(252); 0 where nothing ever moves
    max_drawdown   the largest fall from a peak, as a fraction of the peak
    trades         legs
    exposure       share of the bars in which a position is held
    """

    total_return: np.ndarray
    sharpe: np.ndarray
    max_drawdown: np.ndarray
    trades: np.ndarray
    exposure: np.ndarray


def metrics(accounts):
    """`Metrics` of an `Account`."""
    returns = np.expm1(accounts.rewards)
    spread = returns.std(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        sharpe = np.where(spread > 1e-12, returns.mean(axis=-1) / spread, 0.0) * np.sqrt(BARS_PER_YEAR)
    peaks = np.maximum.accumulate(accounts.log_equity, axis=-1)
    return Metrics(
        np.expm1(accounts.log_equity[..., -1]),
        sharpe,
        -np.expm1((accounts.log_equity - peaks).min(axis=-1)),
        accounts.trades,
        np.mean(accounts.positions[..., :-1] != 0, axis=-1),
    )


def scoreboard(part, traders, *, cost=0.0005, fill=None):
    """A table with a row a trader: the median of each of the `Metrics` over its agents, a DataFrame.

    Its columns are return, Sharpe, drawdown, legs and exposure.

    traders  {name: positions int[N] or int[E, N]}
    """
    part = as_part(part)
    growth = growth_in(part, cost, fill)
    if not isinstance(traders, dict):
        raise PriceDataError(f"traders must be a dictionary, {{name: positions}}, got {type(traders).__name__}")
    rows = {}
    for name, positions in traders.items():
        values = asdict(metrics(account(part, positions, growth=growth)))
        rows[name] = {column: float(np.median(value)) for column, value in values.items()}
    short = {"total_return": "return", "sharpe": "Sharpe", "max_drawdown": "drawdown", "trades": "legs"}
    return pd.DataFrame.from_dict(rows, orient="index").rename(columns=short)
