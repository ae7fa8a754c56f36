"""A short earns what a long trade earns."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "a short is paid as if it were long"


def reward(price, next_price, side, position, next_position, cost):
    money = 1.0
    if position != next_position:
        money *= 1 - cost
    money *= 1 + next_position * (next_price / price - 1)
    return np.log(money)
