"""One share, one side: buy and cash out, or sell and cash out. A Gymnasium environment."""

from operator import index

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete

from course_lib.market.accounting import RUIN, growth_in
from course_lib.market.chain import CLOSE, HOLD, OPEN
from course_lib.market.parts import as_part
from course_lib.market.prices import PriceDataError, as_price_errors
from course_lib.market.synthetic import checked_side
from course_lib.mdp import MDP
from course_lib.validate import number, whole_number

POSSIBLE = np.array([[1, 1, 0], [1, 0, 1]], np.int8)  # hold, open, close: out of the market, in it
POSSIBLE.flags.writeable = False


class Tape:
    """What a side's world is made of, bar by bar: N bars of a part, and what every move at each of them leads to.

    seen    int64[2, N] or float32[2, N, k + 1], by position (0 out, 1 in)
    gains   float64[N - 1, 2, 2], log growth of the money by old and new position
    starts  how many bars an episode may begin at: the first ones
    """

    def __init__(self, prices, encoder, side, cost, fill, episode_length, reward_unit):
        self.side = checked_side(side)
        part = as_part(prices, encoder)
        part.check_fitted(encoder)
        self.part, self.dates = part, part.dates
        self.bars = len(part)
        longest = self.bars - 1
        with as_price_errors(f"; the part has {self.bars} bars"):
            self.length = whole_number(
                "episode_length", longest if episode_length is None else episode_length, at_least=1, below=longest + 1
            )
            self.unit = number("reward_unit", reward_unit)
        if self.unit <= 0:
            raise PriceDataError(f"reward_unit must be positive, got {reward_unit!r}")
        self.starts = self.bars - self.length
        growth = growth_in(part, cost, fill)
        held = [1, 1 + self.side]
        self.gains = np.ascontiguousarray(growth[:, held][:, :, held])
        self.space, self.seen = seen_by_position(part, encoder)


def seen_by_position(part, encoder):
    """The observation space of an encoder on a part, and what is seen at each bar: [2, N, …], out and in."""
    if isinstance(encoder, type) or not hasattr(encoder, "transform"):
        raise PriceDataError(
            f"an encoder has fit, transform, num_states and warmup, such as MinMaxEncoder(), got {encoder!r}"
        )
    shown, warmup = np.asarray(encoder.transform(part.prices["close"])), getattr(encoder, "warmup", 0)
    if shown.shape[:1] != (len(part.prices),):
        raise PriceDataError(f"an encoder must show something at each of {len(part.prices)} bars, got {shown.shape}")
    shown, num_states = shown[part.first :], getattr(encoder, "num_states", None)
    by_state = num_states is not None
    if shown.dtype.kind not in ("iu" if by_state else "iuf") or (by_state and shown.ndim != 1):
        wanted = "one whole number a bar, the state" if by_state else "numbers"
        got = f"{shown.dtype}{[*shown.shape]}"
        raise PriceDataError(f"{type(encoder).__name__} must show {wanted}, got {got}")
    nothing = shown < 0 if by_state else ~np.isfinite(shown).all(axis=tuple(range(1, shown.ndim)))
    if nothing.any():
        raise PriceDataError(
            f"on {part.dates[int(np.argmax(nothing))]:%Y-%m-%d} nothing is seen (state -1): "
            f"{type(encoder).__name__} needs {warmup} bars before the first one traded, not {part.first}: "
            f"split(prices, warmup={warmup})"
        )
    if not by_state:
        inputs = shown.reshape(len(shown), -1).astype(np.float32)
        columns = [np.full((len(inputs), 1), position, np.float32) for position in (0, 1)]
        seen = np.stack([np.hstack([inputs, column]) for column in columns])
        bound = max(1.0, float(getattr(encoder, "clip", np.abs(inputs).max())))
        return Box(-bound, bound, (inputs.shape[1] + 1,), np.float32), seen
    if shown.max() >= num_states:
        raise PriceDataError(f"states of {type(encoder).__name__} must be below {num_states}, got {shown.max()}")
    return Discrete(2 * num_states), np.stack([shown, num_states + shown]).astype(np.int64)


