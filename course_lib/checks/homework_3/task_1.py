"""Task 1, what the network sees: the last k log returns, scaled by what was known before the first trade."""

import numpy as np

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_3.arrays import ANY, Case, array_from, check_arrays, numbers
from course_lib.checks.homework_3.scaling_mistakes import ROWS_TOO_LATE, VALUE_MISTAKES, WARM_UP_MISTAKES, windows
from course_lib.checks.plain import described

_WANTED = "a row for each close and k columns"


def network_inputs(close, num_train, k):
    """float[T, k]: row t holds the last k log returns up to bar t, over sigma of the training part, clipped."""
    returns = np.diff(np.log(close))
    sigma = np.std(returns[: num_train - 1])
    return windows(np.clip(returns / sigma, -5, 5), k)


def closes(returns):
    """The T + 1 closes that T log returns lead to."""
    return 100 * np.exp(np.cumsum(np.concatenate([[0.0], returns])))


def calm(rng, number, largest):
    """Log returns that rise a little more than they fall; none is as large as two standard deviations."""
    return rng.uniform(-0.9, 1.1, size=number) * largest


def _full_rows(function):
    """The same function, of whose first k rows anything is taken; a result without those rows stays as it is."""

    def full_rows(close, num_train, k):
        rows = np.array(function(close, num_train, k))
        rows[: k if len(rows) == len(close) else 0] = ANY
        return rows

    return full_rows


def _empty_rows(function):
    """The same function, of whose other rows anything is taken."""

    def empty_rows(close, num_train, k):
        rows = np.array(function(close, num_train, k))
        if len(rows) == len(close):
            rows[k:] = ANY
        return rows

    return empty_rows


def _check_full_rows(call, cases):
    mistakes = [(_full_rows(mistake), words) for mistake, words in VALUE_MISTAKES]
    check_arrays(call, cases, _full_rows(network_inputs), mistakes, _WANTED)


def _case(close, num_train, k):
    return Case((close, num_train, k), f"k = {k}, num_train = {num_train}")


def _holds_the_last_returns(call, seed):
    rng = np.random.default_rng(seed)
    settings = (40, 3), (25, 8), (30, 1)
    _check_full_rows(call, [_case(closes(calm(rng, T - 1, 0.3)), T, k) for T, k in settings])


def _leaves_the_warm_up_empty(call, seed):
    rng = np.random.default_rng(seed + 10)
    cases = [_case(closes(calm(rng, T - 1, 0.3)), 20, k) for T, k in ((40, 3), (30, 8), (25, 1))]
    mistakes = [(_empty_rows(mistake), words) for mistake, words in WARM_UP_MISTAKES]
    check_arrays(call, cases, _empty_rows(network_inputs), mistakes, _WANTED)
    for case in cases:
        close, _, k = case.arguments
        rows = array_from(call(*case.arguments).value, _WANTED)
        missing = np.flatnonzero(~np.isfinite(rows[k:]).all(axis=1))
        if len(missing):
            t = k + missing[0]
            raise NotYet(f"{case.name}: row {t} is {numbers(rows[t][:8])}", ROWS_TOO_LATE)


def _takes_sigma_from_the_training_part(call, seed):
    rng = np.random.default_rng(seed + 20)
    cases = []
    for num_train, k in ((30, 4), (20, 2), (45, 8)):
        cases.append(_case(closes([*calm(rng, num_train - 1, 0.15), *calm(rng, 40, 0.4)]), num_train, k))
    _check_full_rows(call, cases)


