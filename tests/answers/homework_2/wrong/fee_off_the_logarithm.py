"""The cost is taken off the logarithm."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "is taken off the logarithm as it is"


def reward(price, next_price, side, position, next_position, cost):
    money = 1.0
    money *= 1 + side * next_position * (next_price / price - 1)
    return np.log(money) - cost * (position != next_position)
