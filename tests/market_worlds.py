"""What several tests of the market share: prices of every kind, encoders, and money counted in cash and shares."""

import numpy as np
import pandas as pd
from hypothesis import settings
from hypothesis import strategies as st

from course_lib import QAgent
from course_lib.market import (
    CycleMarket,
    DayGridMarket,
    GridEncoder,
    LadderMarket,
    MinMaxEncoder,
    RandomWalkMarket,
    ReturnsEncoder,
    RubberBandMarket,
    SideEnv,
    TrendMarket,
    WindowEncoder,
    action_values,
    trade,
)

FILLS = ("close", "next_open", "next_close")
MARKETS = {
    "ladder": LadderMarket(),
    "day grid": DayGridMarket(),
    "rubber band": RubberBandMarket(),
    "trend": TrendMarket(),
    "cycle": CycleMarket(),
    "random walk": RandomWalkMarket(),
}
ENCODERS = {  # every kind and mode, small
    "window": lambda: WindowEncoder(4),
    "window, flat 0": lambda: WindowEncoder(2, flat=0),
    "window, flat 1 %": lambda: WindowEncoder(3, flat=0.01),
    "grid, turn": lambda: GridEncoder(5),
    "grid, day": lambda: GridEncoder(9, mode="day"),
    "min-max": lambda: MinMaxEncoder(7, levels=4),
    "min-max of training": lambda: MinMaxEncoder(None, levels=6),
    "returns": lambda: ReturnsEncoder(3),
}
often = settings(derandomize=True, deadline=None, max_examples=60)
seldom = settings(derandomize=True, deadline=None, max_examples=25)


def closes(values, start="2020-01-01"):
    """A frame of closes alone, a business day each."""
    values = np.asarray(values, float)
    return pd.DataFrame({"close": values}, index=pd.bdate_range(start, periods=len(values), name="date"))


def bars(opens, close):
    """A frame with all columns, whose highs and lows lie 1 % beyond the others."""
    frame = closes(close)
    opens = np.asarray(opens, float)
    high, low = np.maximum(opens, frame["close"]) * 1.01, np.minimum(opens, frame["close"]) * 0.99
    return frame.assign(open=opens, high=high, low=low, volume=1000.0)


def random_bars(num_bars, seed=0, sigma=0.02):
    """A frame with all columns of a random walk whose bars open anywhere near the close before."""
    rng = np.random.default_rng(seed)
    close = 50 * np.exp(np.cumsum(sigma * rng.standard_normal(num_bars)))
    opens = np.append(close[0], close[:-1]) * np.exp(sigma * rng.standard_normal(num_bars) / 2)
    return bars(opens, close)


# How a price goes on, in 64ths: from almost nothing to the fourfold, so that a short can be ruined (by 2 and more), but
# no money is left that is nearly nothing.
_ratios = st.integers(1, 256).map(lambda k: k / 64) | st.sampled_from([1.0, 1.0, 2.0, 1e-8])


@st.composite
def ruinous_bars(draw, min_bars=2, max_bars=8):
    """Short frames with all columns, in which anything can happen."""
    num_bars = draw(st.integers(min_bars, max_bars))
    opens, close = [1.0], [draw(_ratios)]
    for _ in range(num_bars - 1):
        opens.append(close[-1] * draw(_ratios))
        close.append(opens[-1] * draw(_ratios) if draw(st.booleans()) else close[-1] * draw(_ratios))
    return bars(opens, close)


def positions_for(num_bars, sides=(-1, 0, 1)):
    """Any positions at so many bars."""
    return st.lists(st.sampled_from(sides), min_size=num_bars, max_size=num_bars).map(np.array)


class Pocket:
    """Money, counted slowly: cash, and shares held or owed. A position is all of the money."""

    def __init__(self):
        self.cash, self.shares, self.position, self.legs = 1.0, 0.0, 0, 0

    def worth(self, price):
        return self.cash + self.shares * price

    def go_to(self, position, price, cost):
        """Give the old position back, enter the new one; each of the two takes its fee."""
        self.cash, self.shares = self.worth(price), 0.0
        for leg in range(abs(position - self.position)):
            self.cash -= cost * self.cash
            self.legs += 1
        self.position = position
        self.balance(price)

    def balance(self, price):
        """As many shares as the money is worth: of a long there are as many already."""
        money = self.worth(price)
        self.shares = self.position * money / price
        self.cash = money - self.shares * price


