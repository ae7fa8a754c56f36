"""The one accounting: what happens to money held in a position. Environments, yardsticks and metrics all read it."""

from dataclasses import dataclass

import numpy as np

from course_lib.market.parts import as_part
from course_lib.market.prices import PriceDataError, as_price_errors
from course_lib.validate import number

FILLS = ("close", "next_open", "next_close")
POSITIONS = (-1, 0, 1)  # short, flat, long; the index of a position in `log_growth` is position + 1
RUIN = 1e-6  # what is left of the money when a position has lost all of it or more


@dataclass(frozen=True, eq=False)
class Account:
    """What a path of positions made of 1 unit of money, over N bars of a part. A leading axis stands for agents.

    positions   int8[…, N], held from each bar on; 0 after ruin
    rewards     float64[…, N - 1], log growth of the money from each bar to the next, costs paid
    log_equity  float64[…, N], log of the money at each bar, 0 at first: the rewards so far added up
    trades      int64[…], legs, each of which paid the cost
    ruined      bool[…]
    """

    positions: np.ndarray
    rewards: np.ndarray
    log_equity: np.ndarray
    trades: np.ndarray
    ruined: np.ndarray


def log_growth(prices, cost=0.0005, fill=None):
    """Log of what the money grows by from bar t to t + 1, float64[T - 1, 3, 3], by old and new position (plus 1).

    cost   fraction of the money that a leg costs; from long to short are two legs
    fill   where a decision made at the close of bar t is filled: at that "close", at "next_open" or "next_close";
           None: next_open where there are opens, else close

    A position p multiplies the money by 1 + p (after / before - 1): a short is rebalanced each bar to -100 % of the
    money. Filled at the next open, the old position is held from close to open and the new one from open to close.
    Where 1e-6 of the money or less is left, that is ruin, and 1e-6 is what is left.
    """
    return growth_in(as_part(prices), cost, fill)


def growth_in(part, cost, fill):
    """`log_growth` of the own bars of a `Part`."""
    prices = part.prices.iloc[part.first :]
    cost, fill = checked_cost(cost), checked_fill(prices, fill)
    close = prices["close"].to_numpy(float)
    before, after = close[:-1], close[1:]
    entry = {"close": before, "next_close": after}.get(fill)
    if entry is None:
        entry = prices["open"].to_numpy(float)[1:]
    growth = np.empty((len(before), 3, 3))
    for old in POSITIONS:
        for new in POSITIONS:
            held = _held(old, before, entry) * _held(new, entry, after) if old != new else _held(old, before, after)
            growth[:, old + 1, new + 1] = held * (1 - cost) ** abs(new - old)
            lost = (_held(old, before, entry) <= RUIN) | (_held(new, entry, after) <= RUIN)
            growth[lost & (old != new), old + 1, new + 1] = RUIN
    return np.log(np.maximum(growth, RUIN))


def _held(position, before, after):
    return 1 + position * (after / before - 1)


def account(part, positions, *, cost=0.0005, fill=None, growth=None):
    """`Account` of the positions held in a `Part` (or in a whole frame of prices).

    positions  int[…, N], -1, 0 or 1 from each of the part's N bars on; flat before the first. The last one has no bar
               left to earn in and counts for nothing, not even as a trade
    growth     `log_growth` of the part's own bars, if it is at hand
    """
    part = as_part(part)
    positions = checked_positions(positions, len(part))
    if growth is None:
        growth = growth_in(part, cost, fill)
    elif np.shape(growth) != (len(part) - 1, 3, 3):
        raise PriceDataError(
            f"growth must be log_growth of the part's own bars, [{len(part) - 1}, 3, 3], got {[*np.shape(growth)]}"
        )
    held = positions[..., :-1] + 1
    before = np.concatenate([np.ones_like(held[..., :1]), held[..., :-1]], axis=-1)
    rewards = growth[np.arange(len(growth)), before, held]
    hit = rewards <= np.log(RUIN)
    ruined = hit.any(axis=-1)
    if ruined.any():
        over = np.cumsum(hit, axis=-1) - hit > 0  # the bars after the one that ruined
        rewards, held, before = np.where(over, 0.0, rewards), np.where(over, 1, held), np.where(over, 1, before)
    log_equity = np.concatenate([np.zeros_like(rewards[..., :1]), np.cumsum(rewards, axis=-1)], axis=-1)
    trades = np.abs(held.astype(np.int64) - before).sum(axis=-1)
    last = np.where(ruined[..., None], 0, held[..., -1:] - 1)
    shown = np.concatenate([held - 1, last], axis=-1).astype(np.int8)
    return Account(shown, rewards, log_equity, trades, ruined)


def checked_cost(cost):
    with as_price_errors():
        value = number("cost", cost)
    if not 0 <= value <= 0.2:
        raise PriceDataError(
            f"cost is a fraction of the money a leg, from 0 to 0.2 (0.0005 are 5 basis points), got {cost!r}"
        )
    return value


def checked_fill(prices, fill):
    """`fill`, or where None the one that these prices allow."""
    if fill is None:
        return "next_open" if "open" in prices else "close"
    if fill not in FILLS:
        raise PriceDataError(f"fill must be one of {', '.join(FILLS)}, or None, got {fill!r}")
    if fill == "next_open" and "open" not in prices:
        raise PriceDataError("fill='next_open' needs a column open; there is none: use 'close' or 'next_close'")
    return fill


def checked_positions(positions, bars=None):
    """`positions` as int64[…, bars]; bars None: as many as there are."""
    try:
        array = np.asarray(positions)
    except ValueError:
        raise PriceDataError("positions must be one array of whole numbers: these rows have several lengths") from None
    if array.dtype.kind not in "iu" or array.ndim == 0 or array.shape[-1] != (bars or array.shape[-1]):
        each = "a bar" if bars is None else f"for each of {bars} bars"
        raise PriceDataError(f"positions must be whole numbers, one {each}, got {array.dtype}{[*array.shape]}")
    if array.size and (array.min() < -1 or array.max() > 1):
        raise PriceDataError(f"positions must be -1, 0 or 1, got {array.min()} to {array.max()}")
    return array.astype(np.int64)
