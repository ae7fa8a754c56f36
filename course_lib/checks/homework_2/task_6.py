"""Task 6, two tables and one trader: it is long, short, or out."""

import numpy as np

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_2.answers import positions_of
from course_lib.checks.homework_2.reference import CLOSE, HOLD, NO_STATE, OPEN, trade
from course_lib.checks.homework_2.traders import AHEAD, ANY, MISREAD, WARM_UP

_S = 12  # states of the tables here
_IMPOSSIBLE = {"out of it": CLOSE, "in a trade": OPEN}
_NEVER_TRADES = "your trader never trades: it begins with position 0, and opens nothing."


def _check(call, cases, otherwise=""):
    """The positions are the right ones in each case (q_long, q_short, states)."""
    came = [positions_of(call(*case).value, len(case[-1])) for case in cases]
    right = [trade(*case) for case in cases]
    wrong = [i for i in range(len(cases)) if not np.array_equal(came[i], right[i])]
    if not wrong:
        return
    likely = otherwise or "the decision differs from the one asked for: work it out by hand for the rows shown here."
    if not any(positions.any() for positions in came):
        likely = _NEVER_TRADES
    else:
        for words, misread in MISREAD:
            if all(_explains(misread(*case), came[i]) for i, case in enumerate(cases)):
                likely = words
                break
        else:
            early = [i for i in wrong if _is_in_the_warm_up(cases[i], came[i], right[i])]
            if early:
                likely, wrong = WARM_UP, early
    _say(cases[wrong[0]], came[wrong[0]], right[wrong[0]], likely)


def _is_in_the_warm_up(case, came, right):
    """Whether the first wrong position is that of a bar without a state, for which there are no rows to show."""
    return case[-1][np.flatnonzero(came != right)[0]] == NO_STATE


def _explains(misread, came):
    return bool(((misread == came) | (misread == ANY)).all())


def _say(case, came, right, likely):
    """Raise `NotYet` on the first wrong position."""
    q_long, q_short, states = case
    t = int(np.flatnonzero(came != right)[0])
    before = 0 if t == 0 else int(right[t - 1])
    said = (
        f"position {came[t]:.0f} at t = {t}; {right[t]} is right, with position {before} before and state {states[t]}"
    )
    raise NotYet(said, likely, "" if states[t] == NO_STATE else _rows_of(q_long, q_short, before, states[t]))


