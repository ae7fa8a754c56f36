"""Traders that have misread one thing of task 6, and the words for each."""

import operator
from functools import partial

import numpy as np

from course_lib.checks.homework_2.reference import CLOSE, HOLD, NO_STATE, OPEN

ANY = 2  # in a trader's positions: they may be anything there
WARM_UP = (
    "your trader trades in bars without a state. −1 is no row: in Python `table[-1]` is the last one. The position "
    "stays 0 there."
)
AHEAD = "your trader looks ahead: the position at t is decided by the state at t, which is the last that is known then."


def _trading(q_long, q_short, states, *, opens=None, closes=None, after="other", warm_up="out", rows="own"):
    """The positions, float[T], of `reference.trade` with one thing misread.

    opens    opens(row of q_long, row of q_short) -> -1, 0, 1
    closes   closes(row of the table in whose trade it is)
    after    what may be opened in the bar of a close: the "other" side, if its advantage is the larger; "none"; "any",
             also the one just closed; the "next", whatever the one just closed would gain; "next of equals", also if
             both would gain the same; the "larger", but never of equals, whatever `opens` does
    warm_up  what is done in a bar without a state: "out" of any trade, or "traded" by the last row
    rows     "own", or what decides in a trade instead: the "long" table for both sides, the "flat" rows
    """
    opens, closes = opens or _larger_advantage, closes or (lambda row: row[CLOSE] > row[HOLD])
    num_states, position, positions = len(q_long) // 2, 0, []
    for state in states:
        if state == NO_STATE and warm_up == "out":
            positions.append(0)
            continue
        long_row, short_row, closed = q_long[state], q_short[state], 0
        if position:
            table = q_long if position > 0 or rows == "long" else q_short
            if closes(table[state if rows == "flat" else num_states + state]):
                closed, position = position, 0
        if closed:
            wanted = opens(long_row, short_row)
            other = 0 if wanted == closed else wanted
            following = _only_one_side(-closed, long_row, short_row)
            long, short = _advantages(long_row, short_row)
            position = {
                "other": other,
                "none": 0,
                "any": wanted,
                "next": following,
                "next of equals": following if long == short else other,
                "larger": other if long != short else 0,
            }[after]
        elif position == 0:
            position = opens(long_row, short_row)
        positions.append(position)
    return np.array(positions, float)


def _advantages(*rows):
    return [row[OPEN] - row[HOLD] for row in rows]


def _larger_advantage(long_row, short_row, *, gains=operator.gt, of_equals=0):
    """The side with the larger advantage where that gains, gains(advantage, 0)."""
    long, short = _advantages(long_row, short_row)
    if not gains(max(long, short), 0):
        return 0
    return of_equals if long == short else 1 if long > short else -1


def _without_a_gain(long_row, short_row):
    long, short = _advantages(long_row, short_row)
    return 1 if long > short else -1


def _by_the_value_of_opening(long_row, short_row):
    row, side = (long_row, 1) if long_row[OPEN] > short_row[OPEN] else (short_row, -1)
    return side if row[OPEN] > row[HOLD] else 0


def _above_zero(long_row, short_row):
    side = 1 if long_row[OPEN] > short_row[OPEN] else -1
    return side if max(long_row[OPEN], short_row[OPEN]) > 0 else 0


def _first_that_gains(first, long_row, short_row):
    gains = {side for side, advantage in zip((1, -1), _advantages(long_row, short_row), strict=True) if advantage > 0}
    return first if first in gains else -first if gains else 0


def _by_the_long_table(long_row, _):
    return _larger_advantage(long_row, -long_row)


def _only_one_side(side, long_row, short_row):
    return side if _advantages(long_row if side > 0 else short_row)[0] > 0 else 0


def _among_impossible(long_row, short_row):
    """The best of all three actions, though there is nothing to close."""
    side = _larger_advantage(long_row, short_row)
    return side if side and np.argmax(long_row if side > 0 else short_row) == OPEN else 0


def _each_side_by_itself(q_long, q_short, states):
    """The sum of two traders that know nothing of one another."""
    nobody = np.zeros_like(q_long)
    return _trading(q_long, nobody, states, after="none") + _trading(nobody, q_short, states, after="none")


def _ahead(q_long, q_short, states):
    positions = np.append(_trading(q_long, q_short, states[1:]), ANY)
    positions[states == NO_STATE] = ANY
    return positions


def _behind(q_long, q_short, states):
    return np.concatenate([[0.0], _trading(q_long, q_short, states)[:-1]])


def _sides_exchanged(q_long, q_short, states):
    return -_trading(q_long, q_short, states)


