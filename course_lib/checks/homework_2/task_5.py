"""Task 5, Q-learning where not every action is possible: in a trade none opens, out of it none closes."""

from functools import partial

import numpy as np

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_2.reference import CLOSE, HOLD, IN, OPEN, OUT, POSSIBLE
from course_lib.checks.plain import described

_STEPS = ((OUT, HOLD, OUT), (OUT, OPEN, IN), (IN, HOLD, IN), (IN, CLOSE, OUT))  # (position, action, next position)
_ABSURD = 1000.0


def _learned(before, step, *, best="possible", row="position", next_row=None, copies=False, alpha=None, gamma=None):
    """The table after `update`, or after one that has one thing misread.

    best      what is taken of the next row
    row       how the row of (position, state) is numbered; next_row: that of the next state, where it differs
    alpha, gamma  instead of those given
    """
    position, action, next_position, state, next_state, reward, given_alpha, given_gamma = step
    table, num_states = before.copy(), len(before) // 2
    alpha, gamma = given_alpha if alpha is None else alpha, given_gamma if gamma is None else gamma
    rows = {
        "position": lambda position, state: position * num_states + state,
        "pairs": lambda position, state: state * 2 + position,
        "state alone": lambda _, state: state,
        "old position": lambda _, next_state: position * num_states + next_state,
        "the same row": lambda *_: position * num_states + state,
        "the next row": lambda *_: next_position * num_states + next_state,
    }
    here, there = rows[row](position, state), rows[next_row or row](next_position, next_state)
    values, possible = before[there], list(POSSIBLE[next_position])
    future = {
        "possible": values[possible].max(),
        "all": values.max(),
        "possible before": values[list(POSSIBLE[position])].max(),
        "exchanged": values[list(POSSIBLE[1 - next_position])].max(),
        "minimum": values[possible].min(),
        "mean": values[possible].mean(),
        "same action": values[action],
        "hold": values[HOLD],
        "largest in size": np.abs(values[possible]).max(),
        "masked by 0": np.where(np.isin(range(3), possible), values, 0).max(),
    }[best]
    if not copies:
        table[here, action] += alpha * (reward + gamma * future - table[here, action])
    return table


_ROW = "the row of a position and a state is `position * num_states + state`, with num_states = len(q_table) // 2."
_MISREAD = (
    (
        "your function learns in a copy, or not at all: it is to write into `q_table` itself, as in lesson 3.",
        partial(_learned, copies=True),
    ),
    (
        "the maximum goes over impossible actions as well: in a trade nothing can be opened, out of it nothing closed. "
        "What can never be done must not count.",
        partial(_learned, best="all"),
    ),
    (
        "the maximum goes over the actions that were possible before: after the step, `next_position` says which are.",
        partial(_learned, best="possible before"),
    ),
    (
        "the possible actions are exchanged: out of a trade they are hold and open, `[0, 1]`; in a trade they are hold "
        "and close, `[0, 2]`.",
        partial(_learned, best="exchanged"),
    ),
    (
        "an impossible action counts as 0, which is more than a loss: leave it out of the maximum.",
        partial(_learned, best="masked by 0"),
    ),
    (
        "nothing of the next state is in your target: reward + gamma · the best possible value there. The market goes "
        "on, no state is an end.",
        partial(_learned, gamma=0),
    ),
    ("gamma is missing from your target: reward + gamma · the best possible value.", partial(_learned, gamma=1)),
    (f"your rows are numbered by `state * 2 + position`: {_ROW}", partial(_learned, row="pairs")),
    (f"the position has no part in your row: {_ROW}", partial(_learned, row="state alone")),
    (
        "the next row is that of the old position: it is `next_position * num_states + next_state`.",
        partial(_learned, next_row="old position"),
    ),
    (
        "the best value is taken from the row that was left: look it up in the row of the next state.",
        partial(_learned, next_row="the same row"),
    ),
    (
        "the value is written into the row of the next state: it belongs to the row that was left.",
        partial(_learned, row="the next row"),
    ),
    (
        "the target takes the place of the old value: it is to go there a part of the way, by alpha.",
        partial(_learned, alpha=1),
    ),
    ("the smallest value of the next state is taken: the best is the largest.", partial(_learned, best="minimum")),
    (
        "the mean of the possible values is taken: Q-learning takes the best of them.",
        partial(_learned, best="mean"),
    ),
    (
        "your target looks at the same action again: what counts is the best possible one in the next state.",
        partial(_learned, best="same action"),
    ),
    (
        "your target looks at hold only: what counts is the best possible action of the next state.",
        partial(_learned, best="hold"),
    ),
    (
        "the value that is largest in size is taken: −3 is worth less than 1.",
        partial(_learned, best="largest in size"),
    ),
)


def _check(call, cases):
    """The table was learned as the task asks for, in each case (table, step)."""
    came = [_table_after(call, before, step) for before, step in cases]
    right = [_learned(before, step) for before, step in cases]
    wrong = [i for i in range(len(cases)) if not _same(came[i], right[i])]
    if not wrong:
        return
    for likely, misread in _MISREAD:
        if all(_same(came[i], misread(before, step)) for i, (before, step) in enumerate(cases)):
            _say(cases[wrong[0]], came[wrong[0]], right[wrong[0]], likely)
    _say(
        cases[wrong[0]],
        came[wrong[0]],
        right[wrong[0]],
        "your update differs from the one asked for: work out row, target and the new value by hand for this step.",
    )


