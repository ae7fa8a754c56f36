"""Task 5, early stopping: when to end a training, and which of its moments to keep."""

import numpy as np

from course_lib.checks.check import Check, Trial
from course_lib.checks.homework_3.arrays import ANY, Case, check_arrays

_WANTED = "two whole numbers, the stage at which training stopped and the best stage up to then"


def best_moment(validation, patience):
    """(stop, best): training stops once the best score is `patience` stages old, or at the last stage."""
    best = 0
    for stage, score in enumerate(validation):
        if score > validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage, best


def _pair(function):
    """float[2] of a function that gives two numbers."""
    return lambda validation, patience: np.array(function(validation, patience), float)


def _best_of_all(validation, patience):
    return best_moment(validation, patience)[0], validation.argmax()


def _best_of_all_first(validation, patience):
    best = validation.argmax()
    return min(best + patience, len(validation) - 1), best


def _best_of_all_first_and_no_end(validation, patience):
    return validation.argmax() + patience, validation.argmax()


def _never_stops(validation, _):
    return len(validation) - 1, validation.argmax()


def _last(validation, patience):
    stop, _ = best_moment(validation, patience)
    return stop, stop


def _one_stage_later(validation, patience):
    return best_moment(validation, patience + 1)


def _one_stage_sooner(validation, patience):
    return best_moment(validation, patience - 1)


def _last_of_equals(validation, patience):
    best = 0
    for stage, score in enumerate(validation):
        if score >= validation[best]:
            best = stage
        if stage - best >= patience:
            break
    return stage, best


def _last_of_equals_at_the_end(validation, patience):
    stop, _ = best_moment(validation, patience)
    return stop, stop - validation[stop::-1].argmax()


def _exchanged(validation, patience):
    return best_moment(validation, patience)[::-1]


def _minimum(validation, patience):
    return best_moment(-validation, patience)


def _falls_in_a_row(validation, patience):
    falls = 0
    for stage in range(len(validation)):
        falls = falls + 1 if stage and validation[stage] < validation[stage - 1] else 0
        if falls >= patience:
            break
    return stage, validation[: stage + 1].argmax()


def _never_begins_again(validation, patience):
    """The stages without a new best are added up over all of the training."""
    best, worse = 0, 0
    for stage in range(len(validation)):
        if validation[stage] > validation[best]:
            best = stage
        elif stage:
            worse += 1
        if worse >= patience:
            break
    return stage, best


def _best_score(validation, patience):
    stop, best = best_moment(validation, patience)
    return stop, validation[best]


def _stages_from_1(validation, patience):
    stop, best = best_moment(validation, patience)
    return stop + 1, best + 1


def _number_of_stages(validation, patience):
    stop, best = best_moment(validation, patience)
    return stop + 1, best


def _stop_only(validation, patience):
    return best_moment(validation, patience)[0]


def _best_only(validation, patience):
    return best_moment(validation, patience)[1]


def _begins_with_0(first):
    """The best score is 0 before the first stage, and its stage `first`; which one is kept is open."""

    def begins_with_0(validation, patience):
        highest, best = 0.0, first
        for stage, score in enumerate(validation):
            if score > highest:
                highest, best = score, stage
            if stage - best >= patience:
                break
        return stage, ANY

    return begins_with_0


_AGE = "your patience ends one stage too {}: stop at the first stage with `stage - best >= patience`."
_ALL_FIRST = (
    "your function looks for the best of all scores first, and adds `patience`. The best of all scores is not known "
    "yet when the training stops: go through the stages one by one."
)
_EQUALS = "of equal scores you keep the last one: a score is better only if it is higher, `>`."
_FROM_0 = "your best score begins at 0. Scores may all be below that: begin with the first one, `validation[0]`."

_MISTAKES = [
    (_pair(_exchanged), "the two numbers are exchanged: first the stage at which training stopped, then the best."),
    (
        _pair(_best_of_all),
        "your best stage comes from all scores. Those after the stop were never made: look at the ones up to then.",
    ),
    (_pair(_best_of_all_first), _ALL_FIRST),
    (_pair(_best_of_all_first_and_no_end), _ALL_FIRST),
    (_pair(_last), "your function keeps the stage at which training stopped: keep the best one up to then."),
    (_pair(_never_stops), "your training never stops before the last stage: look at the age of the best at each one."),
    (_pair(_one_stage_later), _AGE.format("late")),
    (_pair(_one_stage_sooner), _AGE.format("early")),
    (_pair(_last_of_equals), _EQUALS),
    (_pair(_last_of_equals_at_the_end), _EQUALS),
    (
        _pair(_falls_in_a_row),
        "your function counts falls in a row. What counts is how many stages ago the best score was, whatever the "
        "scores have done since.",
    ),
    (
        _pair(_never_begins_again),
        "your count of stages without a new best goes on after a new best: it begins again at 0.",
    ),
    (_pair(_best_score), "the second number is the best score: what is wanted is its stage."),
    (_pair(_stages_from_1), "your stages count from 1: the first score is that of stage 0."),
    (_pair(_number_of_stages), "the first number is how many stages there were: the first of them is stage 0."),
    (_pair(_begins_with_0(0)), _FROM_0),
    (_pair(_begins_with_0(-1)), _FROM_0),
    (_pair(_minimum), "your function looks for the lowest score: these are gains, and the highest is the best."),
    (_pair(_stop_only), "the best stage is missing: `return stop, best`."),
    (_pair(_best_only), "the stage at which training stopped is missing: `return stop, best`."),
]


def _case(validation, patience):
    return Case((validation, patience), f"patience = {patience}", lambda _: _shown(validation))


