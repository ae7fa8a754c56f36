"""Lessons 5 and 7, the trading floor: traders that learn as you look on, or come with their positions."""

from functools import cache, cached_property, lru_cache

import numpy as np

from course_lib import market
from course_lib.explore.controls import Button, Dials, Slider, View
from course_lib.explore.explorer import Explorer
from course_lib.explore.floor import (
    OWN_LINES,
    amount,
    cost_in_words,
    dots_panel,
    judge,
    one_digit,
    price_panel,
    score_panel,
    wealth_panel,
)
from course_lib.market.parts import as_part
from course_lib.q_table import QAgent
from course_lib.validate import whole_number

COSTS = (0.0, 0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01)
BARS, _STEP = 150, 50  # of a price that are seen at once, and from one stop of that slider to the next
TRADERS = 20
_BARS_MADE = 5000
_LEARNING = {"gamma": 0.95, "alpha": 1.0, "alpha_power": 0.6, "epsilon": 1.0, "mask_actions": True}
_PASSES, _EPISODE, _LAST_EPSILON = 50, 250, 0.1

MADE_UP = {
    "rubber band": market.RubberBandMarket(),
    "slack rubber band": market.RubberBandMarket(kappa=0.05),
    "random walk": market.RandomWalkMarket(),
}
MARKETS = (*MADE_UP, "IBM", "MSFT")
EYES = {
    "min-max 60": lambda: market.MinMaxEncoder(60, levels=10),
    "turning grid 8": lambda: market.GridEncoder(8),
    "window 3": lambda: market.WindowEncoder(3),
    "window 8": lambda: market.WindowEncoder(8),
}
DAYS = ("training days", "unseen days")


class _Floor:
    """What both kinds of floor have in common. A kind gives `_look`, which judges what the dials ask for."""

    title = "The trading floor"

    def __init__(self, stops, cost, **at):
        if cost not in COSTS:
            raise ValueError(f"cost must be one of {', '.join(map(str, COSTS))}, got {cost!r}")
        self.dials = Dials(stops | {"cost": ("cost a leg", COSTS, cost_in_words)}, cost=cost, **at)
        self.first = 0
        self._look()

    def turn(self, name, at):
        """Put a slider, choice or switch to its stop number `at`; "from" is the first bar to be seen."""
        if name == "from":
            stops = self._first_bars()
            self.first = stops[whole_number(name, at, below=len(stops))]
            return
        self.dials.turn(name, at)
        self._look()
        self.first = min(self.first, self._first_bars()[-1])

    @property
    def shown(self):
        """The bars of the price that are seen, a slice."""
        return slice(self.first, min(self.first + BARS, len(self.judged.part)))

    def _first_bars(self):
        return range(0, max(len(self.judged.part) - BARS, 0) + _STEP, _STEP)

    def _stretch(self):
        """The slider that moves through the history, where there is more than fits."""
        stops = self._first_bars()
        return (
            (Slider("from", "show from bar", tuple(map(str, stops)), stops.index(self.first)),)
            if len(stops) > 1
            else ()
        )


