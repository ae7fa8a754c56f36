"""Nothing but the close pays."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "comes only when the trade is closed"


def reward(price, next_price, side, position, next_position, cost):
    if position == 1 and next_position == 0:
        return np.log(1 - cost) + side * np.log(next_price / price)
    return 0.0
