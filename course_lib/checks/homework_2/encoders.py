"""What the checks of the three encoders share: the states that came, the right ones, and those of a misreading."""

from dataclasses import dataclass

import numpy as np

from course_lib.checks.check import NotYet
from course_lib.checks.homework_2.answers import states_of
from course_lib.checks.homework_2.prices import other_future
from course_lib.checks.homework_2.reference import NO_STATE

_MOST_SHOWN = 9  # closes of a window
ANY = -2  # in a misreading's states: they may be anything there
AHEAD = (
    "your states look ahead: the one at t knows the close at t + 1. In the market that close is not there yet when the "
    "trader decides."
)
DIVIDES = (
    "your code divides by zero, or gives another level than the middle one, where the price stands still: with high = "
    "low the level is {middle}{column}."
)
_LOOKS_AHEAD = (
    "your states look ahead: what stands at t depends on closes that come after t. Is something worked out from all "
    "closes, or shifted the wrong way?"
)


@dataclass(frozen=True)
class Encoder:
    """A way of making states, as a task asks for it, and the ways in which it is misread.

    right      right(close, *settings) -> int[T]
    warm_up    warm_up(*settings): bars without a state at the beginning
    misread    (words, function as `right`) of each misunderstanding, the likeliest first
    worked     worked(case, window): a line with what is worked out from the closes; window the slice that is shown
    """

    right: object
    warm_up: object
    misread: tuple
    worked: object = None

    def check(self, call, cases, otherwise=""):
        """The states are the right ones in each case, a tuple (close, *settings).

        otherwise  what it looks like, where no misreading explains all cases
        """
        tried = [Tried(self, case, self._states(call, case)) for case in cases]
        if all(np.array_equal(one.came, one.right) for one in tried):
            return
        if any((one.came[one.warm_up :] == NO_STATE).all() for one in tried):
            likely = "your function makes no states, or begins with −1 and fills nothing in."
            raise NotYet("−1 in every bar", likely)
        wrong = [one for one in tried if one.wrong.size]
        for likely, misread in self.misread if wrong else ():
            if all(one.is_explained_by(misread) for one in tried):
                wrong[0].say(likely)
        for one in tried:
            _check_warm_up(one.came, one.warm_up)
        self._check_past(call, wrong[0].case)
        wrong[0].say(otherwise)

    def check_past(self, call, cases):
        """No state changes where only closes that come later change."""
        for case in cases:
            warm_up = self.warm_up(*case[1:])
            states = self._states(call, case)
            _check_warm_up(states, warm_up)
            if np.ptp(states[warm_up:]) == 0:
                raise NotYet(f"state {states[-1]} in every bar", "your function does not look at the closes.")
            self._check_past(call, case, states)

    def _check_past(self, call, case, states=None):
        close, *settings = case
        states = self._states(call, case) if states is None else states
        first = max(settings[0] - 1, self.warm_up(*settings)) + 1  # all that is fitted, or a window, is full by then
        for i, t in enumerate(range(first, len(close) - 1, max(1, (len(close) - first) // 12))):
            later = self._states(call, (other_future(close, t, seed=i), *settings))
            changed = np.flatnonzero(later[: t + 1] != states[: t + 1])
            if changed.size:
                raise NotYet(
                    f"the state at t = {changed[-1]} was {states[changed[-1]]}; with other closes after t = {t}, and "
                    f"the same ones up to it, it is {later[changed[-1]]}",
                    AHEAD if (changed == t).all() else _LOOKS_AHEAD,
                )

    def _states(self, call, case):
        close, *settings = case
        return states_of(call(*case).value, len(close), self.warm_up(*settings))


class Tried:
    """One call of an encoder: the states that came beside the right ones, int[T] both."""

    def __init__(self, encoder, case, came):
        self.encoder, self.case, self.came, self.right = encoder, case, came, encoder.right(*case)
        self.warm_up = encoder.warm_up(*case[1:])
        self.wrong = np.flatnonzero(came[self.warm_up :] != self.right[self.warm_up :]) + self.warm_up

    def is_explained_by(self, misread):
        """Whether the states are those of a misreading, after the warm-up, which may be wrong in a way of its own."""
        misread, came = misread(*self.case)[self.warm_up :], self.came[self.warm_up :]
        says_nothing = misread == ANY
        return bool(((misread == came) | says_nothing).all()) and says_nothing.sum() < len(came) / 2

    def say(self, likely):
        """Raise `NotYet` on the first wrong state after the warm-up."""
        t = self.wrong[0]
        window = slice(max(t - self.warm_up, t + 1 - _MOST_SHOWN), t + 1)
        shown = " ".join(f"{price:.2f}" for price in self.case[0][window])
        shown = f"closes up to t = {t}: {'… ' if self.warm_up >= _MOST_SHOWN else ''}{shown}"
        if self.encoder.worked is not None:
            shown += "\n" + self.encoder.worked(self.case, window)
        raise NotYet(f"state {self.came[t]} at t = {t}; {self.right[t]} is right there", likely, shown)


def in_window(close, window, t, over):
    """(low, high) of what was taken for the window: "window", "all" closes, the whole "past", or those "before" t."""
    of = {"window": window, "all": close, "past": close[: t + 1], "before": window[:-1]}[over]
    return of.min(), of.max()


def shifted(states, warm_up):
    """The states of a function that looks one bar ahead."""
    ahead = np.full(len(states), ANY)
    ahead[warm_up:-1] = states[warm_up + 1 :]
    return ahead


def _check_warm_up(states, warm_up):
    """-1 where there is no state yet, and nowhere else."""
    early = np.flatnonzero(states[:warm_up] != NO_STATE)
    if early.size:
        t = early[0]
        likely = "a state stands where there is none yet: the window is not full before."
        if (states[:warm_up] == 0).all():
            likely = "0 stands for the bars before the window is full, and 0 is a state like any other: −1 is wanted."
        elif len(early) == 1 and warm_up > 1:
            likely = "your states begin one bar too early."
        raise NotYet(f"state {states[t]} at t = {t}; the first state is that at t = {warm_up}", likely)
    late = np.flatnonzero(states[warm_up:] == NO_STATE) + warm_up
    if late.size:
        likely = "a state is a number from 0 on: −1 is there for the bars before the window is full, and for no other."
        if late.tolist() == list(range(warm_up, warm_up + late.size)):
            likely = "your states begin too late."
        raise NotYet(f"−1 at t = {late[0]}; there are states from t = {warm_up} on", likely)