class TradingFloor(_Floor):
    """Traders that come with their positions, beside those whom they ought to beat, at any cost.

    part       a `market.Part`, or a frame of prices
    positions  {name: int[N] or int[E, N]}, -1, 0 or 1 at each of the part's bars: of one to three traders, or kinds of
               traders with E of them each
    cost       of a leg at first, one of `COSTS`

    judged     of the trader that is looked at, a `floor.Judged`
    """

    def __init__(self, part, positions, *, cost=0.0005):
        if not isinstance(positions, dict) or not 1 <= len(positions) <= len(OWN_LINES):
            got = f"{len(positions)} of them" if isinstance(positions, dict) else f"a {type(positions).__name__}"
            raise ValueError(f"positions must be {{name: positions}} of one to {len(OWN_LINES)} traders, got {got}")
        self.part, self.which = as_part(part), 0
        self.positions = {str(name): self._checked(name, taken) for name, taken in positions.items()}
        stops = {"trader": ("trader", tuple(self.positions)), "all": ("the others beside it", (False, True))}
        super().__init__(stops, cost, trader=next(iter(self.positions)), all=False)

    def turn(self, name, at):
        """As any floor; "which" is the number, from 0, of one of several traders of a kind."""
        if name == "which":
            self.which = whole_number(name, at, below=len(self.positions[self.dials.trader]))
            self._look()
        else:
            super().turn(name, at)

    def press(self, name):
        """There is nothing to press: a `ValueError`."""
        raise ValueError(f"there is no button {name!r}")

    def view(self):
        """Price and trades, what becomes of the money, and what counts."""
        named = [(name, self._judged(name)) for name in self._beside()]
        chosen = self._beside().index(self.dials.trader)
        several = len(self.positions[self.dials.trader])
        controls = []
        if len(self.positions) > 1:
            controls += [self.dials.choice("trader"), self.dials.switch("all")]
        if several > 1:
            texts = tuple(f"{i + 1} of {several}" for i in range(several))
            controls.append(Slider("which", "which of them", texts, min(self.which, several - 1)))
        controls += [self.dials.slider("cost"), *self._stretch()]
        panels = (
            price_panel(self.judged, self.shown),
            wealth_panel(named, self.shown, chosen),
            score_panel(named, self._notes(), chosen),
        )
        return View(tuple(controls), panels, f"{self.dials.trader}: {self.judged.says()}")

    def _look(self):
        self.judged = self._judged(self.dials.trader)

    def _beside(self):
        """The names of the traders that are drawn."""
        return list(self.positions) if self.dials.all else [self.dials.trader]

    def _judged(self, name):
        which = min(self.which, len(self.positions[name]) - 1)
        return self._judge(name, which, self.dials.cost)

    @cached_property
    def _judge(self):
        return cache(lambda name, which, cost: judge(self.part, self.positions[name][which], cost))

    def _notes(self):
        """How many traders of a kind end, where there are several."""
        for name in self._beside():
            if len(self.positions[name]) > 1:
                ends = np.exp(market.account(self.part, self.positions[name], cost=self.dials.cost).log_equity[:, -1])
                low, middle, high = (amount(money) for money in np.percentile(ends, [5, 50, 95]))
                yield f"{name}, all {len(ends)}: 1 dollar becomes {low} to {high} (5 % to 95 %), median {middle}."

    def _checked(self, name, taken):
        """Positions as int[E, N]."""
        try:
            taken = market.account(self.part, taken).positions
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        if taken.ndim > 2 or not taken.size:
            raise ValueError(f"{name}: positions must be int[N] or int[E, N], got {[*taken.shape]}")
        return np.atleast_2d(taken)


class TrainingFloor(_Floor):
    """For each market, eyes and cost two Q-tables learn, long and short, on training days; judged there or unseen.

    They learn as in homework 2, from 60 % of the bars. `press("try")` trains 20 such pairs, step by step: of a made-up
    market each on a history of its own, of a real share all on the only one there is.

    judged   of the trader that is looked at, a `floor.Judged`
    sharpe   its Sharpe ratios in training and on unseen days
    tries    of the traders tried so far with these settings: (Sharpe in training, Sharpe unseen, money made unseen)
    """

    def __init__(self, *, cost=0.0005):
        self._tries, self._at_work = {}, None
        stops = {"market": ("market", MARKETS), "eyes": ("what it sees", tuple(EYES)), "days": ("days", DAYS)}
        super().__init__(stops, cost, market="rubber band", eyes="min-max 60", days="unseen days")

    def press(self, name):
        """Train and judge 20 traders, "try"; what is left to do is an iterator."""
        if name != "try":
            raise ValueError(f"there is the button try, got {name!r}")
        asked = self._asked()
        if len(self.tries) == TRADERS or self._at_work == asked:
            return None
        self._at_work = asked
        return self._try(asked)

    @property
    def tries(self):
        """What has been tried with these settings: [(Sharpe in training, Sharpe unseen, money made unseen)]."""
        return self._tries.get(self._asked(), [])

    def view(self):
        """Price and trades, what becomes of the money, what counts, and training against unseen days."""
        done, at_work = len(self.tries), self._at_work == self._asked()
        controls = (
            self.dials.choice("market"), self.dials.choice("eyes"), self.dials.choice("days"),
            Button("try", f"train {TRADERS} traders", idle=at_work or done == TRADERS),
            self.dials.slider("cost"), *self._stretch(),
        )  # fmt: skip
        named = [("this trader", self.judged)]
        pairs = [pair for *pair, _ in self.tries]
        panels = (
            price_panel(self.judged, self.shown),
            wealth_panel(named, self.shown),
            score_panel(named, [_TRUTH[self.dials.market], *self._tried()]),
            dots_panel(self.sharpe, pairs, f"traders, {self._apart()}"),
        )
        return View(controls, panels, self.message, done / TRADERS if at_work else None)

    def _asked(self):
        return self.dials.market, self.dials.eyes, self.dials.cost

    def _look(self):
        asked, days = self._asked(), DAYS.index(self.dials.days)
        self.judged = judged(*asked, days)
        self.sharpe = result(*asked, 0)[:2]
        known = "Unseen days" if days else "These are the days it has learned from"
        self.message = f"{known}. {self.judged.says()}"

    def _try(self, asked):
        """One trader after the other, until there are enough of them or the learner has moved on."""
        tries = self._tries.setdefault(asked, [])
        try:
            while len(tries) < TRADERS and asked == self._asked():
                tries.append(result(*asked, len(tries)))
                yield
            if asked == self._asked():
                self.message = " ".join(self._tried())
        finally:
            if self._at_work is asked:  # and no newer press
                self._at_work = None

    def _tried(self):
        """What 20 traders came to, where they have been tried."""
        if len(self.tries) < TRADERS:
            return []
        inside, outside, money = np.array(self.tries).T
        results = " and ".join(
            f"{one_digit(days.mean())} ± {days.std():.1f} {where}"
            for days, where in ((inside, "in training"), (outside, "on unseen days"))
        )
        won = f"{np.sum(money > 1)} of them gained money there"
        return [f"{TRADERS} traders, {self._apart()}: Sharpe ratio {results}; {won}."]

    def _apart(self):
        return "each on a market of its own" if self.dials.market in MADE_UP else "each with other dice"


