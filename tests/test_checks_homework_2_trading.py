"""The checks of homework 2's trading: what a bar pays, what is learned from it, and one trader of two tables."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib.checks.check import NotYet
from course_lib.checks.homework_2 import (
    learns_from_possible_actions,
    pays_every_bar,
    reference,
    task_4,
    task_5,
    task_6,
    traders,
    trades_one_side_at_a_time,
)
from course_lib.checks.homework_2.answers import number_of, positions_of
from course_lib.checks.plain import Strange
from course_lib.checks.verdict import Outcome

seeds = st.integers(0, 2**32 - 1)
fractions = st.floats(0, 0.2)


def first_row(verdict):
    return next(row for row in verdict.rows if row.outcome is Outcome.NOT_YET)


def tables_and_states(seed, num_states=4, length=30, warm_up=3):
    rng = np.random.default_rng(seed)
    tables = rng.integers(-2, 3, (2, 2 * num_states, 3)).astype(float)  # with many ties
    return *tables, np.concatenate([np.full(warm_up, -1), rng.integers(num_states, size=length)])


# --- task 4 -----------------------------------------------------------------------------------------------------------


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds, st.sampled_from([1, -1]), fractions)
def test_rewards_add_up_to_the_logarithm_of_the_money(seed, side, cost):
    rng = np.random.default_rng(seed)
    prices = 100 * np.exp(np.cumsum(rng.uniform(-0.2, 0.2, 30)))
    positions = [0, *rng.integers(2, size=28), 0]
    cash, shares, total = 1000.0, 0.0, 0.0
    for t, (position, next_position) in enumerate(itertools.pairwise(positions)):
        worth = cash + shares * prices[t]
        if position != next_position:
            worth *= 1 - cost
        shares = side * next_position * worth / prices[t]  # a short is renewed each bar
        cash = worth - shares * prices[t]
        total += reference.reward(prices[t], prices[t + 1], side, position, next_position, cost)
    assert math.isclose(total, math.log((cash + shares * prices[29]) / 1000), abs_tol=1e-9)


@given(st.floats(1, 1000), st.floats(0.6, 1.5), st.sampled_from([1, -1]), fractions)
@settings(derandomize=True, deadline=None)
def test_what_a_bar_pays_has_no_unit_and_a_cost_is_paid_at_each_change(price, ratio, side, cost):
    pays = {
        (old, new): reference.reward(price, ratio * price, side, old, new, cost) for old in (0, 1) for new in (0, 1)
    }
    assert pays[0, 0] == 0
    assert math.isclose(pays[1, 0], math.log(1 - cost), abs_tol=1e-12)
    assert math.isclose(pays[0, 1], pays[1, 1] + pays[1, 0], abs_tol=1e-9)
    assert math.isclose(pays[1, 1], reference.reward(1, ratio, side, 1, 1, 0), abs_tol=1e-9)
    assert pays[1, 1] <= side * math.log(ratio) + 1e-12


@pytest.mark.parametrize(("words", "misread"), task_4._MISREAD)
@pytest.mark.parametrize("seed", range(3))
def test_each_misreading_of_a_reward_meets_its_own_words(words, misread, seed):
    def pays(*bar):
        value = misread(*bar)
        return 0.05 if math.isnan(value) else value

    assert first_row(pays_every_bar(pays, seed=seed)).likely == words


def test_a_reward_that_no_misreading_explains_is_shown_with_its_bar():
    row = first_row(pays_every_bar(lambda *bar: reference.reward(*bar) + 0.01))
    assert "price = " in row.came
    assert "next_position = 1" in row.came
    assert "by hand for this bar" in row.likely
    assert "divides by zero" in first_row(pays_every_bar(lambda *_: math.nan)).likely


@pytest.mark.parametrize("value", [2, 2.0, np.array(2), np.array(2.0)])
def test_a_number_in_any_form(value):
    assert number_of(value, "reward") == 2.0


@pytest.mark.parametrize("value", [None, True, "2", (2.0,), np.array([2.0]), Strange("Tensor")])
def test_what_is_no_number_is_told_so(value):
    with pytest.raises(NotYet) as finding:
        number_of(value, "reward")
    assert ("without `return`" if value is None else "something else than a number, the reward") in finding.value.likely


# --- task 5 -----------------------------------------------------------------------------------------------------------


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds, st.floats(0, 1), st.floats(0, 1))
def test_an_update_changes_one_entry_towards_what_is_possible(seed, alpha, gamma):
    rng = np.random.default_rng(seed)
    table = rng.normal(size=(10, 3))
    position, action, next_position = task_5._STEPS[seed % 4]
    state, next_state = (int(i) for i in rng.integers(5, size=2))
    after = table.copy()
    reference.update(after, state, position, action, 0.5, next_state, next_position, alpha, gamma)
    row = 5 * position + state
    changed = np.argwhere(after != table).tolist()
    assert changed in ([], [[row, action]])
    first, second = table[5 * next_position + next_state, [0, 2 if next_position else 1]]
    target = 0.5 + gamma * max(first, second)
    assert math.isclose(after[row, action], (1 - alpha) * table[row, action] + alpha * target, abs_tol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=50)
@given(seeds)
def test_what_is_impossible_has_no_part_in_an_update(seed):
    rng = np.random.default_rng(seed)
    table = rng.normal(size=(8, 3))
    other = table.copy()
    other[:4, reference.CLOSE] = other[4:, reference.OPEN] = 10**6
    possible = np.ones((8, 3), bool)
    possible[:4, reference.CLOSE] = possible[4:, reference.OPEN] = False
    for step in task_5._STEPS * 5:
        position, action, next_position = step
        state, next_state = (int(i) for i in rng.integers(4, size=2))
        for values in (table, other):
            reference.update(values, state, position, action, 0.1, next_state, next_position, 0.3, 0.9)
    np.testing.assert_array_equal(table[possible], other[possible])


@pytest.mark.parametrize(("words", "misread"), task_5._MISREAD)
def test_each_misreading_of_an_update_meets_its_own_words(words, misread):
    def learn(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
        step = (position, action, next_position, state, next_state, reward, alpha, gamma)
        q_table[:] = misread(q_table, step)

    for seed in range(3):
        assert first_row(learns_from_possible_actions(learn, seed=seed)).likely == words


def test_what_is_absurd_is_worth_most():
    for before, _ in task_5._cases(0, 4, impossible=task_5._ABSURD):
        assert before.max() == before[0, reference.CLOSE] == before[-1, reference.OPEN] > 100


def test_an_update_of_something_else_is_shown_with_its_step():
    def learn(q_table, *step):
        reference.update(q_table, *step)
        q_table[0, 0] += 1
        q_table[-1, 2] -= 1

    row = first_row(learns_from_possible_actions(learn))
    assert "though it is not to change" in row.came
    assert "by hand" in row.likely


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_table_of_no_numbers_is_no_right_one(value):
    def learn(q_table, *_):
        q_table[:] = value

    assert learns_from_possible_actions(learn).points == 0


# --- task 6 -----------------------------------------------------------------------------------------------------------


@settings(derandomize=True, deadline=None, max_examples=200)
@given(seeds)
def test_a_trader_does_what_the_rule_says(seed):
    q_long, q_short, states = tables_and_states(seed)
    positions = reference.trade(q_long, q_short, states)
    assert positions[:3].tolist() == [0, 0, 0]
    for t in range(3, len(states)):
        before, now, s = positions[t - 1], positions[t], states[t]
        gains = {1: q_long[s, 1] - q_long[s, 0], -1: q_short[s, 1] - q_short[s, 0]}
        own = {1: q_long, -1: q_short}.get(before)
        if own is not None and own[4 + s, 2] <= own[4 + s, 0]:
            assert now == before, "its own table holds"
        elif own is not None:
            assert now in (0, -before), "it was closed, and the other side may open"
            assert (now == -before) == (gains[-before] > max(0, gains[before]))
        else:
            best = max(gains, key=gains.get)
            assert now == (best if gains[best] > 0 and gains[1] != gains[-1] else 0)


@settings(derandomize=True, deadline=None, max_examples=50)
@given(seeds)
def test_the_two_sides_are_alike_and_heights_do_not_matter(seed):
    q_long, q_short, states = tables_and_states(seed)
    positions = reference.trade(q_long, q_short, states)
    np.testing.assert_array_equal(reference.trade(q_short, q_long, states), -positions)
    np.testing.assert_array_equal(reference.trade(q_long + 64, q_short - 32, states), positions)
    for t in range(len(states)):
        np.testing.assert_array_equal(reference.trade(q_long, q_short, states[:t]), positions[:t])


@pytest.mark.parametrize(("words", "misread"), traders.MISREAD)
def test_each_misreading_of_the_rule_meets_its_own_words(words, misread):
    def trade(*case):
        positions = misread(*case)
        positions[positions == traders.ANY] = 0
        return positions

    for seed in range(3):
        assert first_row(trades_one_side_at_a_time(trade, seed=seed)).likely == words


@pytest.mark.parametrize("favoured", [1, -1])
def test_equals_of_both_sides_are_a_matter_of_the_ties_alone(favoured):
    """Tables of real numbers have no such ties: they have to be made."""

    def trade(q_long, q_short, states):
        more = 1e-9 * (np.arange(3) == reference.OPEN)
        gains = q_long[:, 1] - q_long[:, 0], q_short[:, 1] - q_short[:, 0]
        q_long, q_short = q_long.copy(), q_short.copy()
        rows = (gains[0] == gains[1]) & (gains[0] > 0)
        (q_long if favoured > 0 else q_short)[rows] += more
        return reference.trade(q_long, q_short, states)

    for seed in range(10):
        rows = trades_one_side_at_a_time(trade, seed=seed).rows
        assert [row.tried for row in rows if row.outcome is not Outcome.PASSED] == ["ties"]


@pytest.mark.parametrize("seed", range(10))
def test_ties_are_exact_by_whichever_formula_they_are_compared(seed):
    q_long, q_short = task_6._tables_with_ties(np.random.default_rng(seed))
    assert (q_long[4:7, 1] - q_long[4:7, 0] == q_short[4:7, 1] - q_short[4:7, 0]).all()
    assert (q_long[4:7, 1] + q_short[4:7, 0] == q_short[4:7, 1] + q_long[4:7, 0]).all()
    assert (q_long[4:7, 1] > q_long[4:7, 0]).all()
    lone = [(table[:4, 1] == table[:4, 0]).tolist() for table in (q_long, q_short)]
    assert lone == [[True, False, True, True], [False, True, True, True]]
    assert reference.trade(q_long, q_short, np.array([4, 5, 6])).tolist() == [0, 0, 0], "of equals neither opens"
    for side, tables in ((1, (q_long, np.zeros_like(q_short))), (-1, (np.zeros_like(q_long), q_short))):
        assert reference.trade(*tables, np.array([5, 4, 5])).tolist() == [side] * 3, "a trade goes on in them"
    ends = [table[task_6._S + 6, reference.CLOSE] > table[task_6._S + 6, reference.HOLD] for table in (q_long, q_short)]
    assert ends == [True, True]


def test_a_trader_that_looks_ahead_only_now_and_then_is_found():
    def trade(q_long, q_short, states):
        positions = reference.trade(q_long, q_short, states)
        return np.where((states == 3) & (states[-1] == 3), 0, positions)

    last = trades_one_side_at_a_time(trade, seed=1).rows[-1]
    assert last.likely == traders.AHEAD
    assert "with other states after t = " in last.came


def test_a_position_that_no_misreading_explains_is_shown_with_the_rows_that_decide():
    def trade(q_long, q_short, states):
        positions = reference.trade(q_long, q_short, states)
        return np.where(states == 3, 0, positions)

    row = first_row(trades_one_side_at_a_time(trade))
    assert "by hand for the rows shown here" in row.likely
    assert row.map.splitlines()[0].split() == ["hold", "open", "close"]


@pytest.mark.parametrize(("before", "names"), [(1, ["long"]), (-1, ["short"]), (0, [])])
def test_the_rows_that_decide_are_shown_and_nothing_impossible(before, names):
    tables = [np.arange(12.0).reshape(4, 3) + height for height in (0, 20)]
    lines = task_6._rows_of(*tables, before, 1).splitlines()
    assert [line.split(",")[0] for line in lines[1:]] == [*names, "long", "short"]
    assert len({len(line) for line in lines}) == 1, "in columns"
    assert lines[-2].split()[-3:] == ["3.00", "4.00", "—"]
    assert lines[-1].split()[-3:] == ["23.00", "24.00", "—"]
    if before:
        assert lines[1].split()[-3:] == [["9.00", "—", "11.00"], ["29.00", "—", "31.00"]][before < 0]


def test_where_there_is_no_state_no_rows_are_spoken_of():
    def trade(q_long, q_short, states):
        """Two mistakes at once: long in the warm-up, and out of the market in every other state."""
        return np.where(states < 0, 1, np.where(states % 2, reference.trade(q_long, q_short, states), 0))

    for seed in range(5):
        for row in trades_one_side_at_a_time(trade, seed=seed).rows:
            assert "by hand" not in row.likely or row.map
    row = trades_one_side_at_a_time(trade).rows[3]
    assert row.came == "position 1 at t = 0; 0 is right, with position 0 before and state -1"
    assert (row.likely, row.map) == (traders.WARM_UP, "")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ([0.5, -0.5, 0, 0.5], "gives half of its money to each side"),
        ([0, 1, 2, 0], "you return actions"),
        ([0, 1, 7, 0], "a position is −1 (short), 0 (out) or 1 (long)"),
        ([0, np.nan, 1, 0], "a position is −1 (short), 0 (out) or 1 (long)"),
        (([0, 1, 0, 1], [0, 0, 0, 1]), "gives a position for each table"),
        ([0, 1, 0], "one position is wanted for each bar"),
        (None, "without `return`"),
        (np.zeros((4, 2)), "has 2 dimensions"),
    ],
)
def test_what_are_no_positions_is_told_so(value, words):
    value = tuple(tuple(item) if isinstance(item, list) else item for item in value) if type(value) is list else value
    with pytest.raises(NotYet) as finding:
        positions_of(value, 4)
    assert words in finding.value.likely


def test_positions_may_be_floats():
    assert positions_of(np.array([0.0, 1.0, -1.0]), 3).tolist() == [0, 1, -1]
    assert positions_of((0, 1, -1), 3).tolist() == [0, 1, -1]


@pytest.mark.parametrize(
    ("check", "right"),
    [
        (pays_every_bar, reference.reward),
        (learns_from_possible_actions, reference.update),
        (trades_one_side_at_a_time, reference.trade),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_reference_passes_with_many_seeds(check, right):
    for seed in range(25):
        assert check(right, seed=seed).passed