def _clips_what_is_large(call, seed):
    rng = np.random.default_rng(seed + 30)
    cases = []
    for num_train, k in ((60, 3), (50, 5)):
        returns = calm(rng, num_train + 40, 0.1)
        jumps = rng.permutation(np.arange(num_train, len(returns)))[:8]
        returns[jumps] = rng.choice([-1.0, 1.0], size=8) * rng.uniform(0.5, 1.2, size=8)
        returns[[7, num_train // 2]] = 1.5, -1.2  # sigma is that of the returns as they are
        cases.append(_case(closes(returns), num_train, k))
    _check_full_rows(call, cases)


def _knows_no_future(call, seed):
    rng = np.random.default_rng(seed + 40)
    for num_train, k in ((30, 4), (40, 8)):
        T = num_train + 30
        t = num_train + int(rng.integers(10))  # the last bar that both have in common
        one, other = calm(rng, T - 1, 0.2), calm(rng, T - 1, 0.2)
        other[:t] = one[:t]
        rows = [_rows_of(call, closes(returns), num_train, k) for returns in (one, other)]
        _compare_pasts(*rows, t, k)


def _rows_of(call, close, num_train, k):
    returned = call(close, num_train, k)
    rows = array_from(returned.value, _WANTED)
    if rows.shape != (len(close), k):
        raise NotYet(
            f"k = {k}: {described(rows)}; {(len(close), k)} is right",
            f"the shape is another one than asked for: what is wanted is {_WANTED}.",
        )
    if not np.array_equal(returned.arrays[0], close):
        raise NotYet(
            "after the call `close` is not what it was",
            "your function writes into `close`, which belongs to whoever called it: make a new array.",
        )
    return rows


def _compare_pasts(one, other, t, k):
    """Rows from two markets that are the same up to bar t."""
    differ = ~np.isclose(one, other, 1e-6, 1e-6, equal_nan=True).all(axis=1)
    past = np.flatnonzero(differ[: t + 1])
    if len(past):
        first, last = past[0], past[-1]
        likely = "a row knows of closes that come after its bar. Where does each number in it come from?"
        if first >= t - k and last == t:
            likely = "your rows reach beyond their own bar: the last number of row t is log(close[t] / close[t − 1])."
        elif len(past) > t - k:
            likely = "something that all rows share comes from all closes, such as sigma: take the training part alone."
        became = f"{numbers(one[first][:8])} became {numbers(other[first][:8])}"
        raise NotYet(f"closes changed after bar {t}, and row {first} changed: {became}", likely)
    if not differ[t + 1 :].all():
        later = t + 1 + int(np.flatnonzero(~differ[t + 1 :])[0])
        raise NotYet(
            f"closes changed after bar {t}, and row {later} did not change",
            "your rows do not hold the returns up to their own bar: the last number of row t is "
            "log(close[t] / close[t − 1]).",
        )


scales_by_what_it_may_know = Check(
    "scales_by_what_it_may_know",
    title="Task 1, what the network sees",
    usage="network_inputs(close, num_train, k)",
    trials=[
        Trial(
            "markets with large moves, all of them for training",
            "row t: the last k log returns over sigma, oldest first",
            _holds_the_last_returns,
        ),
        Trial("the first k rows", "NaN, as too few returns are there; a row for each close", _leaves_the_warm_up_empty),
        Trial(
            "markets that turn wild after the training part",
            "sigma of the returns between the first `num_train` closes",
            _takes_sigma_from_the_training_part,
        ),
        Trial("markets with crashes and jumps", "after the division clipped to −5 … 5", _clips_what_is_large),
        Trial(
            "two markets that are the same up to a bar",
            "the same rows up to that bar, and `close` as it was",
            _knows_no_future,
        ),
    ],
    likely={
        "Length of values|could not broadcast|must match|setting an array element|inhomogeneous": "lengths do not fit: "
        "T closes have T − 1 returns, and row t needs the k that end at bar t.",
    },
    hints=[
        "There are T − 1 returns between T closes: `returns = np.diff(np.log(close))`, and `returns[t - 1]` is the one "
        "that ends at bar t.",
        "sigma is one number, known before the first trade: `np.std` of the returns between the first `num_train` "
        "closes. How many returns are that?",
        "Divide first, then clip: `scaled = np.clip(returns / sigma, -5, 5)`.",
        "Begin with `rows = np.full((len(close), k), np.nan)`. Then for each t from k on: "
        "`rows[t] = scaled[t - k : t]`, oldest first.",
    ],
)
