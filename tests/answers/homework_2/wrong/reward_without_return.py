"""No return."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "ends without `return`"


def reward(price, next_price, side, position, next_position, cost):
    money = 1.0
    if position != next_position:
        money *= 1 - cost
    money *= 1 + side * next_position * (next_price / price - 1)
    np.log(money)
