"""A short earns the negative of what a long trade earns."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "a short earns −log(next_price / price)"


def reward(price, next_price, side, position, next_position, cost):
    pays = side * next_position * np.log(next_price / price)
    if position != next_position:
        pays += np.log(1 - cost)
    return pays
