"""The checks of homework 2's encoders: what they ask for, what they tell apart, and the closes made for it."""

import itertools
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib import market
from course_lib.checks import homework_2
from course_lib.checks.check import NotYet
from course_lib.checks.homework_2 import prices, reference, task_1, task_2, task_3
from course_lib.checks.homework_2.answers import states_of
from course_lib.checks.homework_2.encoders import AHEAD, ANY, Encoder, Tried
from course_lib.checks.plain import Strange, plain
from course_lib.checks.verdict import Outcome

TASKS = {
    "reads_moves_as_digits": task_1,
    "finds_turns_on_a_grid": task_2,
    "stands_between_low_and_high": task_3,
}
seeds = st.integers(0, 2**32 - 1)
each_task = pytest.mark.parametrize("name", TASKS)


def a_walk(seed, length=40):
    """Closes with ties and with bars that stand still."""
    rng = np.random.default_rng(seed)
    return 100 * 1.01 ** np.cumsum(rng.integers(-1, 2, length))


def first_row(verdict):
    return next(row for row in verdict.rows if row.outcome is Outcome.NOT_YET)


# --- the references ---------------------------------------------------------------------------------------------------


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds, st.integers(1, 5))
def test_a_state_of_digits_says_what_the_last_moves_were(seed, k):
    close = prices.lively(seed, 30)
    states = reference.window_states(close, 20, k)
    flat = np.quantile(np.abs(np.log(close[1:20] / close[:19])), 1 / 3)
    assert states[:k].tolist() == [-1] * k
    for t in range(k, 31):
        digits = [states[t] // 3**i % 3 for i in range(k)]  # the newest first
        for i, digit in enumerate(digits):
            r = np.log(close[t - i] / close[t - i - 1])
            assert digit - 1 == (0 if abs(r) <= flat else np.sign(r))
    assert states.max() < 3**k


def test_a_number_of_digits_is_written_as_humans_write_it():
    assert reference.base_3([1, 0, 2]) == int("102", 3)
    assert reference.base_3([]) == 0


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds, st.integers(2, 9))
def test_a_grid_state_is_a_cell_that_says_where_the_close_stands(seed, n):
    close = a_walk(seed)
    states = reference.grid_states(close, n)
    assert states[: n - 1].tolist() == [-1] * (n - 1)
    for t in range(n - 1, len(close)):
        window = close[t - n + 1 : t + 1]
        row, column = divmod(int(states[t]), n)
        assert 0 <= row < n
        opposite = window.min() if 2 * row >= n else window.max()
        assert close[t - column] == opposite, "so many bars ago was the opposite extreme"
        assert not (close[t - column + 1 : t + 1] == opposite).any(), "and not again since"
        if close[t] == window.max() > window.min():
            assert row == n - 1
        if close[t] == window.min() < window.max():
            assert row == 0
    np.testing.assert_array_equal(states // n, np.where(states < 0, -1, reference.minmax_states(close, n, n)))


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds, st.integers(2, 12), st.integers(1, 11), st.floats(0.01, 1000))
def test_a_level_is_the_share_of_the_way_and_prices_have_no_unit(seed, m, levels, factor):
    close = prices.walk(seed, 40, [(m, levels)])
    states = reference.minmax_states(close, m, levels)
    for t in range(m - 1, 40):
        low, high = close[t - m + 1 : t + 1].min(), close[t - m + 1 : t + 1].max()
        share = (close[t] - low) / (high - low)
        assert 0 <= states[t] < levels
        assert states[t] / levels <= share + 1e-12
        assert share <= (states[t] + 1) / levels + 1e-12
    np.testing.assert_array_equal(reference.minmax_states(factor * close, m, levels), states)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(seeds, st.integers(0, 39))
def test_no_reference_looks_ahead(seed, t):
    close, other = a_walk(seed), a_walk(seed + 1)
    other[: t + 1] = close[: t + 1]
    for states in (
        partial(reference.window_states, num_train=12, k=3),
        partial(reference.grid_states, n=5),
        partial(reference.minmax_states, m=7, levels=4),
    ):
        first = 11 if states.func is reference.window_states else 0  # what is fitted is known from then on
        assert t < first or states(close)[: t + 1].tolist() == states(other)[: t + 1].tolist()


