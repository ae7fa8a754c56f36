"""The bar in which the trade is opened pays nothing."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "a bar pays only if the trade was open before"


def reward(price, next_price, side, position, next_position, cost):
    money = 1.0
    if position != next_position:
        money *= 1 - cost
    money *= 1 + side * position * next_position * (next_price / price - 1)
    return np.log(money)
