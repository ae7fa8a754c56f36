"""Task 4, what a bar pays: the logarithm of what the money becomes, less what a trade costs."""

import itertools
import math

import numpy as np

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_2.answers import number_of
from course_lib.checks.homework_2.reference import reward

ANY = math.nan  # a misreading says nothing of that bar
_ARGUMENTS = ("price", "next_price", "side", "position", "next_position", "cost")
_LONG, _SHORT = 1, -1


def _paying(growth=None, fee=None, held=lambda _, next_position: next_position):
    """`reward` with one thing misread: what a bar in the trade pays, what a trade costs, or which bars are in it.

    growth  growth(ratio, side), ratio = next_price / price
    fee     fee(cost, position, next_position)
    """

    def misread(price, next_price, side, position, next_position, cost):
        pays = growth or (lambda ratio, side: math.log(1 + side * (ratio - 1)))
        costs = fee or (lambda cost, position, next_position: math.log(1 - cost) if position != next_position else 0)
        is_in = held(position, next_position)
        return (pays(next_price / price, side) if is_in else 0) + costs(cost, position, next_position)

    return misread


def _in_prices(price, next_price, side, position, next_position, cost):
    """The difference of two prices, with a fee in any form."""
    return side * next_position * (next_price - price) if position == next_position or cost == 0 else ANY


def _off_the_gain(price, next_price, side, position, next_position, cost):
    """The cost and what the price brings, both in parts of the money at first."""
    return math.log(1 + side * next_position * (next_price / price - 1) - cost * (position != next_position))


def _only_at_the_close(price, next_price, side, position, next_position, cost):  # noqa: ARG001 (the signature)
    """Nothing while the trade lasts; at its end anything, since the price at which it began is not known."""
    return ANY if position != next_position else 0.0


_MISREAD = (
    (
        "your reward comes only when the trade is closed. The table cannot know what it is for then: the price at "
        "which it began is in no state. Each bar that is in the trade pays what it has brought.",
        _only_at_the_close,
    ),
    (
        "your reward is a difference of prices. A share of 1000 would count ten times as much as one of 100: it is the "
        "logarithm of what the money has become, as a ratio.",
        _in_prices,
    ),
    (
        "the logarithm is missing: the rewards of many bars are to add up to log(money at the end / money at first).",
        _paying(lambda ratio, side: side * (ratio - 1)),
    ),
    (
        "your function gives what the money is multiplied by. The reward is the logarithm of that.",
        lambda *bar: math.exp(reward(*bar)),
    ),
    (
        "a short earns −log(next_price / price) in your code. It loses the fraction of its money that the price gains: "
        "log(1 − (next_price / price − 1)).",
        _paying(lambda ratio, side: side * math.log(ratio)),
    ),
    ("a short is paid as if it were long: it gains when the price falls.", _paying(lambda ratio, _: math.log(ratio))),
    (
        "a long trade loses when the price rises: side 1 is long, −1 short.",
        _paying(lambda ratio, side: math.log(1 - side * (ratio - 1))),
    ),
    ("your logarithm is not the natural one: `math.log` or `np.log`.", lambda *bar: math.log10(math.exp(reward(*bar)))),
    ("your logarithm is not the natural one: `math.log` or `np.log`.", lambda *bar: math.log2(math.exp(reward(*bar)))),
    (
        "`position` decides what the bar pays, but that is the position before the trade. The way to next_price is "
        "taken in `next_position`.",
        _paying(held=lambda position, _: position),
    ),
    (
        "a bar pays only if the trade was open before: one that is opened now earns from `price` to `next_price` too.",
        _paying(held=lambda position, next_position: position and next_position),
    ),
    (
        "a bar pays even where the trade is closed: closed at `price`, it earns nothing more up to `next_price`.",
        _paying(held=lambda position, next_position: position or next_position),
    ),
    (
        "a bar out of the trade pays too: with next_position = 0 the money stays what it is.",
        _paying(held=lambda *_: True),
    ),
    ("trades cost nothing in your code: a change of position costs the fraction `cost`.", _paying(fee=lambda *_: 0)),
    (
        "the cost is added: a trade makes the money less, by the factor 1 − cost.",
        _paying(fee=lambda cost, old, new: math.log(1 + cost) if old != new else 0),
    ),
    (
        "the cost is added: a trade makes the money less, by the factor 1 − cost.",
        _paying(fee=lambda cost, old, new: -math.log(1 - cost) if old != new else 0),
    ),
    (
        "the cost is added: a trade makes the money less, by the factor 1 − cost.",
        _paying(fee=lambda cost, old, new: cost if old != new else 0),
    ),
    (
        "`cost` is taken off the logarithm as it is: the money becomes 1 − cost of what it was, so log(1 − cost) is "
        "added.",
        _paying(fee=lambda cost, old, new: -cost if old != new else 0),
    ),
    (
        "the cost is taken off the gain, as log(1 + … − cost). It is taken from all the money first, and then the rest "
        "moves: (1 − cost) · (1 + …).",
        _off_the_gain,
    ),
    *(
        (
            "every bar in the trade costs: only a change of position does, where `position != next_position`.",
            _paying(fee=lambda cost, old, new, pays=pays: math.log(1 - cost) if pays(old, new) else 0),
        )
        for pays in (lambda _, new: new, lambda old, new: old or new)
    ),
    ("every bar costs: only a change of position does.", _paying(fee=lambda cost, *_: math.log(1 - cost))),
    (
        "only opening costs in your code: closing is a trade too.",
        _paying(fee=lambda cost, old, new: math.log(1 - cost) if new > old else 0),
    ),
    (
        "only closing costs in your code: opening is a trade too.",
        _paying(fee=lambda cost, old, new: math.log(1 - cost) if new < old else 0),
    ),
    (
        "a trade costs twice in your code: it is one trade to open and another to close, each costs once.",
        _paying(fee=lambda cost, old, new: 2 * math.log(1 - cost) if new != old else 0),
    ),
)


