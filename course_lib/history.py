"""What happened: to an agent while it learned (`History`), and on one walk (`Rollout`)."""

from dataclasses import dataclass

import numpy as np

from course_lib.validate import fraction, whole_number


@dataclass(eq=False)
class History:
    """One entry an episode, in the order they were played. N episodes; those of E agents are [E, N].

    An agent that has played fewer than N has empty places at the end of its row: NaN, 0, False and False.

    episode_return  float64  undiscounted sum of the episode's rewards
    episode_length  int64    steps
    terminated      bool     the world ended it (goal, wall, ruin)
    truncated       bool     a time limit cut it off
    """

    episode_return: np.ndarray
    episode_length: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray

    def __len__(self):
        return self.episode_return.shape[-1]

    def curve(self, window=50):
        """Mean episode return over the last `window` episodes, float64 of the same shape; for plotting.

        The first `window - 1` entries average what there is so far. `ValueError` if `window` < 1.
        """
        window = whole_number("window", window, at_least=1)
        total = np.cumsum(self.episode_return, axis=-1, dtype=np.float64)
        recent = total.copy()
        recent[..., window:] -= total[..., :-window]
        return recent / np.minimum(np.arange(1, len(self) + 1), window)


@dataclass(eq=False)
class Rollout:
    """One walk: T steps visit T + 1 states.

    states       int64[T + 1], or float32[T + 1, …] where observations are vectors
    actions      int64[T];  rewards  float64[T]
    terminated   whether the world ended it; truncated: a time limit, or the walk's own `max_steps`, did
    """

    states: np.ndarray
    actions: np.ndarray
    rewards: np.ndarray
    terminated: bool
    truncated: bool

    def __len__(self):
        return len(self.actions)

    def discounted_return(self, gamma):
        """r_0 + gamma r_1 + gamma^2 r_2 + … of the walk (Sutton & Barto, 2nd ed., eq. 3.8).

        `ValueError` for a gamma outside [0, 1].
        """
        return float(self.rewards @ fraction("gamma", gamma) ** np.arange(len(self.rewards)))
