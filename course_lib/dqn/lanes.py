"""E worlds side by side, one a lane, whatever they are made of: a table, environments, or a vector environment.

All of them do the same for the agent:

observations                    what every lane shows now, int64[E] (Discrete) or float32[E, n] (Box, flattened)
begin(lanes, seeds)             new episodes in those lanes, bool[E], each from its own seed, int64[E]
step(actions, lanes)            one step in those lanes: next observations, rewards, terminated, truncated, and the
                                lanes that really stepped, bool[E]. An episode's last observation is among those
                                returned, also where `observations` shows the next episode already
repeatable                      whether a lane's past can be had again from its seed and its actions
begins_by_itself                whether the next episode follows without `begin`, and an episode cannot be cut
"""

import copy

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv

from course_lib.table_world import TableWorld

_DRAWS_AT_ONCE = 64


def lanes_of(env, num_agents):
    """The lanes of num_agents agents; `ValueError` where `env` cannot be had so many times."""
    if isinstance(env, VectorEnv):
        return VectorLanes(env)
    world = TableWorld.of(env)
    if world is not None:
        return TableLanes(world, num_agents)
    try:
        envs = [env, *(copy.deepcopy(env) for _ in range(num_agents - 1))]
    except Exception as error:  # whatever a stranger's environment holds that cannot be copied
        raise ValueError(
            f"cannot copy {env} for {num_agents} agents ({error}): give a VectorEnv with a lane an agent"
        ) from None
    return EnvLanes(envs)


class EnvLanes:
    """Environments, one a lane, stepped one after the other."""

    repeatable, begins_by_itself = True, False

    def __init__(self, envs):
        self.envs = envs
        self.first_action = int(envs[0].action_space.start)
        self.encode = encoder(envs[0].observation_space)
        self.observations = blank(envs[0].observation_space, len(envs))

    def begin(self, lanes, seeds):
        for i in np.flatnonzero(lanes):
            self.observations[i] = self.encode(self.envs[i].reset(seed=int(seeds[i]))[0])

    def step(self, actions, lanes):
        rewards = np.zeros(len(self.envs))
        terminated, truncated = np.zeros((2, len(self.envs)), bool)
        following = self.observations.copy()
        for i in np.flatnonzero(lanes):
            action = int(actions[i]) + self.first_action
            observation, rewards[i], terminated[i], truncated[i], _ = self.envs[i].step(action)
            following[i] = self.encode(observation)
        self.observations = following
        return following, rewards, terminated, truncated, lanes


class TableLanes:
    """A `TableWorld` played by E mice at once; each draws what the environment itself would draw from the same seed."""

    repeatable, begins_by_itself = True, False

    def __init__(self, world, num_lanes):
        mdp = world.mdp
        self.num_actions, self.num_outcomes = mdp.num_actions, mdp.next_state.shape[2]
        self.next_state, self.reward, self.terminal = (
            array.reshape(-1) for array in (mdp.next_state.astype(np.int64), mdp.reward, mdp.terminal)
        )
        self.chances = np.cumsum(mdp.probability, axis=2).reshape(-1, self.num_outcomes)
        self.start = world.start.reshape(-1)
        self.time_limit = world.time_limit or np.iinfo(np.int64).max
        self.by_chance = world.draw_always or self.num_outcomes > 1
        self.observations, self.steps = np.zeros((2, num_lanes), np.int64)
        self.generators = [None] * num_lanes
        self.drawn, self.used = np.zeros((num_lanes, _DRAWS_AT_ONCE)), np.zeros(num_lanes, np.int64)

    def begin(self, lanes, seeds):
        self.steps[lanes] = 0
        if self.by_chance:
            for i in np.flatnonzero(lanes):
                self.generators[i] = np.random.default_rng(int(seeds[i]))  # as Gymnasium seeds an environment
            self.used[lanes] = _DRAWS_AT_ONCE
        if len(self.start) == 1:
            self.observations[lanes] = int(self.start[0])
        else:
            self.observations[lanes] = np.argmax(np.cumsum(self.start) > self._draw(lanes)[lanes, None], axis=1)

    def step(self, actions, lanes):
        outcome = self.observations * self.num_actions + actions
        if self.by_chance:
            which = np.argmax(self.chances[outcome] > self._draw(lanes)[:, None], axis=1)
            outcome = outcome * self.num_outcomes + which
        self.steps += lanes
        self.observations = np.where(lanes, self.next_state[outcome], self.observations)
        return self.observations, self.reward[outcome], self.terminal[outcome], self.steps >= self.time_limit, lanes

    def _draw(self, lanes):
        """The next number between 0 and 1 of each of those lanes' generators, float64[E]."""
        for i in np.flatnonzero(lanes & (self.used == _DRAWS_AT_ONCE)):
            self.generators[i].random(out=self.drawn[i])
            self.used[i] = 0
        drawn = self.drawn[np.arange(len(self.used)), self.used % _DRAWS_AT_ONCE]
        self.used += lanes
        return drawn


class VectorLanes:
    """Any Gymnasium `VectorEnv`, whichever way it begins new episodes. Its lanes draw as it likes."""

    repeatable = False

    def __init__(self, env):
        self.env, self.mode = env, env.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP)
        self.begins_by_itself = self.mode != AutoresetMode.DISABLED
        self.first_action = int(env.single_action_space.start)
        self.encode = encoder(env.single_observation_space, lanes=env.num_envs)
        self.over, self.observations = np.zeros(env.num_envs, bool), None

    def begin(self, lanes, seeds):
        if self.observations is None or (lanes.all() and not self.begins_by_itself):
            generator = np.random.default_rng(seeds)
            first = int(generator.integers(2**31))  # the lanes get this one and those after it
            self.observations = self.encode(self.env.reset(seed=first)[0])
            self.over[:] = False
        elif lanes.any() and not self.begins_by_itself:
            self._reset(lanes)

    def _reset(self, lanes):
        self.observations = self.encode(self.env.reset(options={"reset_mask": lanes})[0])
        self.over &= ~lanes

    def step(self, actions, lanes):
        if self.mode == AutoresetMode.DISABLED and self.over.any():  # nobody plays there any more, but it must go on
            self._reset(self.over.copy())
        resting = self.over if self.mode == AutoresetMode.NEXT_STEP else np.zeros_like(self.over)
        observations, rewards, terminated, truncated, infos = self.env.step(actions + self.first_action)
        self.observations = following = self.encode(observations)
        self.over = np.asarray(terminated | truncated)
        if self.mode == AutoresetMode.SAME_STEP and self.over.any():
            following = following.copy()
            last = np.stack([np.asarray(infos["final_obs"][i]) for i in np.flatnonzero(self.over)])
            following[self.over] = encoder(self.env.single_observation_space, lanes=len(last))(last)
        return following, rewards, terminated, truncated, lanes & ~resting


def blank(space, num_lanes):
    """Room for the observations of so many lanes."""
    if isinstance(space, gymnasium.spaces.Discrete):
        return np.zeros(num_lanes, np.int64)
    return np.zeros((num_lanes, int(np.prod(space.shape))), np.float32)


def encoder(space, lanes=None):
    """A function from an observation of `space`, or from a stack of `lanes` of them, to what the networks take."""
    if isinstance(space, gymnasium.spaces.Discrete):
        return lambda observation: np.array(observation, np.int64) - int(space.start)
    shape = (-1,) if lanes is None else (lanes, -1)
    return lambda observation: np.array(observation, np.float32).reshape(shape)