# --- closes made for the purpose --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_moves_that_are_apart_rank_the_same_as_simple_returns(seed):
    for close, num_train in ((prices.lively(seed), 60), prices.wilder(seed)):
        log, simple = np.abs(np.diff(np.log(close))), np.abs(np.diff(close) / close[:-1])
        flat = [np.quantile(sizes[: num_train - 1], 1 / 3) for sizes in (log, simple)]
        np.testing.assert_array_equal(log <= flat[0], simple <= flat[1])
        assert np.abs(log / flat[0] - 1).min() > 1e-2, "no move is at the threshold"


@pytest.mark.parametrize("seed", [0, 1, 2, 1989])
def test_no_trial_asks_for_a_move_that_is_at_the_threshold_but_for_rounding(seed):
    """A tie is 0, to the last bit: a code that lets a little more than `flat` be flat has the same states."""
    asked = []

    def asks(close, num_train, k):
        asked.append((close.copy(), num_train, k))
        return reference.window_states(close, num_train, k)

    assert homework_2.reads_moves_as_digits(asks, seed=seed).passed
    for close, num_train, k in asked:
        sizes, flat = np.abs(np.diff(np.log(close))), reference.threshold(close, num_train)
        assert ((sizes == flat) & (flat == 0) | (np.abs(sizes - flat) > 1e-6)).all()
        encoder = market.WindowEncoder(k).fit(close[:num_train])
        np.testing.assert_array_equal(encoder.transform(close), reference.window_states(close, num_train, k))
    assert len(asked) > 12


@pytest.mark.parametrize("seed", range(10))
def test_in_a_drowsy_market_nothing_but_standing_still_is_flat(seed):
    moves = np.diff(np.log(prices.drowsy(seed)))
    assert np.quantile(np.abs(moves), 1 / 3) == 0
    assert 0.3 < (moves == 0).mean() < 0.7


@pytest.mark.parametrize("seed", range(10))
def test_in_a_wilder_market_each_way_to_take_the_threshold_tells(seed):
    close, num_train = prices.wilder(seed)
    sizes = np.abs(np.diff(np.log(close)))
    flats = [np.quantile(part, 1 / 3) for part in (sizes[: num_train - 1], sizes[:num_train], sizes)]
    flat_moves = [(sizes <= flat).sum() for flat in flats]
    assert len(set(flat_moves)) == 3


@pytest.mark.parametrize("seed", range(5))
def test_ladders_reach_their_extremes_again_and_rests_stand_still(seed):
    close = prices.ladder(seed, 60, [(6, 6)])
    windows = np.lib.stride_tricks.sliding_window_view(close, 6)
    assert ((windows == windows.max(axis=1, keepdims=True)).sum(axis=1) > 1).mean() > 0.2
    still = np.lib.stride_tricks.sliding_window_view(prices.resting(seed, 60, [(4, 4)], rest=7), 4)
    assert (np.ptp(still, axis=1) == 0).sum() >= 4


@settings(derandomize=True, deadline=None, max_examples=50)
@given(seeds, st.integers(0, 58))
def test_another_future_is_another_one(seed, t):
    close = prices.walk(seed, 60, [])
    other = prices.other_future(close, t, seed)
    np.testing.assert_array_equal(other[: t + 1], close[: t + 1])
    assert (other[t + 1 :] != close[t + 1 :]).all()
    assert (other > 0).all()


# --- what is told apart -----------------------------------------------------------------------------------------------


def as_a_learner_would(misread, warm_up):
    """A learner's function with that misreading, and all else right."""

    def states(*case):
        made = np.array(misread(*case))
        made[made == ANY] = 0
        made[: warm_up(*case[1:])] = -1
        return made

    return states


@each_task
def test_each_misreading_meets_its_own_words(name):
    check, encoder = getattr(homework_2, name), TASKS[name]._ENCODER
    for seed, (likely, misread) in itertools.product(range(3), encoder.misread):
        assert first_row(check(as_a_learner_would(misread, encoder.warm_up), seed=seed)).likely == likely


@each_task
def test_the_reference_passes_with_many_seeds(name):
    check = getattr(homework_2, name)
    for seed in range(25):
        assert check(TASKS[name]._ENCODER.right, seed=seed).passed


@each_task
def test_a_mistake_that_is_not_known_is_shown_with_the_closes_it_is_about(name):
    def odd(close, *settings):
        states = TASKS[name]._ENCODER.right(close, *settings)
        return np.where((states > 0) & (np.arange(len(close)) % 7 == 3), states - 1, states)

    row = first_row(getattr(homework_2, name)(odd))
    assert "is right there" in row.came
    assert "by hand" in row.likely
    assert row.map.startswith("closes up to t = ")
    if name == "reads_moves_as_digits":
        close = prices.lively(0)
        _, first, second = np.diff(np.log(close[:4]))  # the first wrong state is that at t = 3
        moves = f"r between them: {first:.5f} {second:.5f}".replace("-", "−")
        assert row.map.splitlines()[1:] == [moves, f"flat = {reference.threshold(close, 60):.5f}"]