def _without_a_side(q_long, q_short, states):
    return np.abs(_trading(q_long, q_short, states))


def _actions(q_long, q_short, states):
    """Open in the bar of a change, hold in others."""
    positions = _trading(q_long, q_short, states)
    return np.where(np.diff(positions, prepend=0) != 0, np.where(positions == 0, CLOSE, OPEN), HOLD)


def _is_best_of_all(row):
    return np.argmax(row) == CLOSE


_WITHOUT_A_GAIN = (
    "your trader opens where that gains nothing: a side opens only if q[open] − q[hold] is positive, more than 0."
)
_BY_VALUE = (
    "the sides are compared by the value of opening. What counts is how much better opening is than holding, "
    "q[open] − q[hold]: two tables may lie at different heights."
)
_IMPOSSIBLE = (
    "your trader chooses among impossible actions as well: out of a trade close is none, in a trade open is none."
)
MISREAD = (
    (_BY_VALUE, partial(_trading, opens=_by_the_value_of_opening)),
    (_BY_VALUE, partial(_trading, opens=_above_zero)),
    (_WITHOUT_A_GAIN, partial(_trading, opens=_without_a_gain)),
    *(
        (_WITHOUT_A_GAIN, partial(_trading, opens=partial(_larger_advantage, gains=operator.ge, of_equals=side)))
        for side in (0, 1, -1)
    ),
    *(
        (
            f"where both sides gain the same, the {name} one opens: of equal advantages neither side does.",
            partial(_trading, opens=partial(_larger_advantage, of_equals=side), after=after),
        )
        for side, name in ((1, "long"), (-1, "short"))
        for after in ("other", "larger", "next of equals")
    ),
    (
        "where both sides gain the same, the other side opens in the bar of a close: of equal advantages neither side "
        "does.",
        partial(_trading, after="next of equals"),
    ),
    *(
        (
            "one side goes first: where both gain, the one with the larger advantage opens.",
            partial(_trading, opens=partial(_first_that_gains, side)),
        )
        for side in (1, -1)
    ),
    *(
        (
            f"your trader is never {name}: there are two tables, one for each side.",
            partial(_trading, opens=partial(_only_one_side, side)),
        )
        for side, name in ((1, "short"), (-1, "long"))
    ),
    (
        "one table decides for both sides: `q_long` is for long trades, `q_short` for short ones.",
        partial(_trading, opens=_by_the_long_table, rows="long"),
    ),
    ("the long table closes short trades too: in a trade its own table decides.", partial(_trading, rows="long")),
    (
        "your trader closes at a tie: it closes only where q[close] > q[hold].",
        partial(_trading, closes=lambda row: row[CLOSE] >= row[HOLD]),
    ),
    (
        "in a trade your trader looks at the rows for position 0: those for position 1 are the second half of the "
        "table, row = num_states + state.",
        partial(_trading, rows="flat"),
    ),
    *(
        (_IMPOSSIBLE, partial(_trading, **mistaken))
        for mistaken in (
            {"opens": _among_impossible, "closes": _is_best_of_all},
            {"opens": _among_impossible},
            {"closes": _is_best_of_all},
        )
    ),
    ("your trader never closes: in a trade its table may say close.", partial(_trading, closes=lambda _: False)),
    (
        "your trades last one bar: a trade goes on until its table says close.",
        partial(_trading, closes=lambda _: True),
    ),
    (
        "each table trades by itself, and the two positions are added up. There is one trader: while it is long, it "
        "cannot go short.",
        _each_side_by_itself,
    ),
    (
        "nothing is opened in the bar of a close: the trader is out then, and the other side may open in that bar.",
        partial(_trading, after="none"),
    ),
    (
        "a side is closed and opened again in one bar, which costs twice for nothing: in the bar of a close only the "
        "other side may open.",
        partial(_trading, after="any"),
    ),
    (
        "in the bar of a close the other side opens whenever it gains. Both sides compete in that bar: if the one that "
        "has just closed has the larger advantage, nothing opens.",
        partial(_trading, after="next"),
    ),
    (WARM_UP, partial(_trading, warm_up="traded")),
    (AHEAD, _ahead),
    ("your positions are those before the decision: at t stands the one after the decision at t.", _behind),
    ("long and short are exchanged: 1 is long, −1 short.", _sides_exchanged),
    ("your positions do not tell long from short: 1 is long, −1 short.", _without_a_side),
    (
        "you return actions: what is wanted is the position after each bar, −1 (short), 0 (out) or 1 (long).",
        _actions,
    ),
)
