"""The best policy that knows a market's law but not its future."""

import numpy as np

from course_lib.bellman import policy_iteration
from course_lib.market.accounting import checked_cost
from course_lib.market.chain import trader_mdp
from course_lib.market.parts import as_part

_FAR_SIGHT = 0.995  # discount: it looks some 200 bars ahead, further than any of the markets remembers


def optimum(market, part, *, cost=0.0005):
    """Its positions on a part of one of `market`'s own histories, int8[N]; decisions are filled at the close.

    Lesson 2's policy iteration over what is known and what is held, with a discount of 0.995. Exact where the market is
    a finite chain (ladder, day grid, random walk); elsewhere what is known is rounded to a fine grid.
    """
    part = as_part(part)
    mdp = trader_mdp(market.chain, checked_cost(cost))
    q = policy_iteration(mdp, _FAR_SIGHT).q.reshape(3, -1, 3)
    stays = q[np.arange(3), :, np.arange(3)] >= q.max(axis=2) - 1e-9  # of equals it takes the one without a trade
    policy = np.where(stays, np.arange(3)[:, None], q.argmax(axis=2))
    positions, held = np.zeros(len(part), np.int8), 1
    for bar, state in enumerate(market.knowledge(part.prices)[part.first :]):
        held = policy[held, state]
        positions[bar] = held - 1
    return positions
