"""A deep Q-network on its way through training, remembered moment by moment."""

from dataclasses import dataclass

import gymnasium
import numpy as np

from course_lib.bellman import evaluate_policy
from course_lib.explore.drawing.nodes import forward
from course_lib.explore.worlds import with_rules
from course_lib.maze import Action

GAMMA = 0.95
EPISODES, BETWEEN = 500, 10  # how long a network is trained, and how often it is looked at
PARTS = {
    "replay": {"replay": 10_000, "batch_size": 32},
    "target": {"target_update": 100},
    "double": {"double": True},
}


@dataclass(frozen=True, eq=False)
class Moment:
    """A network at one moment of its training, and what its agent had done until then.

    layers   [(weights float64[n, m], biases float64[m]), …], two of them
    q        float64[S, A], what it says of every state
    tries    int64[S, A], how often each action had been taken
    earned   what one earns from the start, discounted, by always taking the best action of q
    """

    layers: list
    q: np.ndarray
    tries: np.ndarray
    earned: float


class Training:
    """An agent on its way through 500 episodes, and its `moments`, one for every ten.

    maze    the world, of which it takes one of its own, so that no other training moves in it
    parts   {"mask", "replay", "target", "double": whether it has it}
    """

    def __init__(self, maze, parts, seed):
        from course_lib.dqn import DQNAgent  # with it comes torch, which other lessons do without

        self.name = ", ".join(["mask" if parts["mask"] else "no mask", *filter(parts.get, PARTS), f"seed {seed}"])
        settings = {name: value for part in PARTS if parts[part] for name, value in PARTS[part].items()}
        self._world = _Counting(with_rules(maze))
        self._agent = DQNAgent(self._world, gamma=GAMMA, mask_terminal=parts["mask"], seed=seed, **settings)
        self.moments = []
        self._look()

    @property
    def episodes(self):
        """How many the agent has been trained for."""
        return (len(self.moments) - 1) * BETWEEN

    def go_on(self):
        """Train for ten more episodes."""
        self._agent.train(BETWEEN)
        self._look()

    def worth(self, cell):
        """float64[moments]: the largest Q-value of a cell, from before training until now."""
        return np.array([moment.q[cell].max() for moment in self.moments])

    def _look(self):
        layers = [(weights[0].astype(float), biases[0].astype(float)) for weights, biases in self._agent.layers]
        _, q = forward(layers, np.eye(len(layers[0][0])))
        earned = evaluate_policy(self._world.env.mdp, q.argmax(axis=1), GAMMA)[self._world.env.start]
        self.moments.append(Moment(layers, q, self._world.tries.copy(), float(earned)))


class _Counting(gymnasium.Wrapper):
    """A maze that counts which action was taken how often in which state: `tries`, int64[S, A]."""

    def __init__(self, maze):
        super().__init__(maze)
        self.tries, self._state = np.zeros((maze.grid.size, len(Action)), np.int64), None

    def reset(self, **options):
        self._state, info = self.env.reset(**options)
        return self._state, info

    def step(self, action):
        self.tries[self._state, action] += 1
        self._state, *rest = self.env.step(action)
        return self._state, *rest
