"""Closing costs nothing."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "only opening costs"


def reward(price, next_price, side, position, next_position, cost):
    money = 1.0
    if next_position > position:
        money *= 1 - cost
    money *= 1 + side * next_position * (next_price / price - 1)
    return np.log(money)
