"""Many traders on one side of one share, all stepped at once."""

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Discrete
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from course_lib.market.accounting import RUIN
from course_lib.market.chain import CLOSE, HOLD
from course_lib.market.prices import as_price_errors
from course_lib.market.side import POSSIBLE, Tape
from course_lib.validate import whole_number


class SideVectorEnv(VectorEnv):
    """As many `SideEnv`s side by side; lane i of seed s is the `SideEnv` of seed s + i, step by step.

    A lane whose episode is over begins the next one at the step that follows (Gymnasium's NEXT_STEP). Arguments are
    those of `SideEnv`; `info` holds an array of each of its entries.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self, prices, encoder, *, side, num_envs, cost=0.0005, fill=None, episode_length=None, reward_unit=1.0
    ):
        self.tape = Tape(prices, encoder, side, cost, fill, episode_length, reward_unit)
        with as_price_errors():
            self.num_envs = whole_number("num_envs", num_envs, at_least=1)
        self.single_observation_space, self.single_action_space = self.tape.space, Discrete(3)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.render_mode, self._generators = None, None
        self._dates, self._ruin = self.tape.dates.to_numpy(), np.log(RUIN)

    def reset(self, *, seed=None, options=None):  # noqa: ARG002 (Gymnasium's signature)
        """Begin in every lane: seed gives the first lane's seed, a list one for each; None goes on drawing."""
        if seed is None or isinstance(seed, (int, np.integer)):
            seeds = [None if seed is None else int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = list(seed) if np.iterable(seed) else []
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed must be a number, or a list of {self.num_envs}, one a lane, got {seed!r}")
        drawing = self._generators or [None] * self.num_envs
        self._generators = [
            old if one is None and old is not None else seeding.np_random(one)[0]
            for old, one in zip(drawing, seeds, strict=True)
        ]
        lanes = np.ones(self.num_envs, bool)
        self._bar, self._end, self._position, self._trades = np.zeros((4, self.num_envs), np.int64)
        self._log_equity, self._over = np.zeros(self.num_envs), ~lanes
        self._begin(lanes)
        return self._observations(), self._info(~lanes)

    def _begin(self, lanes):
        for i in np.flatnonzero(lanes):
            self._bar[i] = int(self._generators[i].random() * self.tape.starts)
        self._end[lanes] = self._bar[lanes] + self.tape.length
        self._position[lanes], self._trades[lanes], self._log_equity[lanes] = 0, 0, 0.0

    def step(self, actions):
        """One step in every lane; those whose episode was over begin anew instead, and get no reward."""
        if self._generators is None:
            raise ResetNeeded("call reset() before step()")
        actions = np.asarray(actions)
        is_whole = actions.shape == (self.num_envs,) and actions.dtype.kind in "iu"
        if not is_whole or actions.min() < 0 or actions.max() > 2:
            raise ValueError(f"actions must be {self.num_envs} whole numbers from 0 to 2, got {actions!r}")
        steps = ~self._over
        invalid = steps & (actions == CLOSE - self._position)
        new = np.where(steps & (actions != HOLD), 2 - actions, self._position)
        bar = np.minimum(self._bar, self.tape.bars - 2)
        gains = np.where(steps, self.tape.gains[bar, self._position, new], 0.0)
        self._trades += new != self._position
        self._bar += steps
        self._position = new
        self._log_equity += gains
        terminated = steps & (gains <= self._ruin)
        truncated = steps & ~terminated & (self._bar == self._end)
        if self._over.any():
            self._begin(self._over)
        self._over = terminated | truncated
        return self._observations(), gains / self.tape.unit, terminated, truncated, self._info(invalid)

    def _observations(self):
        return self.tape.seen[self._position, self._bar]

    def _info(self, invalid):
        arrays = {
            "action_mask": POSSIBLE[self._position],
            "position": self._position.copy(),
            "date": self._dates[self._bar],
            "trades": self._trades.copy(),
            "log_equity": self._log_equity.copy(),
            "invalid": invalid,
        }
        everywhere = np.ones(self.num_envs, bool)
        return arrays | {f"_{name}": everywhere for name in arrays}
