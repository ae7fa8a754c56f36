"""What several tests of deep Q-learning share: worlds, settings, and looks inside an agent."""

from contextlib import contextmanager

import gymnasium
import numpy as np
import torch

from course_lib import Maze
from course_lib.files import generator_in

WORLDS = {
    "maze": Maze,
    "slippery maze": lambda: Maze(slip=0.2),
    "large maze": lambda: Maze.random(9, 8, slip=0.1, wall_ends_episode=False, seed=1),  # more than 64 states
    "lake": lambda: gymnasium.make("FrozenLake-v1"),
    "cart pole": lambda: gymnasium.make("CartPole-v1"),
}
SWITCHES = {
    "the defaults": {},
    "target network": {"target_update": 25, "learning_rate": 3e-3},
    "everything": {
        "replay": 60, "batch_size": 4, "target_update": 0.05, "double": True, "mask_terminal": False,
        "hidden": (12, 9), "gamma": 0.9, "epsilon": 0.8, "epsilon_decay": 0.97, "learning_rate": 3e-3,
    },
}  # fmt: skip


class Counted(gymnasium.Env):
    """What one sees is the number of the episode and of the step in it; each step pays the latter.

    Episode k has lengths[k] steps, again from the first after the last; every other one is truncated at its end.
    """

    observation_space = gymnasium.spaces.Box(0, 1e6, (2,))
    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self, lengths):
        self.lengths, self.episode = lengths, -1

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        self.episode, self.step_number = self.episode + 1, 0
        return self._seen(), {}

    def step(self, action):
        assert self.action_space.contains(action)
        assert self.step_number < self.lengths[self.episode % len(self.lengths)], "the episode is over"
        self.step_number += 1
        over, cut = self.step_number == self.lengths[self.episode % len(self.lengths)], self.episode % 2 == 1
        return self._seen(), float(self.step_number), over and not cut, over and cut, {}

    def _seen(self):
        return np.array([self.episode, self.step_number], np.float32)


class Chance(gymnasium.Env):
    """What one sees is a number drawn anew at every step, also where an episode begins; episodes of four steps."""

    observation_space = gymnasium.spaces.Box(0, 1, (1,))
    action_space = gymnasium.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        self.steps = 0
        return np.array([self.np_random.random()], np.float32), {}

    def step(self, action):  # noqa: ARG002 (Gymnasium's signature)
        self.steps += 1
        return np.array([self.np_random.random()], np.float32), 1.0, False, self.steps == 4, {}


@contextmanager
def one_thread():
    """Small tensors are not worth a second one, and torch waits for it with the processor at work."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def everything(agent):
    """All that training changes, to the last bit; for each agent by itself where it is one row an agent."""
    underway, record = agent._underway, agent.history
    longest = int(underway.steps.max())
    parts = {
        "weights": agent._online.flat.numpy(),
        "target": agent._target.flat.numpy(),
        "first moments": agent._adam.first.numpy(),
        "second moments": agent._adam.second.numpy(),
        "updates": agent._adam.updates,
        "epsilon": agent.epsilon,
        "episode": underway.number,
        "steps": underway.steps,
        "return": underway.returns,
        "actions": np.where(np.arange(longest) < underway.steps[:, None], underway.actions[:, :longest], -1),
        "next random numbers": np.stack([generator_in(state).random(8) for state in agent._draws.states()]),
    }
    if agent._memory is not None:
        parts["count"] = agent._memory.count
        for name, tensor in agent._memory.tensors.items():
            parts[f"remembered {name}"] = tensor.numpy().reshape(agent.num_agents, -1)
    names = ("episode_return", "episode_length", "terminated", "truncated")
    parts |= {f"history of {name}": getattr(record, name) for name in names}
    return {name: [row.tobytes() for row in array] for name, array in parts.items()}


def learned(agent):
    """`everything` but for the history, which is the latest `train`'s alone."""
    return {name: rows for name, rows in everything(agent).items() if not name.startswith("history")}


def watched(agent):
    """A list that fills as the agents play: (actions, rewards, the agents that stepped), one entry a step."""
    steps, add = [], agent._underway.add

    def noted(actions, rewards, agents):
        steps.append((actions.copy(), np.array(rewards, float), agents.copy()))
        add(actions, rewards, agents)

    agent._underway.add = noted
    return steps


def remembered(agent):
    """A list for each agent that fills with the transitions it stores, {name: number or array}."""
    stored, store = [[] for _ in range(agent.num_agents)], agent._memory.store

    def noted(transition, agents):
        for i in np.flatnonzero(agents):
            stored[i].append({name: values[i].numpy().copy() for name, values in transition.items()})
        store(transition, agents)

    agent._memory.store = noted
    return stored
