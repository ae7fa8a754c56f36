"""The cost is taken off what the price brings."""

import numpy as np

CHECK = "pays_every_bar"
SAYS = "the cost is taken off the gain, as log(1 + … − cost)"


def reward(price, next_price, side, position, next_position, cost):
    gain = side * next_position * (next_price / price - 1)
    paid = cost if position != next_position else 0
    return np.log(1 + gain - paid)
