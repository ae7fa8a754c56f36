"""Dollars instead of a ratio."""

CHECK = "pays_every_bar"
SAYS = "your reward is a difference of prices"


def reward(price, next_price, side, position, next_position, cost):
    pays = side * next_position * (next_price - price)
    if position != next_position:
        pays -= cost * price
    return pays
