"""Two sides, one trader."""

import numpy as np

from course_lib.market.chain import CLOSE, HOLD, OPEN
from course_lib.market.parts import as_part
from course_lib.market.prices import PriceDataError
from course_lib.market.side import seen_by_position


def action_values(agent, prices, encoder):
    """What an agent of one side thinks at every bar of a part, out and in: float[N, 2, 3]; of E networks [E, N, 2, 3].

    agent   a `QAgent`, a `DQNAgent`, or a table float64[2 * num_states, 3]
    prices  a `Part`, or a whole frame of prices, looked at from the encoder's warm-up on
    """
    part = as_part(prices, encoder)
    part.check_fitted(encoder)
    space, seen = seen_by_position(part, encoder)
    table = getattr(agent, "q_table", agent)
    if not hasattr(agent, "q_values"):
        table = _as_numbers(table, "a table")
        if table.shape != (getattr(space, "n", 0), 3):
            raise PriceDataError(
                f"a table for this encoder has {getattr(space, 'n', 0)} rows and 3 columns, got {table.shape}"
            )
        return np.moveaxis(table[seen], 0, 1)
    q = agent.q_values(seen.reshape(-1, *seen.shape[2:]))
    return np.moveaxis(q.reshape(len(q), 2, len(part), 3), 1, 2)


def trade(q_long=None, q_short=None):
    """The positions, -1, 0 or 1, that two sides take as one trader: int8[…, N].

    q_long, q_short  action values at every bar, float[…, N, 2, 3], as of `action_values`; None: a side not traded

    In a position its own side decides: it closes if closing is worth more than holding. When flat, each side's
    advantage of opening over holding is compared; the larger opens if it is positive, of equals neither. In the very
    bar of a close the other side may open, if its advantage is the larger; the one just closed not before the next.
    """
    sides = [_as_numbers(q, "action values") for q in (q_long, q_short) if q is not None]
    shapes = {np.shape(q) for q in sides}
    if len(shapes) != 1 or any(len(shape) < 3 or shape[-2:] != (2, 3) for shape in shapes):
        raise PriceDataError(f"action values must have one shape, […, N, 2, 3], got {sorted(shapes)}")
    nothing = np.zeros(sides[0].shape)
    q_long, q_short = (nothing if q is None else np.asarray(q, float) for q in (q_long, q_short))
    opens_long, opens_short = (q[..., 0, OPEN] - q[..., 0, HOLD] for q in (q_long, q_short))
    wanted = np.sign(opens_long - opens_short).astype(np.int64) * (np.maximum(opens_long, opens_short) > 0)
    keeps_long, keeps_short = (q[..., 1, CLOSE] <= q[..., 1, HOLD] for q in (q_long, q_short))
    after_short = np.where(keeps_short, -1, np.maximum(wanted, 0))
    after_long = np.where(keeps_long, 1, np.minimum(wanted, 0))
    then = np.stack([after_short, wanted, after_long], axis=-1)  # […, N, 3]: by the position one comes with
    then = np.moveaxis(then, -2, 0).reshape(then.shape[-2], -1, 3)
    positions, lanes = np.zeros(then.shape[:2], np.int8), np.arange(then.shape[1])
    held = np.zeros(len(lanes), np.int64)
    for bar, step in enumerate(then):
        held = step[lanes, held + 1]
        positions[bar] = held
    return positions.T.reshape(nothing.shape[:-2])


def _as_numbers(values, name):
    """`values` as float[…] without NaN, or a `PriceDataError`."""
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        raise PriceDataError(f"{name} must be an array of numbers, got {type(values).__name__}") from None
    if np.isnan(array).any():
        raise PriceDataError(f"{name} must be numbers, {np.isnan(array).sum()} of {array.size} are NaN")
    return array
