"""Task 7, find the leak: does an encoder know what comes later?"""

from dataclasses import dataclass, field

import numpy as np

from course_lib.checks.callback import Callback
from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_2 import leaks
from course_lib.checks.homework_2.prices import closes
from course_lib.checks.learner import Fault, Kind
from course_lib.checks.plain import described

_T = 90  # closes of the market that is given
_LONGEST = 10 * _T  # closes that an encoder takes
_MOST_CALLS = 10_000  # enough for a hundred other futures after every bar
_MOST_LOOKED_AT = 500  # of the questions, when it comes to saying why
_TINY, _SMALL = 1e-6, 0.05  # of a price
_FEW = 5  # closes
_CLEAR = 0.25  # of a step between coarse lows or highs
_NEVER_CALLED = "your function never calls `encode`: what an encoder does can only be seen by asking it."
_NEVER_STOPS = (
    f"your function calls `encode` more than {_MOST_CALLS} times: a loop in it goes on, whatever answer it gets. Does "
    "an `except` hide an error?"
)
_NO_OTHER_FUTURE = (
    "your function never asks about another future: change the closes after some t, or leave them out, and call "
    "`encode` again."
)
_CHANGES_THE_PAST = (
    "your function changes `close` itself, so that after the first change the past is no longer the old one either. "
    "Change a copy: `other = close.copy()`."
)
_LOSES_THE_PAST = (
    "your function changes `close` itself, so that the first states, too, are those of the changed prices. Change a "
    "copy: `other = close.copy()`."
)


@dataclass
class Examined:
    """One call of the learner's looks_ahead(encode, close): what it asked the encoder, and what it says."""

    encoder: object
    close: np.ndarray
    asked: list = field(default_factory=list)  # float[n] of each call
    says: object = None
    changes_close: bool = False  # whether the array that it was given is another one afterwards

    def encode(self, close):
        """The encoder as the learner's function calls it."""
        closes_ = _as_closes(close)
        self.asked.append(closes_)
        return self.encoder(closes_)

    def kept(self, other):
        """How many of the closes given are the same, from the first on, in another series."""
        number = min(len(other), len(self.close))
        changed = np.flatnonzero(other[:number] != self.close[:number])
        return int(changed[0]) if changed.size else number

    @property
    def futures(self):
        """(closes kept, series) of each question with another future than that of the closes given, or with less."""
        kept = ((self.kept(other), other) for other in self.asked)
        return [(number, other) for number, other in kept if number > 0 and not _equal(other, self.close)]

    def shows(self, kept, other):
        """The last t up to which the closes are the same and the states are not, or None."""
        states, others = self.encoder(self.close)[:kept], self.encoder(other)[:kept]
        changed = np.flatnonzero(states != others)
        return int(changed[-1]) if changed.size else None


def _equal(close, other):
    return len(close) == len(other) and bool((close == other).all())


def _as_closes(value):
    """What an encoder is given as float[n]; `ValueError` in words for the learner for what is no series."""
    try:
        closes_ = np.array(value, float) if isinstance(value, (np.ndarray, tuple)) else None
    except (TypeError, ValueError):
        closes_ = None
    if closes_ is None or closes_.ndim != 1 or len(closes_) > _LONGEST:
        raise ValueError(f"encode takes an array of at most {_LONGEST} closes, got {described(value)}")
    return closes_


def _market(seed):
    """Closes in which every leak shows, in many places, the coarse one under large changes only: float[T]."""
    rng = np.random.default_rng(seed)
    while True:
        close = closes(rng.normal(0, 0.012, _T - 1))
        steps = leaks.coarse_low_and_high(close)
        if (np.abs(steps - np.round(steps)) > _CLEAR).all():
            return close


def _examine(call, seed, encoder):
    """What the learner's function says of an encoder; done once a check."""

    def work():
        examined = Examined(encoder, _market(seed))

        def encode(close):
            return examined.encode(close)

        try:
            returned = call(Callback(encode, max_calls=_MOST_CALLS), examined.close)
        except Fault as fault:
            if fault.kind is Kind.STEPS_UP:
                raise NotYet(str(fault), _NEVER_STOPS, last=True) from None
            raise
        value, after = returned.value, returned.arrays[0]
        if isinstance(value, np.ndarray) and value.ndim == 0:
            value = value.item()
        if not isinstance(value, bool):
            _say_what_is_wanted(value)
        examined.says = value
        examined.changes_close = not (isinstance(after, np.ndarray) and np.array_equal(after, examined.close))
        return examined

    return call.once(encoder.__name__, work)


def _say_what_is_wanted(value):
    likely = "your function returns something else than True (it looks ahead) or False (it does not)."
    if value is None:
        likely = "your function ends without `return`, at least for this encoder."
    elif isinstance(value, np.ndarray):
        likely = "a comparison of arrays gives an array: `(a != b).any()` is one True or False."
    elif isinstance(value, (int, float)):
        likely = "your function returns a number: True or False is wanted, such as `number > 0`."
    raise NotYet(described(value), likely)


def _told_apart(encoders):
    """A trial: the learner's function says the right thing of each of these encoders."""

    def run(call, seed):
        for examined in [_examine(call, seed, encoder) for encoder in encoders]:
            leak = _LEAKING.get(examined.encoder)
            if leak and not examined.says:
                raise NotYet(f"False of an encoder that looks ahead: {leak}", _why_missed(examined))
            if examined.says and not leak:
                clean = _CLEAN[examined.encoder]
                raise NotYet(f"True of an encoder that does not look ahead: {clean}", _why_suspected(examined))

    return run