@each_task
def test_a_leak_that_is_not_known_is_found_all_the_same(name):
    def leaks(close, *settings):
        states = TASKS[name]._ENCODER.right(close, *settings)
        states[states >= 0] ^= int(close[-1] > close[len(close) // 2])
        return states

    rows = getattr(homework_2, name)(leaks).rows
    assert rows[-1].outcome is Outcome.NOT_YET
    assert any("depends on closes that come after t" in row.likely for row in rows)


@each_task
def test_a_leak_of_one_bar_is_told_as_one(name):
    def leaks(close, *settings):
        states = TASKS[name]._ENCODER.right(close, *settings)
        rises = np.append(close[1:] > close[:-1], False)
        return np.where((states >= 0) & rises, states ^ 1, states)

    rows = getattr(homework_2, name)(leaks).rows
    assert rows[-1].outcome is Outcome.NOT_YET
    assert any(row.likely == AHEAD for row in rows)


def test_a_misreading_that_says_next_to_nothing_explains_nothing():
    close = prices.lively(0)
    right = reference.minmax_states(close, 5, 4)
    says_little = np.where(np.arange(60) < 20, right, ANY)
    encoder = Encoder(reference.minmax_states, lambda m, _: m - 1, ())
    tried = Tried(encoder, (close, 5, 4), right)
    assert tried.is_explained_by(lambda *_: right)
    assert tried.is_explained_by(lambda *_: np.where(np.arange(60) < 40, right, ANY))
    assert not tried.is_explained_by(lambda *_: says_little)


@each_task
def test_what_is_right_but_for_the_warm_up_has_the_point_of_no_row_with_one(name):
    def early(close, *settings):
        states = TASKS[name]._ENCODER.right(close, *settings)
        states[TASKS[name]._ENCODER.warm_up(*settings) - 1] = 5
        return states

    verdict = getattr(homework_2, name)(early)
    assert verdict.points == 0
    assert "the first state is that at t = " in first_row(verdict).came


def test_states_of_one_kind_only_are_not_the_same_past():
    def constant(close, _, k):
        return np.where(np.arange(len(close)) < k, -1, 4)

    last = homework_2.reads_moves_as_digits(constant).rows[-1]
    assert (last.came, last.outcome) == ("state 4 in every bar", Outcome.NOT_YET)


# --- what comes back --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "value",
    [
        [-1, -1, 3, 4, 5],
        (-1, -1, 3, 4, 5),
        np.array([-1, -1, 3, 4, 5], np.int8),
        [np.int16(-1), -1, np.uint8(3), 4, np.array(5)],
    ],
    ids=["list", "tuple", "int8", "mixed"],
)
def test_states_in_any_form(value):
    assert states_of(plain(value), 5, 2).tolist() == [-1, -1, 3, 4, 5]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "ends without `return`"),
        (np.array([-1.0, -1, 3, 4, 5]), "floats, as they come from a division"),
        (np.array([np.nan, np.nan, 3, 4, 5]), "NaN stands where there is no state yet"),
        (np.array([-1, -1, np.nan, 4, 5]), "divides zero by zero"),
        (np.array([-1, -1, np.inf, 4, 5]), "a state is a whole number"),
        (np.array([-1, -1, 0.5, 4, 5]), "a state is a whole number"),
        (np.zeros((5, 1), int), "has 2 dimensions"),
        (np.zeros(3, int), "are cut off"),
        (np.zeros(4, int), "one move less than there are closes"),
        (np.zeros(9, int), "one state is wanted for each bar"),
        ((np.zeros(5, int), np.zeros(5, int)), "several arrays"),
        ([[1], [2, 3]], "several arrays"),
        (np.ones(5, bool), "something else than one state for each bar"),
        (["1"] * 5, "something else than one state for each bar"),
        (3, "something else than one state for each bar"),
        (Strange("Series"), "`.to_numpy()`"),
        (Strange("set"), "something else than an array of numbers"),
    ],
)
def test_what_is_no_row_of_states_is_told_so(value, words):
    with pytest.raises(NotYet) as finding:
        states_of(plain(value) if not isinstance(value, Strange) else value, 5, 2)
    assert words in finding.value.likely
