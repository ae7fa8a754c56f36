"""What chance alone makes of a share: traders that toss a coin at every bar, as many as one likes."""

from functools import cache

import numpy as np

from course_lib.market.accounting import RUIN
from course_lib.validate import whole_number


def coin_tossers(env, number=10_000, *, seed=0):
    """Log of what each of so many traders of one side makes of an episode of a `SideEnv`: float64[number].

    Each begins where the environment may, and tosses a coin at every bar: hold, or the other possible action. Compiled;
    it pays what stepping the environment would, to the last bit.
    """
    number, rng = whole_number("number", number, at_least=1), np.random.default_rng(whole_number("seed", seed))
    tape, made = env.unwrapped.tape, np.empty(number)
    _compiled_walk()(tape.gains.reshape(-1), tape.starts, tape.length, np.log(RUIN), rng, made)
    return made


def _walk(gains, starts, length, ruin, rng, made):
    """gains: float64[(N - 1) * 4], by bar, old and new position."""
    for trader in range(len(made)):
        place = np.uint64(4 * int(rng.random() * starts))
        position, total = np.uint64(0), 0.0
        for _ in range(length):
            new = np.uint64(rng.random() * 2)  # one of the two possible actions: hold first, then the other
            if position:
                new = np.uint64(1) - new
            gain = gains[place + np.uint64(2) * position + new]
            total += gain
            if gain <= ruin:
                break
            position = new
            place += np.uint64(4)
        made[trader] = total


@cache
def _compiled_walk():
    from course_lib.kernels import compiled

    return compiled(_walk)
