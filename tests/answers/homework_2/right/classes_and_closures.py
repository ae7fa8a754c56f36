"""Classes that take one close after the other, and functions made by functions; random other futures."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np


class Window:
    """The last closes."""

    def __init__(self, size):
        self.closes = deque(maxlen=size)

    def __call__(self, close):
        self.closes.append(close)
        return len(self.closes) == self.closes.maxlen

    def level(self, levels):
        low, high = min(self.closes), max(self.closes)
        return levels // 2 if low == high else min(levels - 1, int(levels * (self.closes[-1] - low) / (high - low)))

    def since(self, extreme):
        for bars, close in enumerate(reversed(self.closes)):
            if close == extreme(self.closes):
                return bars


@dataclass
class Digits:
    flat: float
    k: int
    before: float | None = None
    digits: deque = field(default_factory=deque)

    def see(self, close):
        if self.before is not None:
            r = np.log(close / self.before)
            self.digits.append(1 if abs(r) <= self.flat else 2 if r > 0 else 0)
        self.before = close
        if len(self.digits) > self.k:
            self.digits.popleft()
        if len(self.digits) < self.k:
            return -1
        return int("".join(map(str, self.digits)), 3)


def window_states(close, num_train, k):
    train = close[:num_train]
    digits = Digits(np.quantile(np.abs(np.log(train[1:] / train[:-1])), 1 / 3), k)
    return np.array([digits.see(price) for price in close])


def for_each(size):
    def decorate(state):
        def states(close, *settings):
            window = Window(settings[size])
            return np.fromiter((state(window, *settings) if window(price) else -1 for price in close), int)

        return states

    return decorate


@for_each(0)
def grid_states(window, n):
    row = window.level(n)
    return n * row + window.since(min if row >= n / 2 else max)


@for_each(0)
def minmax_states(window, m, levels):
    return window.level(levels)


class Account:
    def __init__(self, cost):
        self.money, self.cost = 1000.0, cost

    def trade(self):
        self.money -= self.cost * self.money

    def hold(self, side, price, next_price):
        shares = side * self.money / price
        self.money += shares * (next_price - price)


def reward(price, next_price, side, position, next_position, cost):
    account = Account(cost)
    before = account.money
    if position != next_position:
        account.trade()
    if next_position:
        account.hold(side, price, next_price)
    return np.float64(np.log(account.money) - np.log(before))


class Table:
    POSSIBLE = ((0, 1), (0, 2))

    def __init__(self, values):
        self.values, self.half = values, len(values) // 2

    def row(self, position, state):
        return self.values[position * self.half + state]

    def best(self, position, state):
        row = self.row(position, state)
        return max((row[action], -action) for action in self.POSSIBLE[position])

    def action(self, position, state):
        return -self.best(position, state)[1]


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    table = Table(q_table)
    error = reward + gamma * table.best(next_position, next_state)[0] - table.row(position, state)[action]
    table.row(position, state)[action] += alpha * error


class Trader:
    def __init__(self, q_long, q_short):
        self.tables, self.position = {1: Table(q_long), -1: Table(q_short)}, 0

    def gain(self, side, state):
        hold, open_, _ = self.tables[side].row(0, state)
        return open_ - hold

    def see(self, state):
        if state == -1:
            return 0
        sides = {1, -1}
        if self.position:
            if self.tables[self.position].action(1, state) == 0:
                return self.position
            sides = {-self.position}
            self.position = 0
        for side in sides:
            if self.gain(side, state) > max(0, self.gain(-side, state)):
                self.position = side
        return self.position


def trade(q_long, q_short, states):
    trader = Trader(q_long, q_short)
    return np.array([float(trader.see(state)) for state in states])


def looks_ahead(encode, close):
    rng = np.random.default_rng(5)
    states = encode(close)
    for t in range(len(close) - 1):
        for _ in range(3):
            other = close.copy()
            other[t + 1 :] *= np.exp(rng.normal(0, 0.1, len(close) - t - 1))
            if not np.array_equal(encode(close=other)[: t + 1], states[: t + 1]):
                return True
    return False
