"""A market as a Markov chain: what somebody knows of its next bar who knows its law, and trading in it as an MDP."""

from dataclasses import dataclass

import numpy as np

from course_lib.market.accounting import POSITIONS
from course_lib.mdp import MDP

HOLD, OPEN, CLOSE = range(3)


@dataclass(frozen=True, eq=False)
class Chain:
    """What follows on each of S states of knowledge.

    transition  float64[S, S], how likely each next one is
    growth      float64[S, 3], expected log growth of the money in the next bar, held short, flat or long
    """

    transition: np.ndarray
    growth: np.ndarray

    @classmethod
    def of_moves(cls, transition, moves):
        """The chain whose log price moves by moves[s, s_next]."""
        return cls(transition, expected_growth(moves, transition))

    def outcomes(self):
        """The next states that are possible and how likely they are: int64[S, K], float64[S, K]; K the most of them."""
        most = int((self.transition > 0).sum(axis=1).max())
        after = np.argsort(-self.transition, axis=1, kind="stable")[:, :most]
        return after, np.take_along_axis(self.transition, after, axis=1)


def expected_growth(moves, chances):
    """Σ chance * log(1 + position * (e^move - 1)) over the last axis, float64[…, 3], for short, flat and long."""
    return np.stack([(chances * np.log1p(position * np.expm1(moves))).sum(axis=-1) for position in POSITIONS], axis=-1)


def side_mdp(chain, side, cost):
    """One side's world as an exact `MDP` of 2 S states, position * S + state, and the actions hold, open, close.

    An action that is impossible does nothing. What a bar pays is the log growth that is to be expected.
    """
    return _mdp(chain, cost, held=(0, side), then=((0, 1, 0), (1, 1, 0)))


def trader_mdp(chain, cost):
    """Both sides' world as an exact `MDP` of 3 S states, (position + 1) * S + state; action a: go to position a - 1."""
    return _mdp(chain, cost, held=POSITIONS, then=((0, 1, 2),) * 3)


def _mdp(chain, cost, held, then):
    """held: the positions; then: by position and action the number of the position that follows."""
    after, chances = chain.outcomes()
    num_states, num_outcomes = after.shape
    shape = (len(held), num_states, 3, num_outcomes)
    next_state, reward = np.empty(shape, np.int32), np.empty(shape)
    for old, position in enumerate(held):
        for action, new in enumerate(then[old]):
            next_state[old, :, action] = new * num_states + after
            paid = abs(held[new] - position) * np.log1p(-cost)
            reward[old, :, action] = (chain.growth[:, held[new] + 1] + paid)[:, None]
    probability = np.broadcast_to(chances[None, :, None], shape)
    flat = (len(held) * num_states, 3, num_outcomes)
    tables = (next_state, probability, reward, np.zeros(shape, bool))
    return MDP(*(table.reshape(flat) for table in tables))
