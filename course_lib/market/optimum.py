"""The best policy that knows a market's law but not its future."""

import numpy as np

from course_lib.bellman import policy_iteration
from course_lib.market.accounting import checked_cost
from course_lib.market.chain import trader_mdp
from course_lib.market.parts import as_part
from course_lib.market.prices import PriceDataError

_FAR_SIGHT = 0.995  # discount: it looks some 200 bars ahead, further than any of the markets remembers


def optimum(market, part, *, cost=0.0005):
    """Its positions on a part of one of `market`'s own histories, int8[N]; decisions are filled at the close.

    Lesson 2's policy iteration over what is known and what is held, with a discount of 0.995. Exact where the market is
    a finite chain (ladder, day grid, random walk); elsewhere what is known is rounded to a fine grid.
    """
    part = as_part(part)
    if not hasattr(market, "chain"):
        raise PriceDataError(f"only of a made-up market, such as LadderMarket(), the law is known, got {market!r}")
    policy = _policy(market, checked_cost(cost))
    positions, held = np.zeros(len(part), np.int8), 1
    for bar, state in enumerate(market.knowledge(part.prices)[part.first :]):
        held = policy[held, state]
        positions[bar] = held - 1
    return positions


def _policy(market, cost):
    """Where to go from each position (plus 1) in each state of knowledge: int64[3, S]; worked out once for a cost."""
    known = vars(market).setdefault("_policies", {})
    if cost not in known:
        q = policy_iteration(trader_mdp(market.chain, cost), _FAR_SIGHT).q.reshape(3, -1, 3)
        stays = q[np.arange(3), :, np.arange(3)] >= q.max(axis=2) - 1e-9  # of equals it takes the one without a trade
        known[cost] = np.where(stays, np.arange(3)[:, None], q.argmax(axis=2))
    return known[cost]