def _rows_of(q_long, q_short, before, state):
    """The rows that may decide, as a small table: in a trade its own, and those for what may be opened after it."""
    tables, shown = {1: ("long", q_long), -1: ("short", q_short)}, [f"{'':<17}    hold    open   close"]
    rows = [(tables[before][0], "in a trade", tables[before][1][len(q_long) // 2 + state])] if before else []
    rows += [(name, "out of it", table[state]) for name, table in tables.values()]
    for name, where, row in rows:
        values = ["—" if action == _IMPOSSIBLE[where] else f"{value:.2f}" for action, value in enumerate(row)]
        shown.append(f"{f'{name}, {where}':<17}" + "".join(f"{value:>8}" for value in values))
    return "\n".join(shown)


def _tables(rng, lasting, *, flips=False):
    """Two tables float[2 S, 3] at different heights, whose impossible actions are often the best.

    lasting  the share of states in which a trade goes on
    flips    whether a side may want to open in a state in which a trade ends
    """
    tables, ends = [], np.zeros(_S, bool)
    for height in rng.permutation([-1.5, 1.5]):
        table = rng.normal(0, 1, (2 * _S, 3)) + height + rng.normal(0, 1, (2 * _S, 1))
        holds = rng.random(_S) < lasting
        table[_S:, CLOSE] = table[_S:, HOLD] + np.where(holds, -1, 1) * rng.uniform(0.1, 1, _S)
        ends |= ~holds
        tables.append(table)
    if not flips:
        for table in tables:
            table[:_S][ends, OPEN] = table[:_S][ends, HOLD] - rng.uniform(0.1, 1, ends.sum())
    return tables


def _states(rng, number, warm_up=0):
    return np.concatenate([np.full(warm_up, NO_STATE), rng.integers(_S, size=number - warm_up)])


def _opens_the_better_side(call, seed):
    rng = np.random.default_rng(seed)
    _check(call, [(*_tables(rng, 1.0), _states(rng, 3)) for _ in range(40)])


def _closes_by_its_own_table(call, seed):
    rng = np.random.default_rng(seed + 1)
    _check(call, [(*_tables(rng, 0.6), _states(rng, 80)) for _ in range(4)])


def _turns_round_in_one_bar(call, seed):
    rng = np.random.default_rng(seed + 2)
    _check(call, [(*_tables(rng, 0.4, flips=True), _states(rng, 80)) for _ in range(8)])


def _waits_for_a_state(call, seed):
    rng = np.random.default_rng(seed + 3)
    cases = []
    for warm_up in (1, 7, 12):
        tables = _tables(rng, 0.7)
        tables[int(rng.integers(2))][-1, [HOLD, OPEN, CLOSE]] = -9, 9, -10  # what `table[-1]` says
        cases.append((*tables, _states(rng, 40, warm_up)))
    _check(call, cases)


def _holds_at_a_tie(call, seed):
    rng = np.random.default_rng(seed + 4)
    _check(
        call,
        [(*_tables_with_ties(rng), _states(rng, 120)) for _ in range(3)],
        "a tie is no reason to act: q[open] > q[hold] opens, q[close] > q[hold] closes, and of equal advantages "
        "neither side opens.",
    )


def _tables_with_ties(rng):
    """Tables whose ties are exact, by whichever formula two values or two advantages are compared.

    States 0 to 3: opening is worth as much as holding, for one side while the other loses, or for both. States 4 to 6:
    both sides gain, and gain the same; a trade goes on in 4 and 5 and ends in 6. States 0, 2, 4: closing is a tie.
    """
    tables = _tables(rng, 0.6)
    advantages = np.array([[0, -0.5], [-0.5, 0], [0, 0], [0, 0], [0.5, 0.5], [1.25, 1.25], [0.75, 0.75]])
    for table, gains in zip(tables, advantages.T, strict=True):
        table[:7] = np.round(table[:7] * 64) / 64  # sums and differences of such numbers are not rounded
        table[:7, OPEN] = table[:7, HOLD] + gains
        table[[_S, _S + 2, _S + 4], CLOSE] = table[[_S, _S + 2, _S + 4], HOLD]
        table[[_S + 5, _S + 6], CLOSE] = table[[_S + 5, _S + 6], HOLD] + [-0.5, 0.5]
    return tables


def _knows_no_later_state(call, seed):
    rng = np.random.default_rng(seed + 5)
    tables, states = _tables(rng, 0.6, flips=True), _states(rng, 50, 3)
    positions = positions_of(call(*tables, states).value, len(states))
    if not positions.any():
        raise NotYet("position 0 in every bar", _NEVER_TRADES)
    for t in range(3, len(states) - 1, 4):
        other = np.concatenate([states[: t + 1], _states(rng, len(states) - t - 1)])
        later = positions_of(call(*tables, other).value, len(states))
        changed = np.flatnonzero(later[: t + 1] != positions[: t + 1])
        if changed.size:
            i = changed[-1]
            came = (
                f"the position at t = {i} was {positions[i]:.0f}; with other states after t = {t} it is {later[i]:.0f}"
            )
            raise NotYet(came, AHEAD)


trades_one_side_at_a_time = Check(
    "trades_one_side_at_a_time",
    title="Task 6, two tables and one trader",
    usage="trade(q_long, q_short, states)",
    trials=[
        Trial(
            "forty short markets, in which no trade ends",
            "the side with the larger, positive q[open] − q[hold] opens",
            _opens_the_better_side,
        ),
        Trial("trades that last and end", "a trade goes on until its own table says close", _closes_by_its_own_table),
        Trial(
            "the bar of a close",
            "the other side may open in it, if its advantage is the larger; the same side may not",
            _turns_round_in_one_bar,
        ),
        Trial("states that begin with −1", "position 0 there, then as ever", _waits_for_a_state),
        Trial("ties", "nothing is opened and nothing closed; of equal advantages neither side opens", _holds_at_a_tie),
        Trial("the same states with others after them", "the same positions up to there", _knows_no_later_state),
    ],
    likely={
        "out of bounds|out of range": "your code looks up a row that the tables do not have: out of a trade it is "
        "`state`, in a trade `num_states + state`, with num_states = len(q_long) // 2.",
    },
    hints=[
        "Go through the states one by one, and keep one variable, `position`. What can happen at a bar depends on "
        "whether there is a state (it is not −1), and whether there is a trade (the position is not 0).",
        "In a trade, long or short, look into that side's table, row `num_states + state`: it closes if q[close] > "
        "q[hold]. Then the position is 0, but remember which side it was.",
        "Out of a trade look at row `state` of both tables. The advantage of a side is q[open] − q[hold]. The larger "
        "one opens, if it is positive: unless that side has closed in this very bar. Of equals neither does.",
        "`closed = 0` at the beginning of each bar, and `closed, position = position, 0` at a close. Then, if the "
        "position is 0, work out `wanted`, the side with the larger positive advantage or 0: `if wanted != closed: "
        "position = wanted`. At the end of each bar `positions.append(position)`.",
    ],
)
