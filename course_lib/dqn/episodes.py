"""Episodes of E agents: those under way, so that they can be gone on with, and those that have ended."""

import numpy as np

from course_lib.history import History


class Underway:
    """Where each of E agents is in its episode. From seed and actions the episode can be played again up to here.

    number   int64[E], of the episode under way, from 0; it begins from the seed first_seed + number
    steps    int64[E], made in it; `actions` int64[E, …] holds them, `returns` float64[E] the rewards so far
    """

    def __init__(self, first_seeds):
        num_agents = len(first_seeds)
        self.first_seeds, self.number = np.asarray(first_seeds), np.zeros(num_agents, np.int64)
        self.steps, self.returns = np.zeros(num_agents, np.int64), np.zeros(num_agents)
        self.actions = np.zeros((num_agents, 16), np.int64)

    def begin(self, lanes, agents):
        """A new episode for those agents, bool[E]."""
        self.steps[agents], self.returns[agents] = 0, 0.0
        if agents.any():
            lanes.begin(agents, (self.first_seeds + self.number) % 2**31)

    def go_on(self, lanes):
        """Bring the lanes to where the agents are; where that cannot be had again, begin a new episode."""
        everybody = np.ones(len(self.steps), bool)
        lanes.begin(everybody, (self.first_seeds + self.number) % 2**31)
        if not lanes.repeatable:
            self.steps[:], self.returns[:] = 0, 0.0
            return
        lost = np.zeros_like(everybody)
        for step in range(self.steps.max()):
            _, _, terminated, truncated, _ = lanes.step(self.actions[:, step], (step < self.steps) & ~lost)
            lost |= (terminated | truncated) & (step < self.steps)
        self.begin(lanes, lost)

    def add(self, actions, rewards, agents):
        """Those agents, bool[E], have made one step."""
        if self.steps.max() == self.actions.shape[1]:
            self.actions = np.concatenate([self.actions, np.zeros_like(self.actions)], axis=1)
        self.actions[agents, self.steps[agents]] = actions[agents]
        self.steps += agents
        self.returns += np.where(agents, rewards, 0.0)

    def end(self, agents):
        """The episodes of those agents, bool[E], are over."""
        self.number += agents


class Ended:
    """The episodes that ended during one `train`, as they end."""

    def __init__(self, num_agents):
        self.count = np.zeros(num_agents, np.int64)
        self._parts = []

    def add(self, agents, underway, terminated):
        which = np.flatnonzero(agents)
        self._parts.append((which, underway.returns[which], underway.steps[which], np.asarray(terminated)[which]))
        self.count += agents

    def history(self):
        """`History` of [E, N], in which an agent with fewer episodes than the others has empty places at the end."""
        longest = int(self.count.max(initial=0))
        shape = (len(self.count), longest)
        returns, lengths, terminated = np.full(shape, np.nan), np.zeros(shape, np.int64), np.zeros(shape, bool)
        if self._parts:
            agent, *columns = (np.concatenate(column) for column in zip(*self._parts, strict=True))
            order = np.argsort(agent, kind="stable")
            place = np.arange(len(agent)) - np.repeat(np.cumsum(self.count) - self.count, self.count)
            for array, column in zip((returns, lengths, terminated), columns, strict=True):
                array[agent[order], place] = column[order]
        return History(returns, lengths, terminated, (lengths > 0) & ~terminated)