def _why_missed(examined):
    futures, close = examined.futures, examined.close
    if not examined.asked:
        return _NEVER_CALLED
    if examined.changes_close:
        return _LOSES_THE_PAST
    if not futures:
        return _NO_OTHER_FUTURE
    for kept, other in futures[:_MOST_LOOKED_AT]:
        t = examined.shows(kept, other)
        if t is not None:
            return (
                f"your function had it before its eyes: with other closes from t = {kept} on, or none, the state at "
                f"t = {t} is another one. Compare all states up to the change, one by one."
            )
    places = sorted({kept for kept, _ in futures})
    if all(_is_nearly(other[kept:], close[kept:]) for kept, other in futures):
        return "your change is too small to move a state: let the future be quite another one."
    if places == [len(close) - 1]:
        return (
            "your function changes the last close only: a leak shows in the states just before a change. Try every t."
        )
    if len(places) < len(close) // 2:
        return (
            f"your function tries {len(places)} of the {len(close) - 1} places at which the future can begin. A leak "
            "may show in a few bars only: try every t."
        )
    most = max(_number_changed(other, close) for _, other in futures)
    if most <= _FEW:
        return (
            f"your function changes {'one close' if most == 1 else f'{most} closes'} at a time: what is worked out "
            "from all closes, such as a quantile, hardly moves then. Change all closes after t."
        )
    if all(_is_nearly(other[kept:], close[kept:], _SMALL) for kept, other in futures):
        return (
            "your futures are nearly the one that is given: some leaks move a state only if the future changes a lot. "
            "Let it be quite another one, twice or half the price."
        )
    if all(_equal(np.sort(other[kept:]), np.sort(close[kept:])) for kept, other in futures):
        return (
            "your other futures are made of the same closes in another order, so that their low and high stay the "
            "same: let the future be quite another one."
        )
    return "none of the futures that your function tries shows it: let them be quite other ones, at every t."


def _is_nearly(future, other, share=_TINY):
    return len(future) == len(other) and bool((np.abs(future / other - 1) < share).all())


def _number_changed(close, other):
    return int((close != other).sum()) if len(close) == len(other) else max(len(close), len(other))


def _why_suspected(examined):
    if not examined.asked:
        return _NEVER_CALLED
    if examined.changes_close:
        return _CHANGES_THE_PAST
    if not examined.futures:
        return _NO_OTHER_FUTURE
    return (
        "what comes after the change may differ, and so may the number of states: only the states up to it have to "
        "stay the same. −1 is a state like the others here."
    )


_CLEAN = {
    leaks.last_moves: "its states are the last three moves.",
    leaks.last_low_and_high: "its states are levels between the low and the high of the last 12 closes.",
    leaks.long_warm_up: "its states are levels between the low and the high of the last 70 closes, −1 before.",
    leaks.looks_random: "its states look random, but are made of the last two closes.",
}
_LEAKING = {
    leaks.one_bar: "the next move is among its digits.",
    leaks.three_bars: "it knows whether the price is higher three bars later.",
    leaks.twenty_bars: "it knows whether the price is higher twenty bars later.",
    leaks.centred: "its window has the newest close in the middle, five before and five after it.",
    leaks.all_lows_and_highs: "its low and high are those of all closes.",
    leaks.coarse_low_and_high_of_all: "its low and high are quantiles of all closes, roughly rounded.",
    leaks.thresholds_of_all: "its thresholds are quantiles of all moves.",
    leaks.now_and_then: "after two moves that are alike the next close has a part in its states.",
    leaks.only_at_the_end: "the last close has a part in its last three states.",
}

finds_the_leak = Check(
    "finds_the_leak",
    title="Task 7, find the leak",
    usage="looks_ahead(encode, close)",
    trials=[
        Trial(
            "the last moves, and the same with the next one",
            "False of the first, True of the second",
            _told_apart([leaks.last_moves, leaks.one_bar]),
        ),
        Trial(
            "windows that end at the newest close, and windows that do not",
            "False where the window ends there, True where it goes on",
            _told_apart(
                [leaks.last_low_and_high, leaks.long_warm_up, leaks.centred, leaks.three_bars, leaks.twenty_bars]
            ),
        ),
        Trial(
            "low, high and thresholds of all closes",
            "True of these; False of states that only look random",
            _told_apart(
                [
                    leaks.looks_random,
                    leaks.all_lows_and_highs,
                    leaks.thresholds_of_all,
                    leaks.coarse_low_and_high_of_all,
                ]
            ),
        ),
        Trial(
            "leaks that show in a few bars only",
            "True of each, however seldom; False where there is none",
            _told_apart([leaks.last_moves, leaks.now_and_then, leaks.only_at_the_end]),
        ),
    ],
    likely={
        "operands could not be broadcast|Lengths must match": "two arrays of different length are compared: of the "
        "longer one take the beginning, `states[: t + 1]`.",
        "truth value of an array|truth value of a Series": "a comparison of arrays gives an array: `(a != b).any()` is "
        "one True or False.",
        "encode takes an array": "`encode` is given something else than closes: it takes one array of them.",
    },
    hints=[
        "A state at t may know the closes up to t. So if you change only closes after t, no state up to t may change. "
        "If one does, the encoder has looked at them.",
        "`states = encode(close)` is what you compare with. Then, for some t, take `other = close.copy()`, change all "
        "of `other[t + 1:]`, and compare `encode(other)[: t + 1]` with `states[: t + 1]`.",
        "Cutting does it too: `encode(close[: t + 1])` may differ from `states[: t + 1]` in no place. But what comes "
        "after t is not compared, since it may well be another one.",
        "One t is not enough: a leak may show in a few bars only, or at the end. Go through every t from 0 to "
        "len(close) − 2, with a future that is quite another one, and return True at the first difference; False "
        "after the loop.",
    ],
)
