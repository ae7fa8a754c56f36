"""What tests of observed worlds and of action masks share: a tape that is walked along, in or out of a position."""

import gymnasium
import numpy as np

from course_lib import MDP

HOLD, OPEN, CLOSE = range(3)
POSSIBLE = {(0, HOLD), (0, OPEN), (1, HOLD), (1, CLOSE)}  # position, action


class Plain(gymnasium.Env):
    """T numbers on a tape, walked along step by step; the hidden state is position * T + time.

    What one sees is the position and a digit of the time's own, 0 … digits - 1 (digits = None: the time itself), or,
    with `vectors`, the position and two numbers of the tape. In a position every step pays the tape's change; opening
    and closing cost something. Impossible actions (open in a position, close without one) do nothing. Episodes begin in
    one of `starts`, and are cut after time_limit steps; a step that leads to one of `ends` in a position terminates.
    """

    def __init__(
        self, *, vectors=False, length=60, digits=4, starts=None, time_limit=15, ends=(), seed=0, first=0, cost=0.1
    ):
        rng = np.random.default_rng(seed)
        self.tape, self.length = rng.normal(size=length), length
        self.num_digits = length if digits is None else digits
        self.digits = np.arange(length) if digits is None else rng.integers(digits, size=length)
        self.starts, self.time_limit, self.vectors = starts or range(length - 1 - time_limit), time_limit, vectors
        self.ends, self.first, self.cost = set(ends), first, cost
        if vectors:
            self.observation_space = gymnasium.spaces.Box(-10, 10, (3,))
        else:
            self.observation_space = gymnasium.spaces.Discrete(2 * self.num_digits, start=first)
        self.action_space = gymnasium.spaces.Discrete(3, start=first)
        self.taken = []  # (position, action), for tests to look at

    def seen(self, position, time):
        if self.vectors:
            return np.array([self.tape[time], self.tape[time - 1], position], np.float32)
        return int(self.first + position * self.num_digits + self.digits[time])

    def mask(self, position):
        return np.array([1, not position, position], np.int8)

    def outcome(self, position, time, action):
        """Next position, reward and whether that is the end."""
        after = {HOLD: position, OPEN: 1, CLOSE: 0}[action]
        reward = after * (self.tape[time + 1] - self.tape[time]) - self.cost * (after != position)
        return after, reward, bool(after) and time + 1 in self.ends

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        state = self.starts[int(self.np_random.random() * len(self.starts))]
        self.position, self.time = divmod(state, self.length)
        self.steps = 0
        return self.seen(self.position, self.time), {"action_mask": self.mask(self.position)}

    def step(self, action):
        assert self.action_space.contains(action)
        action = int(action) - self.first
        self.taken.append((self.position, action))
        self.position, reward, terminated = self.outcome(self.position, self.time, action)
        self.time, self.steps = self.time + 1, self.steps + 1
        info = {"action_mask": self.mask(self.position)}
        return self.seen(self.position, self.time), reward, terminated, self.steps >= self.time_limit, info


class Told(Plain):
    """`Plain`, as a table too."""

    def as_table_world(self):
        shape = 2 * self.length, 3, 1
        next_state, reward, terminal = np.zeros(shape, np.int32), np.zeros(shape), np.zeros(shape, bool)
        states = [(position, time) for position in range(2) for time in range(self.length)]
        for s, (position, time) in enumerate(states):
            for action in range(3):
                if time + 1 == self.length:
                    next_state[s, action] = s
                    continue
                after, reward[s, action], terminal[s, action] = self.outcome(position, time, action)
                next_state[s, action] = after * self.length + time + 1
        return {
            "mdp": MDP(next_state, np.ones(shape), reward, terminal),
            "observed": np.array([self.seen(*state) for state in states]),
            "possible": np.array([self.mask(position) for position, _ in states], bool),
            "starts": self.starts,
            "time_limit": self.time_limit,
        }


class Saying(Plain):
    """`Plain` with other infos: at reset, at every reset but the first, at every step, or at an end."""

    def __init__(self, info, where="reset", **world):
        super().__init__(**world)
        self.info, self.where, self.resets = info, where, 0

    def reset(self, **how):
        observation, info = super().reset(**how)
        self.resets += 1
        other = self.where == "reset" or (self.where == "second reset" and self.resets > 1)
        return observation, self.info if other else info

    def step(self, action):
        *answer, terminated, truncated, info = super().step(action)
        other = self.where == ("end" if terminated else "step")
        return *answer, terminated, truncated, self.info if other else info