def _check(call, bars):
    """Each bar pays what is right; bars: tuples of the function's arguments."""
    came = [number_of(call(*bar).value, "reward of the bar") for bar in bars]
    wrong = [i for i, bar in enumerate(bars) if not _same(came[i], reward(*bar))]
    if not wrong:
        return
    likely = "the reward differs from what the task asks for: work it out by hand for this bar."
    if any(not math.isfinite(came[i]) for i in wrong):
        wrong = [i for i in wrong if not math.isfinite(came[i])]
        likely = "your code divides by zero, or takes the logarithm of 0 or of a negative number."
    for words, misread in _MISREAD:
        if all(_same(came[i], misread(*bar)) for i, bar in enumerate(bars)):
            likely = words
            break
    bar = bars[wrong[0]]
    shown = ", ".join(f"{name} = {value:g}" for name, value in zip(_ARGUMENTS, bar, strict=True))
    raise NotYet(f"{came[wrong[0]]:.6f} for {shown}; {reward(*bar):.6f} is right", likely)


def _same(value, other):
    return math.isnan(other) or math.isclose(value, other, rel_tol=0, abs_tol=1e-9)


def _bars(seed, changes, costs, number=2):
    """Bars of both sides with rises and falls that are large enough to tell a logarithm from a return."""
    rng = np.random.default_rng(seed)
    bars = []
    for (position, next_position), cost, side, up in itertools.product(
        changes, costs, (_LONG, _SHORT), (1, -1) * number
    ):
        price = round(float(rng.uniform(20, 400)), 2)
        next_price = round(price * (1 + up * float(rng.uniform(0.05, 0.3))), 2)
        bars.append((price, next_price, side, position, next_position, cost))
    return bars


def _pays_what_is_held(call, seed):
    _check(call, _bars(seed, [(1, 1)], [0.0]))


def _knows_in_from_out(call, seed):
    _check(call, _bars(seed, itertools.product((0, 1), (0, 1)), [0.0]))


def _takes_the_cost(call, seed):
    _check(call, _bars(seed, itertools.product((0, 1), (0, 1)), [0.02, 0.05], number=1))


def _adds_up(call, seed):
    """Along a whole walk with several trades: the sum of all rewards is the logarithm of what became of the money."""
    rng = np.random.default_rng(seed)
    for side in (_LONG, _SHORT):
        prices = [round(float(price), 2) for price in 100 * np.exp(np.cumsum(rng.normal(0, 0.08, 25)))]
        positions = [0, *(int(rng.random() < 0.6) for _ in prices[2:]), 0]
        bars = [
            (price, next_price, side, position, next_position, 0.01)
            for (price, next_price), (position, next_position) in zip(
                itertools.pairwise(prices), itertools.pairwise(positions), strict=True
            )
        ]
        _check(call, bars)


pays_every_bar = Check(
    "pays_every_bar",
    title="Task 4, what a bar pays",
    usage="reward(price, next_price, side, position, next_position, cost)",
    trials=[
        Trial(
            "trades that are held for a bar, without cost",
            "log of what the money is multiplied by, for long and short",
            _pays_what_is_held,
        ),
        Trial(
            "trades that are opened, closed, held, or not there",
            "a bar pays if `next_position` is 1",
            _knows_in_from_out,
        ),
        Trial("the same with a cost", "log(1 − cost) more where the position changes", _takes_the_cost),
        Trial(
            "many bars in a row, long and short",
            "rewards that add up to log(money at the end / money at first)",
            _adds_up,
        ),
    ],
    likely={
        "math domain error": "your code takes the logarithm of 0 or of a negative number.",
        "ZeroDivision|division by zero": "your code divides by zero: no price is 0 here, but a position or a "
        "difference of prices may be.",
    },
    hints=[
        "Think of money: begin with 1. What is left of it after the trade at `price`, if there is one? What does it "
        "become on the way to `next_price`, if the trade is open then? The reward is the logarithm of the result.",
        "A change of position costs: the money is multiplied by 1 − cost. That is so for opening and for closing, and "
        "never for holding.",
        "The way to `next_price` counts with `next_position`. A long trade multiplies the money by next_price / price, "
        "which is 1 + (next_price / price − 1); a short one by 1 − (next_price / price − 1).",
        "Both sides in one line: `money *= 1 + side * next_position * (next_price / price - 1)`. With a next_position "
        "of 0 it changes nothing. At the end `return math.log(money)`.",
    ],
)