def _table_after(call, before, step):
    position, action, next_position, state, next_state, reward, alpha, gamma = step
    returned = call(before, state, position, action, reward, next_state, next_position, alpha, gamma)
    after = returned.arrays[0]
    if not isinstance(after, np.ndarray) or after.shape != before.shape:
        raise NotYet(
            f"after the call `q_table` is {described(after)}; it was {described(before)}",
            "your function changes the form of the table: only its numbers are to change.",
        )
    return after


def _say(case, came, right, likely):
    """Raise `NotYet` on the entries that are not what they should be."""
    before, (position, action, next_position, state, next_state, *_) = case
    row, column = np.argwhere(~np.isclose(came, right, rtol=0, atol=1e-9))[0]
    was, became, wanted = (table[row, column] for table in (before, came, right))
    said = f"q_table[{row}, {column}] " + (
        f"stayed {was:.4f}" if became == was else f"went from {was:.4f} to {became:.4f}"
    )
    said += ", though it is not to change" if wanted == was else f"; {wanted:.4f} is right"
    raise NotYet(
        f"{said}, for action {('hold', 'open', 'close')[action]} from (position {position}, state {state}) to "
        f"(position {next_position}, state {next_state})",
        likely,
    )


def _same(table, other):
    return np.allclose(table, other, rtol=0, atol=1e-9)


def _cases(seed, num_states, *, alpha=None, gamma=None, impossible=None):
    """A table and a step of each kind, twice: to where hold is worth less than the other possible action, and more.

    alpha, gamma  drawn for each step where None
    impossible    the value of impossible actions; None: never the best of a row, but better than hold where it can be
    """
    rng = np.random.default_rng(seed)
    cases = []
    for i, (position, action, next_position) in enumerate(_STEPS * 2):
        table = rng.uniform(0.2, 3, (2 * num_states, 3)) * rng.choice([-1, 1], (2 * num_states, 1))
        state, next_state = (int(i) for i in rng.choice(num_states, 2, replace=False))
        is_hold_best = i >= len(_STEPS)
        for rows, other, never in ((table[:num_states], OPEN, CLOSE), (table[num_states:], CLOSE, OPEN)):
            rows[next_state, [HOLD, other]] = np.sort(rows[next_state, [HOLD, other]])[:: -1 if is_hold_best else 1]
            hold, best = rows[:, HOLD], rows[:, other]
            rows[:, never] = np.where(hold < best, (hold + best) / 2, -5) if impossible is None else impossible
        drawn = float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.5, 0.95))
        rates = (drawn[0] if alpha is None else alpha, drawn[1] if gamma is None else gamma)
        cases.append((table, (position, action, next_position, state, next_state, float(rng.normal()), *rates)))
    return cases


def _writes_into_the_right_entry(call, seed):
    _check(call, _cases(seed, 5, gamma=0.0))


def _looks_ahead_by_the_table(call, seed):
    _check(call, _cases(seed, 7))


def _leaves_out_the_impossible(call, seed):
    _check(call, _cases(seed, 4, impossible=_ABSURD) + _cases(seed + 1, 4, impossible=0.0))


def _fits_any_table(call, seed):
    _check(call, [case for number in (2, 3, 64) for case in _cases(seed + number, number, alpha=1.0, gamma=1.0)])


learns_from_possible_actions = Check(
    "learns_from_possible_actions",
    title="Task 5, what can be done next",
    usage="update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma)",
    trials=[
        Trial(
            "gamma = 0: nothing but the reward",
            "one entry goes a part alpha of the way to the reward",
            _writes_into_the_right_entry,
        ),
        Trial(
            "a table in which the impossible is worth little",
            "alpha of the way to reward + gamma · the best of the next row",
            _looks_ahead_by_the_table,
        ),
        Trial(
            "tables in which the impossible is worth most",
            "a maximum over possible actions only",
            _leaves_out_the_impossible,
        ),
        Trial("2, 3 and 64 states, alpha = gamma = 1", "the row of any number of states", _fits_any_table),
    ],
    likely={
        "out of bounds|out of range": "your code looks up a row that the table does not have: the row of a position "
        "and a state is `position * num_states + state`, with num_states = len(q_table) // 2.",
        "object is not callable": "a name of yours hides a function of Python's, such as `max`.",
    },
    hints=[
        "It is lesson 3's update with two changes: a row stands for a position and a state, and only what can be done "
        "next has a part in the maximum. Nothing is terminal.",
        "`num_states = len(q_table) // 2`. The first half of the rows is for position 0, out of the trade, the second "
        "for position 1: `row = position * num_states + state`. The next row is made of `next_state` and "
        "`next_position` in the same way.",
        "Out of a trade (next_position 0) hold and open are possible, columns 0 and 1; in a trade hold and close, "
        "columns 0 and 2.",
        "`possible = [0, 2] if next_position else [0, 1]`, then `best = q_table[next_row, possible].max()`. Write with "
        "`q_table[row, action] += alpha * (reward + gamma * best - q_table[row, action])`; nothing is returned.",
    ],
)