_TRUTH = {
    "rubber band": "There is a pattern: each bar goes a fifth of the way back to 100.",
    "slack rubber band": "There is a weak pattern: each bar goes a twentieth of the way back to 100.",
    "random walk": "There is no pattern. The best one can do is to stay out; a gain on unseen days is luck.",
    "IBM": "Nobody knows whether there is a pattern.",
    "MSFT": "Nobody knows whether there is a pattern.",
}


# --- learning, as homework 2 does it ----------------------------------------------------------------------------------


@lru_cache(maxsize=64)
def judged(name, eyes, cost, days):
    """`floor.Judged`: the trader of `trained` with seed 0 on the training days (days 0) or on unseen ones (1)."""
    parts = parts_of(name, 0)
    return judge((parts.training, parts.test)[days], trained(name, eyes, cost, 0)[days], cost)


@lru_cache(maxsize=512)
def result(name, eyes, cost, seed):
    """(Sharpe ratio in training, Sharpe ratio on unseen days, money made of 1 there) of a trader of `trained`."""
    parts, positions = parts_of(name, seed), trained(name, eyes, cost, seed)
    accounts = [
        market.account(part, taken, cost=cost)
        for part, taken in zip((parts.training, parts.test), positions, strict=True)
    ]
    sharpe = [float(market.metrics(account).sharpe) for account in accounts]
    return *sharpe, float(np.exp(accounts[1].log_equity[-1]))


@lru_cache(maxsize=64)
def trained(name, eyes, cost, seed):
    """The positions in training and on unseen days, (int8[N], int8[M]), of two tables that have learned in training.

    name, eyes: of `MARKETS` and of `EYES`
    """
    parts = parts_of(name, seed)
    encoder = EYES[eyes]().fit(parts.training.close)
    episodes, agents = _PASSES * len(parts.training) // _EPISODE, []
    for side in (1, -1):
        env = market.SideEnv(parts.training, encoder, side=side, cost=cost, episode_length=_EPISODE)
        agent = QAgent(env, **_LEARNING, epsilon_decay=_LAST_EPSILON ** (1 / episodes), seed=seed)
        agent.train(episodes)
        agents.append(agent)
    return tuple(
        market.trade(*(market.action_values(agent, part, encoder) for agent in agents))
        for part in (parts.training, parts.test)
    )


@lru_cache(maxsize=64)
def parts_of(name, seed):
    """`market.Split` of a market's history; of a made-up one there is another for every seed."""
    return market.split(MADE_UP[name].prices(_BARS_MADE, seed=seed) if name in MADE_UP else market.real_prices(name))


def trading_floor(part=None, positions=None, *, cost=0.0005):
    """An explorer of trading: without arguments, of Q-tables that learn as you look on; else of yours, on a part.

    part, positions, cost  as of `TradingFloor`
    """
    if part is None and positions is None:
        return Explorer(TrainingFloor(cost=cost))
    if part is None or positions is None:
        raise ValueError("trading_floor needs both a part and the positions on it, or neither of them")
    return Explorer(TradingFloor(part, positions, cost=cost))