def money_by_hand(prices, positions, cost, fill):
    """(money at each bar, legs, whether ruined) of positions, counted bar by bar in cash and shares."""
    close, opens = prices["close"].tolist(), prices.get("open", prices["close"]).tolist()
    pocket, money = Pocket(), [1.0]
    for t in range(len(close) - 1):
        begun, changes = money[-1], positions[t] != pocket.position
        left = [begun]
        if changes and fill == "close":
            pocket.go_to(positions[t], close[t], cost)
        if changes and fill == "next_open":
            left.append(pocket.worth(opens[t + 1]) / begun)
            pocket.go_to(positions[t], opens[t + 1], cost)
        entered = pocket.worth(opens[t + 1] if changes and fill == "next_open" else close[t])
        left.append(pocket.worth(close[t + 1]) / max(entered, 1e-300))
        if changes and fill == "next_close":
            pocket.go_to(positions[t], close[t + 1], cost)
        money.append(pocket.worth(close[t + 1]))
        if min(left[1:]) <= 1e-6 or money[-1] <= 1e-6 * begun:
            money[-1] = 1e-6 * begun
            return np.array(money + [money[-1]] * (len(close) - len(money))), pocket.legs, True
        pocket.balance(close[t + 1])
    return np.array(money), pocket.legs, False


class LastDigit:
    """A learner's own encoder: the last digit of the rounded price, known from the second bar on."""

    num_states, warmup = 10, 1

    def fit(self, close):  # noqa: ARG002 (nothing to learn)
        return self

    def transform(self, close):
        states = np.round(np.asarray(close)).astype(int) % 10
        states[0] = -1
        return states


class Levels:
    """A learner's own inputs of a network: two numbers of a price."""

    warmup = 0

    def fit(self, close):  # noqa: ARG002 (nothing to learn)
        return self

    def transform(self, close):
        return np.log(np.stack([close, np.asarray(close) / close.iloc[0]], axis=1))


SIGHTS = {
    "table": lambda close: WindowEncoder(2).fit(close),
    "network": lambda close: ReturnsEncoder(3).fit(close),
    "a learner's table": lambda close: LastDigit().fit(close),
    "a learner's network": lambda close: Levels().fit(close),
}


def side_env(prices=None, encoder="table", side=1, **given):
    prices = random_bars(120) if prices is None else prices
    return SideEnv(prices, SIGHTS[encoder](prices["close"]), side=side, **given)


def played(env, actions, seed=0):
    """What `reset` and steps give until the episode is over: observations, rewards, ends, infos."""
    observation, info = env.reset(seed=seed)
    record = [(observation, 0.0, False, False, info)]
    for action in actions:
        record.append(env.step(action))
        if record[-1][2] or record[-1][3]:
            break
    return [list(column) for column in zip(*record, strict=True)]


def learned(part, encoder, *, cost=0.0005, fill=None, passes=50, seed=0):
    """Two tables learned in a part as the course does it, long and short: a `QAgent` each."""
    agents = []
    for side in (1, -1):
        env = SideEnv(part, encoder, side=side, cost=cost, fill=fill, episode_length=min(250, len(part) - 1))
        episodes = passes * len(part) // 250
        agent = QAgent(
            env, gamma=0.95, alpha=1.0, alpha_power=0.6, epsilon=1.0, epsilon_decay=0.1 ** (1 / max(episodes, 1)),
            mask_actions=True, seed=seed,
        )  # fmt: skip
        agent.train(episodes)
        agents.append(agent)
    return agents


def traded(agents, part, encoder):
    """The positions that two agents, long and short, take in a part."""
    return trade(*(action_values(agent, part, encoder) for agent in agents))
