"""A known world: for every state and action, what may come next, how likely, and what it pays."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

_LARGEST_DENSE = 2**27  # entries of a dense T, 1 GiB: more is not for looking at


@dataclass(frozen=True, eq=False, repr=False)
class MDP:
    """A finite Markov decision process (Sutton & Barto, 2nd ed., section 3.1), as a list of outcomes.

    S states, A actions, K the most outcomes any (state, action) has; unused places have probability 0.

    next_state   int32[S, A, K]    where outcome k of action a in state s leads
    probability  float64[S, A, K]  how likely it is; sums to 1 over k
    reward       float64[S, A, K]  what it pays
    terminal     bool[S, A, K]     whether it ends the episode: nothing is earned after it

    The arrays are checked once and read-only from then on. Raises `ValueError` for shapes that differ, states out of
    range, probabilities that are negative, NaN or do not sum to 1, and rewards that are not finite.
    """

    next_state: np.ndarray
    probability: np.ndarray
    reward: np.ndarray
    terminal: np.ndarray

    def __post_init__(self):
        raw_next = np.asarray(self.next_state)
        if raw_next.ndim != 3 or 0 in raw_next.shape:
            raise ValueError(f"next_state must have shape (states, actions, outcomes), got {raw_next.shape}")
        if not np.issubdtype(raw_next.dtype, np.integer):
            raise ValueError(f"next_state must hold whole numbers, got dtype {raw_next.dtype}")
        if raw_next.min() < 0 or raw_next.max() >= raw_next.shape[0]:
            raise ValueError(
                f"next_state must be from 0 to {raw_next.shape[0] - 1}, got {raw_next.min()} to {raw_next.max()}"
            )
        for name, dtype in (("next_state", np.int32), ("probability", float), ("reward", float), ("terminal", bool)):
            array = np.array(getattr(self, name), dtype=dtype, order="C")  # a copy: the caller may go on writing
            if array.shape != raw_next.shape:
                raise ValueError(f"{name} must have next_state's shape {raw_next.shape}, got {array.shape}")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        self._check_numbers()

    def _check_numbers(self):
        if not np.isfinite(self.reward).all():
            s, a, k = np.argwhere(~np.isfinite(self.reward))[0]
            raise ValueError(f"reward must be finite, got {self.reward[s, a, k]} in state {s}, action {a}")
        if not (self.probability >= 0).all():  # NaN compares false, so it is caught here too
            s, a, k = np.argwhere(~(self.probability >= 0))[0]
            raise ValueError(
                f"probability must not be negative or NaN, got {self.probability[s, a, k]} in state {s}, action {a}"
            )
        total = self.probability.sum(axis=2)
        if not (np.abs(total - 1) <= 1e-9).all():
            s, a = np.argwhere(~(np.abs(total - 1) <= 1e-9))[0]
            raise ValueError(f"probabilities must sum to 1, got {total[s, a]:.12g} in state {s}, action {a}")

    def __repr__(self):
        return (
            f"MDP({self.num_states} states, {self.num_actions} actions, up to {self.next_state.shape[2]} outcomes each)"
        )

    @property
    def num_states(self):
        return self.next_state.shape[0]

    @property
    def num_actions(self):
        return self.next_state.shape[1]

    @classmethod
    def from_gymnasium(cls, env):
        """The MDP behind `env`: its own `mdp` if it has one, else its toy-text table `P[s][a] = [(p, s', r, done), …]`.

        FrozenLake, CliffWalking, Taxi and any environment written like them. `ValueError` if there is no table.
        """
        world = getattr(env, "unwrapped", env)
        if isinstance(getattr(world, "mdp", None), cls):
            return world.mdp
        table = getattr(world, "P", None)
        if table is None:
            raise ValueError(f"{world} has no table of transitions (an attribute P or mdp), so it cannot be planned in")
        try:
            arrays = _arrays_of(table)
        except (LookupError, TypeError, ValueError, OverflowError) as error:
            form = "P[s][a] = [(probability, next state, reward, done), …]"
            raise ValueError(
                f"the table P of {world} is not of the form {form}: {type(error).__name__} {error}"
            ) from None
        return cls(*arrays)

    @cached_property
    def T(self):
        """P(s' | s, a), float64[S, A, S]: the textbook's transition array, an end leading to the state it ends in."""
        entries = self.num_states**2 * self.num_actions
        if entries > _LARGEST_DENSE:
            raise ValueError(
                f"T would need {entries * 8 / 2**30:.0f} GiB for {self.num_states} states:"
                " use next_state and probability"
            )
        T = np.zeros((self.num_states, self.num_actions, self.num_states))
        s, a, _ = np.indices(self.next_state.shape, sparse=True)
        np.add.at(T, (s, a, self.next_state), self.probability)
        return T

    @cached_property
    def R(self):
        """R(s, a) = Σ_k probability · reward, float64[S, A]: the reward to expect."""
        return (self.probability * self.reward).sum(axis=2)


def _arrays_of(table):
    """next_state, probability, reward, terminal of a table P[s][a] = [(p, s', r, done), …]."""
    num_states, num_actions = len(table), len(table[0])
    num_outcomes = max(len(table[s][a]) for s in range(num_states) for a in range(num_actions))
    shape = (num_states, num_actions, num_outcomes)
    next_state, probability = np.zeros(shape, np.int32), np.zeros(shape)
    reward, terminal = np.zeros(shape), np.zeros(shape, bool)
    for s in range(num_states):
        for a in range(num_actions):
            for k, (p, s_next, r, done) in enumerate(table[s][a]):
                next_state[s, a, k], probability[s, a, k] = s_next, p
                reward[s, a, k], terminal[s, a, k] = r, done
    return next_state, probability, reward, terminal