def _shown(validation, width=10):
    """The scores as text, ten stages a line."""
    lines = []
    for first in range(0, len(validation), width):
        scores = validation[first : first + width]
        lines.append("stage" + "".join(f"{stage:>7}" for stage in range(first, first + len(scores))))
        lines.append("score" + "".join(f"{score:>7.2f}" for score in scores))
    return "\n".join(lines)


_USUAL = (_best_of_all_first, _falls_in_a_row, _never_stops)  # each is to be told by its own words


def _drawn(draw, unlike):
    """A case that `draw()` gives, drawn again until none of these mistakes would pass, and no two usual ones agree."""
    while True:
        validation, patience = draw()
        right = tuple(best_moment(validation, patience))
        usual = [tuple(mistake(validation, patience)) for mistake in _USUAL]
        wrong = [pair for pair in usual if pair != right]
        if len(set(wrong)) == len(wrong) and all(tuple(mistake(validation, patience)) != right for mistake in unlike):
            return _case(validation, patience)


def _falls(rng, highest, size):
    """Scores float[size] that fall all the way: whoever waits for falls stops among them, and not at the last stage."""
    return highest - np.cumsum(rng.uniform(0.15, 0.3, size=size))


def _check(call, cases, names=()):
    check_arrays(call, cases, _pair(best_moment), _MISTAKES, _WANTED, names=names)


def _stops_after_the_best(call, seed):
    rng = np.random.default_rng(seed)

    def hill():
        scores = np.sort(rng.uniform(0.2, 2.0, size=15))
        peak = int(rng.integers(2, 6))
        return np.concatenate([scores[:peak], scores[peak:][::-1]]), int(rng.integers(2, 5))

    _check(call, [_drawn(hill, [_last, _never_stops, _one_stage_later, _one_stage_sooner]) for _ in range(4)])


def _does_not_look_beyond_the_stop(call, seed):
    rng = np.random.default_rng(seed + 10)

    def second_hill():
        first, second = (np.sort(rng.uniform(low, low + 1, size=9)) for low in (0.2, 1.3))
        return np.concatenate([first[:3], first[3:][::-1], second, _falls(rng, 1.2, 6)]), int(rng.integers(2, 5))

    _check(call, [_drawn(second_hill, [_best_of_all, _never_stops]) for _ in range(4)])


def _counts_the_age_of_the_best(call, seed):
    rng = np.random.default_rng(seed + 20)

    def up_and_down():
        scores = rng.uniform(0.0, 1.0, size=16) + 0.03 * np.arange(16)
        return np.concatenate([scores, _falls(rng, 1.0, 7)]), int(rng.integers(2, 5))

    _check(call, [_drawn(up_and_down, [_falls_in_a_row, _never_begins_again, _last]) for _ in range(6)])


def _takes_negative_scores(call, seed):
    rng = np.random.default_rng(seed + 30)

    def losses():
        scores = rng.uniform(-3.0, -0.5, size=15) + 0.05 * np.arange(15)
        return np.concatenate([scores, _falls(rng, -3.0, 8)]), int(rng.integers(3, 6))

    def stops_as_if_it_began_with_0(validation, patience):
        return _begins_with_0(0)(validation, patience)[0], best_moment(validation, patience)[1]

    _check(call, [_drawn(losses, [stops_as_if_it_began_with_0, _minimum]) for _ in range(4)])


def _keeps_the_first_of_equals(call, seed):
    rng = np.random.default_rng(seed + 40)

    def with_equals():
        scores = rng.uniform(0.0, 1.0, size=15)
        return np.round(np.concatenate([scores, _falls(rng, 0.0, 6)]), 1), int(rng.integers(2, 5))

    _check(call, [_drawn(with_equals, [_last_of_equals, _last_of_equals_at_the_end]) for _ in range(4)])


def _ends_with_the_last_stage(call, seed):
    rng = np.random.default_rng(seed + 50)
    rising = np.sort(rng.uniform(0.2, 2.0, size=8))
    hill = np.concatenate([rising[:5], rising[5:][::-1]])
    _check(call, [_case(rising, 3), _case(hill, 10), _case(rising[:1], 2)], ("validation", "patience"))


stops_by_validation = Check(
    "stops_by_validation",
    title="Task 5, when to stop",
    usage="best_moment(validation, patience)",
    trials=[
        Trial(
            "scores that rise and then fall",
            "the first stage at which the best score is `patience` stages old, and the stage of that score",
            _stops_after_the_best,
        ),
        Trial(
            "scores that rise again after the stop",
            "the best of the scores up to the stop",
            _does_not_look_beyond_the_stop,
        ),
        Trial("scores that go up and down", "the age of the best score counts", _counts_the_age_of_the_best),
        Trial("scores that are all negative", "the highest of them is the best", _takes_negative_scores),
        Trial("scores of which several are equal", "the first of equals is the best", _keeps_the_first_of_equals),
        Trial(
            "patience that lasts to the end, and a single score",
            "a stop at the last stage; `validation` as it was",
            _ends_with_the_last_stage,
        ),
    ],
    hints=[
        "Walk through the scores as the training would: at stage i only the scores up to i are known.",
        "Remember the stage of the best score so far, `best = 0` before the loop. A score is better if it is higher: "
        "`if validation[stage] > validation[best]: best = stage`.",
        "Then ask at each stage, whether there was a new best or not: `if stage - best >= patience: break`.",
        "After the loop `stage` is the one at which it stopped, whether by `break` or at the end: "
        "`return stage, best`.",
    ],
)
