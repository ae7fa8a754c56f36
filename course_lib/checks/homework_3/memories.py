"""Small decision processes whose values are known, and memories of transitions in them, as task 4 is given them."""

from dataclasses import dataclass

import numpy as np

GAMMA = 0.9  # the one that the task asks for


@dataclass(frozen=True)
class Memory:
    """N remembered transitions of a process with S states and A actions.

    transitions  (observations float[N, n], actions int[N], rewards float[N], next_observations float[N, n],
                 next_possible bool[N, A], terminated bool[N])
    states       int[N], the state that each transition began in
    exact        float[S, A], the values of all actions; NaN where one is impossible
    """

    transitions: tuple
    states: np.ndarray
    exact: np.ndarray

    def by_state(self, values):
        """float[S, A] of values float[N, A] that belong to the observations."""
        first = [int(np.flatnonzero(self.states == state)[0]) for state in range(len(self.exact))]
        return values[first]


def many_states(seed, S=30, A=3):
    """S states in which each action ends the episode and pays something else: more pairs than a batch can hold."""
    rng = np.random.default_rng(seed)
    signs = np.where(np.arange(S * A) < 0.6 * S * A, 1, -1)
    rewards = rng.uniform(0.5, 1.5, size=(S, A)) * rng.permutation(signs).reshape(S, A)
    elsewhere = rng.integers(S, size=(S, A))  # what is seen after the end is of no importance
    steps = {(s, a): (rewards[s, a], elsewhere[s, a], True) for s in range(S) for a in range(A)}
    return _memory(rng, steps, np.ones((S, A), bool), size=24, copies=2)


def chains(seed, ends, *, loss, S=5):
    """A chain of S states for each of `ends`: state S * i + j is the j-th of the i-th chain.

    Action 0 goes on, from state to state, and in the last one it pays that end; action 1 ends it all with a `loss`.
    """
    rng = np.random.default_rng(seed)
    steps = {}
    for i, end in enumerate(ends):
        last = S * i + S - 1
        steps |= {(s, 0): (0.0, s + 1, False) for s in range(S * i, last)}
        steps[last, 0] = end, last, True
    everywhere = range(S * len(ends))
    steps |= {(s, 1): (loss, int(rng.integers(len(everywhere))), True) for s in everywhere}
    return _memory(rng, steps, np.ones((len(everywhere), 2), bool), size=16, copies=240 // len(steps))


def costly_trades(seed, trades=6):
    """State i < `trades` is out of a trade, where open pays 3; state `trades` + i is in it, and any way out costs.

    Actions are 0 hold, 1 open, 2 close. In a trade open is impossible, and would look splendid there.
    """
    rng = np.random.default_rng(seed)
    steps, possible = {}, np.zeros((2 * trades, 3), bool)
    possible[:trades, [0, 1]] = possible[trades:, [0, 2]] = True
    for out in range(trades):
        elsewhere = rng.integers(2 * trades, size=3)
        steps[out, 0] = -1.0, elsewhere[0], True
        steps[out, 1] = 3.0, trades + out, False
        steps[trades + out, 0] = rng.uniform(-1.5, -0.8), elsewhere[1], True
        steps[trades + out, 2] = rng.uniform(-1.5, -0.8), elsewhere[2], True
    return _memory(rng, steps, possible, size=16, copies=10)


def _memory(rng, steps, possible, size, copies):
    """The `Memory` of a process: {(state, action): (reward, next state, terminated)}, each remembered so many times."""
    observations = _different_observations(rng, len(possible), size)
    order = rng.permutation(np.repeat(np.arange(len(steps)), copies))
    states, actions = np.array(list(steps))[order].T
    rewards, next_states, terminated = (np.array(column)[order] for column in zip(*steps.values(), strict=True))
    transitions = observations[states], actions, rewards, observations[next_states], possible[next_states], terminated
    return Memory(transitions, states, action_values(steps, possible))


def action_values(steps, possible, gamma=GAMMA):
    """float[S, A]: the exact values, by as many sweeps as there are states, which is enough where nothing returns."""
    q = np.where(possible, 0.0, np.nan)
    for _ in range(len(q)):
        values = np.nanmax(q, axis=1)
        for (state, action), (reward, next_state, terminated) in steps.items():
            q[state, action] = reward + (0.0 if terminated else gamma * values[next_state])
    return q


def _different_observations(rng, S, size):
    """float[S, size] of -1 and 1, in which any two rows differ in a quarter of the places or more."""
    while True:
        rows = rng.choice([-1.0, 1.0], size=(S, size))
        differences = (rows[:, None] != rows).sum(axis=2) + size * np.eye(S)
        if differences.min() >= size / 4:
            return rows