class SideEnv(gymnasium.Env):
    """Trade one side of one share, bar by bar: side +1 buys and cashes out, -1 sells and cashes out.

    Actions: 0 hold, 1 open, 2 close; an impossible one (open when in, close when out) does nothing. The reward is the
    log growth of the money to the next bar, costs paid, so rewards add up to the log of what the money has become.

    prices          DataFrame of `check_prices`, traded from the encoder's warm-up on; or a `Part` of a `split`
    encoder         fitted on the training part. With num_states: Discrete observations, position * num_states + state;
                    else a Box: what it shows, and the position (0 or 1) as the last number
    cost, fill      see `log_growth`
    episode_length  bars of an episode, which begins anywhere; None: all of them, from the first
    reward_unit     what counts as 1: rewards are divided by it. Networks learn best from numbers near 1

    The end of the data, or of the episode, truncates; ruin (a short whose price has doubled in one bar) terminates.
    `info`: action_mask int8[3], position (0 or 1), date, trades (legs), log_equity, invalid. `PriceDataError` for what
    must not pass: bad prices, an encoder that is not fitted or fitted on unseen days, a warm-up that is traded.
    """

    metadata = {"render_modes": []}

    def __init__(self, prices, encoder, *, side, cost=0.0005, fill=None, episode_length=None, reward_unit=1.0):
        self.tape = Tape(prices, encoder, side, cost, fill, episode_length, reward_unit)
        self.observation_space, self.action_space = self.tape.space, Discrete(3)
        self.side, self.render_mode = self.tape.side, None
        # Lists: a number out of one is had in a third of the time that an array takes.
        self._gains, self._dates = self.tape.gains.tolist(), list(self.tape.dates)
        self._vectors = self.tape.seen.ndim == 3
        self._seen = [list(rows) if self._vectors else rows.tolist() for rows in self.tape.seen]
        self._masks, self._ruin = list(POSSIBLE), float(np.log(RUIN))
        self._bar = None

    def reset(self, *, seed=None, options=None):  # noqa: ARG002 (Gymnasium's signature)
        super().reset(seed=seed)
        self._bar = int(self.np_random.random() * self.tape.starts)
        self._end = self._bar + self.tape.length
        self._position, self._trades, self._log_equity = 0, 0, 0.0
        return self._shown(invalid=False)

    def step(self, action):
        if self._bar is None:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        try:
            chosen = index(action)
        except TypeError:
            chosen = -1
        if not 0 <= chosen <= 2:
            raise ValueError(f"action must be 0 (hold), 1 (open) or 2 (close), got {action!r}")
        position = self._position
        invalid = chosen == CLOSE - position  # close when out, open when in
        new = position if chosen == HOLD else 2 - chosen  # what is impossible leads to where one is
        reward = self._gains[self._bar][position][new]
        if new != position:
            self._trades += 1
        self._position, self._bar = new, self._bar + 1
        self._log_equity += reward
        terminated = reward <= self._ruin
        truncated = not terminated and self._bar == self._end
        observation, info = self._shown(invalid)
        if terminated or truncated:
            self._bar = None
        return observation, reward / self.tape.unit, terminated, truncated, info

    def _shown(self, invalid):
        """The observation and `info` of this bar."""
        position, bar = self._position, self._bar
        seen = self._seen[position][bar]
        info = {
            "action_mask": self._masks[position].copy(),
            "position": position,
            "date": self._dates[bar],
            "trades": self._trades,
            "log_equity": self._log_equity,
            "invalid": invalid,
        }
        return seen.copy() if self._vectors else seen, info

    def as_table_world(self):
        """This world as tables, so that agents can be trained in it without stepping it: see `table_world.TableWorld`.

        Its 2 N states are position * N + bar.
        """
        tape, bars = self.tape, self.tape.bars
        shape = (2, bars, 3)
        next_state, reward, terminal = np.zeros(shape, np.int32), np.zeros(shape), np.zeros(shape, bool)
        following = np.minimum(np.arange(bars) + 1, bars - 1)  # on the last bar nothing more is done
        for position in (0, 1):
            for action, new in ((HOLD, position), (OPEN, 1), (CLOSE, 0)):
                next_state[position, :, action] = new * bars + following
                gains = tape.gains[:, position, new]
                reward[position, :-1, action] = gains / tape.unit
                terminal[position, :-1, action] = gains <= self._ruin
        return {
            "mdp": MDP(*(a.reshape(2 * bars, 3, 1) for a in (next_state, np.ones(shape), reward, terminal))),
            "observed": tape.seen.reshape(2 * bars, *tape.seen.shape[2:]),
            "possible": np.repeat(POSSIBLE.astype(bool), bars, axis=0),
            "starts": range(tape.starts),
            "time_limit": tape.length,
        }
