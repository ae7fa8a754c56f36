"""The check of homework 2's last task: encoders with and without a leak, and ways to look for one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib.checks.homework_2 import finds_the_leak, leaks, task_7
from course_lib.checks.verdict import Outcome

CLEAN, LEAKING = list(task_7._CLEAN), list(task_7._LEAKING)
seeds = st.integers(0, 2**32 - 1)
each_encoder = pytest.mark.parametrize("encoder", CLEAN + LEAKING, ids=lambda encoder: encoder.__name__)
each_clean = pytest.mark.parametrize("encoder", CLEAN, ids=lambda encoder: encoder.__name__)
each_leak = pytest.mark.parametrize("encoder", LEAKING, ids=lambda encoder: encoder.__name__)


def first_row(verdict):
    return next(row for row in verdict.rows if row.outcome is Outcome.NOT_YET)


def by_changing(future):
    """looks_ahead with that other future after every bar: future(close, t)."""

    def looks_ahead(encode, close):
        states = encode(close)
        for t in range(len(close) - 1):
            other = close.copy()
            other[t + 1 :] = future(close, t)
            if (encode(other)[: t + 1] != states[: t + 1]).any():
                return True
        return False

    return looks_ahead


def by_cutting(encode, close):
    states = encode(close)
    return any((encode(close[:t]) != states[:t]).any() for t in range(len(close)))


def backwards_in_place(encode, close):
    """Changes `close` itself, but from its end on, so that the past is always the old one."""
    states = encode(close)
    for t in range(len(close) - 1, 0, -1):
        close[t:] *= 2
        if (encode(close)[:t] != states[:t]).any():
            return True
    return False


def by_going_on(encode, close):
    """Nothing of the closes is changed but what comes after them, with a short beginning as the past."""
    for t in range(1, len(close)):
        longer = np.concatenate([close[:t], 3 * close[: 2 * len(close) - t]])
        if encode(longer)[:t].tolist() != encode(close)[:t].tolist():
            return True
    return False


RNG = np.random.default_rng(0)
WAYS = {
    "twice": by_changing(lambda close, t: 2 * close[t + 1 :]),
    "a tenth more": by_changing(lambda close, t: 1.1 * close[t + 1 :]),
    "half": by_changing(lambda close, t: close[t + 1 :] / 2),
    "ten more": by_changing(lambda close, t: close[t + 1 :] + 10),
    "standing still": by_changing(lambda close, t: close[t]),
    "another price": by_changing(lambda *_: 77.7),
    "NaN": by_changing(lambda *_: np.nan),
    "0": by_changing(lambda *_: 0.0),
    "negative": by_changing(lambda close, t: -close[t + 1 :]),
    "infinite": by_changing(lambda *_: np.inf),
    "any": by_changing(lambda close, t: RNG.uniform(50, 150, len(close) - t - 1)),
    "a walk": by_changing(lambda close, t: close[t] * np.exp(np.cumsum(RNG.normal(0, 0.02, len(close) - t - 1)))),
    "cut": by_cutting,
    "longer": by_going_on,
    "in place": backwards_in_place,
}


@pytest.mark.parametrize("way", WAYS)
def test_every_way_to_look_for_a_leak_passes(way):
    for seed in range(8):
        verdict = finds_the_leak(WAYS[way], seed=seed)
        assert verdict.passed, verdict


@each_encoder
@pytest.mark.parametrize("length", range(9))
def test_an_encoder_takes_closes_of_any_length(encoder, length):
    states = encoder(100 + np.arange(length) % 3)
    assert states.shape == (length,)
    assert states.dtype == np.int64
    assert (states >= -1).all()


@each_encoder
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 0.0, -5.0, 1e300])
def test_an_encoder_takes_closes_that_are_none_without_a_word(encoder, value):
    close = task_7._market(0)
    close[40:] = value
    assert encoder(close).shape == close.shape


@each_clean
@settings(derandomize=True, deadline=None, max_examples=40)
@given(seeds, st.integers(1, 89), st.sampled_from([np.nan, np.inf, 0.0, -1.0, 1e300, None]))
def test_a_clean_encoder_never_looks_ahead(encoder, seed, t, value):
    close = task_7._market(seed)
    states = encoder(close)
    np.testing.assert_array_equal(encoder(close[:t]), states[:t])
    close[t:] = np.random.default_rng(seed).uniform(1, 1000, 90 - t) if value is None else value
    np.testing.assert_array_equal(encoder(close)[:t], states[:t])


@each_leak
@pytest.mark.parametrize("seed", range(10))
def test_a_leak_shows_in_every_market_and_not_everywhere(encoder, seed):
    close = task_7._market(seed)
    states, shows = encoder(close), []
    for t in range(1, len(close)):
        other = close.copy()
        other[t:] *= 2
        shows.append((encoder(other)[:t] != states[:t]).any())
    assert any(shows)
    seldom = encoder in (leaks.now_and_then, leaks.only_at_the_end)
    assert np.mean(shows) < 0.5 if seldom else np.mean(shows) > 0.1


@pytest.mark.parametrize("seed", range(10))
def test_coarse_lows_and_highs_move_with_a_large_change_only(seed):
    close = task_7._market(seed)
    states = leaks.coarse_low_and_high_of_all(close)
    for t in range(1, len(close)):
        for change in (changed(t, 1.001), changed(t, 0.999), changed(t, 1.5, t + 1), changed(t, 1.01)):
            np.testing.assert_array_equal(leaks.coarse_low_and_high_of_all(change(close))[:t], states[:t])
    shows = [(leaks.coarse_low_and_high_of_all(changed(t, 1.1)(close))[:t] != states[:t]).any() for t in range(1, 90)]
    assert np.mean(shows) > 0.3


def test_states_are_many_and_what_looks_random_looks_so():
    close = task_7._market(3)
    for encoder in CLEAN + LEAKING:
        assert len(np.unique(encoder(close))) >= 5, encoder.__name__
    shares = np.bincount(leaks.looks_random(np.exp(np.random.default_rng(0).normal(5, 1, 5000))), minlength=27) / 5000
    assert len(shares) == 27
    assert np.ptp(shares) < 0.03


# --- what is said -----------------------------------------------------------------------------------------------------


def asks(*questions, says):
    """A function that asks about other series and says the same of every encoder."""

    def looks_ahead(encode, close):
        for question in questions:
            encode(question(close))
        return says

    return looks_ahead


def changed(t, factor=2.0, until=None):
    def other(close):
        close = close.copy()
        close[t:until] *= factor
        return close

    return other


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (asks(says=False), "never calls `encode`"),
        (asks(says=True), "never calls `encode`"),
        (asks(np.copy, says=False), "never asks about another future"),
        (asks(np.copy, says=True), "never asks about another future"),
        (asks(changed(0), says=False), "never asks about another future"),
        (asks(np.copy, changed(50), says=True), "only the states up to it have to stay the same"),
        (asks(changed(50, 1 + 1e-12), says=False), "your change is too small"),
        (asks(changed(-1, 1 + 1e-12), says=False), "your change is too small"),
        (asks(changed(-1, 1.0001), says=False), "your function changes the last close only"),
        (asks(*(changed(t, 3) for t in range(1, 90)), says=False), "your function had it before its eyes"),
        (asks(lambda close: close[:50], lambda close: close[:40], says=False), "before its eyes"),
        (asks(lambda close: close[:1], lambda close: close[:2], says=False), "tries 2 of the 89 places"),
        (asks(lambda close: np.append(close, 1.0), says=False), "from t = 90 on, or none, the state at t = 89"),
        (asks(lambda close: 1 / close, says=False), "never asks about another future"),
    ],
)
def test_why_is_read_from_what_was_asked(function, words):
    assert words in first_row(finds_the_leak(function)).likely


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: changed(t, 1.001), "are nearly the one that is given"),
        (lambda t: changed(t, 0.99), "are nearly the one that is given"),
        (lambda t: changed(t, 1.5, t + 1), "changes one close at a time"),
        (lambda t: changed(t, 1.5, t + 2), "changes 2 closes at a time"),
        (lambda t: changed(t, 1.5, t + 7), "none of the futures that your function tries shows it"),
    ],
)
def test_futures_that_show_nothing_are_told_from_places_that_were_not_tried(change, words):
    """A leak by way of all closes, coarsely: at every place, but by changes that do not move it."""
    examined = task_7.Examined(leaks.coarse_low_and_high_of_all, task_7._market(0))
    for t in range(1, 90):
        other = change(t)(examined.close)
        if examined.shows(t, other) is None:
            examined.encode(other)
    assert words in task_7._why_missed(examined)


def test_the_array_that_was_given_may_not_be_changed_where_that_misleads():
    def forgets_the_copy(encode, close):
        states = encode(close)
        return any((encode(changed_in_place(close, t))[:t] != states[:t]).any() for t in range(1, 90))

    def loses_the_past(encode, close):
        return any((encode(changed_in_place(close, t))[:t] != encode(close)[:t]).any() for t in range(1, 90))

    def changed_in_place(close, t):
        close[t:] *= 2
        return close

    assert first_row(finds_the_leak(forgets_the_copy)).likely == task_7._CHANGES_THE_PAST
    assert first_row(finds_the_leak(loses_the_past)).likely == task_7._LOSES_THE_PAST
    assert "close.copy()" in task_7._CHANGES_THE_PAST
    assert "close.copy()" in task_7._LOSES_THE_PAST


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "without `return`"),
        (1, "your function returns a number"),
        (0.0, "your function returns a number"),
        (np.array([True, False]), "one True or False"),
        ("True", "something else than True"),
    ],
)
def test_what_is_neither_true_nor_false(value, words):
    verdict = finds_the_leak(lambda *_: value)
    assert words in first_row(verdict).likely
    assert verdict.points == 0


@pytest.mark.parametrize("answer", [np.bool_, lambda value: np.array(value), bool])
def test_true_and_false_in_any_form(answer):
    assert finds_the_leak(lambda encode, close: answer(by_cutting(encode, close))).passed


@pytest.mark.parametrize("given", [None, "close", 3, [[1.0, 2.0]], [1.0, None, "a"], np.zeros(10**6), {}])
def test_what_are_no_closes_is_refused_in_words(given):
    row = first_row(finds_the_leak(lambda encode, _: bool(encode(given))))
    assert "encode takes an array of at most 900 closes, got " in row.came
    assert "`encode` is given something else than closes" in row.likely


def test_each_encoder_is_looked_at_once_a_check():
    seen = []

    def looks_ahead(encode, close):
        seen.append(encode(close).tobytes())
        return by_cutting(encode, close)

    assert finds_the_leak(looks_ahead).passed
    assert len(seen) == len(set(seen)) == len(CLEAN) + len(LEAKING)


def test_calls_without_end_end_the_check():
    def goes_on(encode, close):
        while True:
            encode(close[:3])

    rows = finds_the_leak(goes_on).rows
    assert "did not stop calling `encode`" in rows[0].came
    assert [row.came for row in rows[1:]] == ["not tried after that"] * 3
