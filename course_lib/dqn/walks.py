"""Walks of E agents that learn nothing from them."""

import numpy as np

from course_lib.history import Rollout


def greedy_walks(lanes, choose, seeds, max_steps):
    """[Rollout] of every agent's episodes, agent by agent.

    choose   observations -> actions, int64[E];  seeds   int64[E, episodes], what each episode begins from
    `ValueError` where an episode has to be cut in lanes that begin the next one only when they like.
    """
    num_agents, num_episodes = seeds.shape
    walks = [[] for _ in range(num_agents)]
    under_way = [_Walk() for _ in range(num_agents)]
    playing = np.ones(num_agents, bool)
    lanes.begin(playing, seeds[:, 0])
    while playing.any():
        observations = lanes.observations
        actions = choose(observations)
        following, rewards, terminated, truncated, stepped = lanes.step(actions, playing)
        over = np.zeros(num_agents, bool)
        for i in np.flatnonzero(stepped):
            walk = under_way[i]
            walk.add(observations[i], actions[i], rewards[i])
            over[i] = terminated[i] or truncated[i] or len(walk.actions) == max_steps
            if over[i]:
                walks[i].append(walk.finished(following[i], bool(terminated[i])))
                under_way[i] = _Walk()
                playing[i] = len(walks[i]) < num_episodes
                if playing[i] and lanes.begins_by_itself and not (terminated[i] or truncated[i]):
                    raise ValueError(f"a walk in lane {i} is not over after {max_steps} steps: max_steps cannot cut it")
        again = over & playing
        if again.any():
            number = np.array([min(len(done), num_episodes - 1) for done in walks])
            lanes.begin(again, seeds[np.arange(num_agents), number])
    return [walk for done in walks for walk in done]


class _Walk:
    def __init__(self):
        self.observations, self.actions, self.rewards = [], [], []

    def add(self, observation, action, reward):
        self.observations.append(observation.copy())
        self.actions.append(action)
        self.rewards.append(reward)

    def finished(self, last, terminated):
        states = np.array([*self.observations, last])
        return Rollout(states, np.array(self.actions), np.array(self.rewards, float), terminated, not terminated)
