"""The position before the trade decides."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "that is the position before the trade"


def reward(price, next_price, side, position, next_position, cost):
    money = 1.0
    if position != next_position:
        money *= 1 - cost
    money *= 1 + side * position * (next_price / price - 1)
    return np.log(money)
