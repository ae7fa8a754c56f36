"""E worlds side by side, one a lane, whatever they are made of: a table, environments, or a vector environment.

All of them do the same for the agent:

observations                    what every lane shows now, int64[E] (Discrete) or float32[E, n] (Box, flattened)
begin(lanes, seeds)             new episodes in those lanes, bool[E], each from its own seed, int64[E]
step(actions, lanes)            one step in those lanes: next observations, rewards, terminated, truncated, and the
                                lanes that really stepped, bool[E]. An episode's last observation is among those
                                returned, also where `observations` shows the next episode already
possible, next_possible         bool[E, A], the action masks of `observations`, and of those that the latest step
                                returned; only in lanes that are asked for masks, None in others
repeatable                      whether a lane's past can be had again from its seed and its actions
begins_by_itself                whether the next episode follows without `begin`, and an episode cannot be cut
"""

import copy

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv

from course_lib.choice import possible_actions
from course_lib.dqn.masks import masks_in
from course_lib.table_world import TableWorld

_DRAWS_AT_ONCE = 64


def lanes_of(env, num_agents, masked=False):
    """The lanes of num_agents agents, with action masks if `masked`.

    `ValueError` where `env` cannot be had so many times. Masks that are wrong or missing raise it as they turn up.
    """
    if isinstance(env, VectorEnv):
        return VectorLanes(env, masked)
    world = TableWorld.of(env)
    if world is not None and not (masked and world.possible is None):
        return TableLanes(world, num_agents, masked)
    try:
        envs = [env, *(copy.deepcopy(env) for _ in range(num_agents - 1))]
    except Exception as error:  # whatever a stranger's environment holds that cannot be copied
        raise ValueError(
            f"cannot copy {env} for {num_agents} agents ({error}): give a VectorEnv with a lane an agent"
        ) from None
    return EnvLanes(envs, masked)


class EnvLanes:
    """Environments, one a lane, stepped one after the other."""

    repeatable, begins_by_itself = True, False

    def __init__(self, envs, masked=False):
        self.envs = envs
        self.first_action = int(envs[0].action_space.start)
        self.encode = encoder(envs[0].observation_space)
        self.observations = blank(envs[0].observation_space, len(envs))
        self.possible = self.next_possible = np.ones((len(envs), envs[0].action_space.n), bool) if masked else None

    def begin(self, lanes, seeds):
        for i in np.flatnonzero(lanes):
            observation, info = self.envs[i].reset(seed=int(seeds[i]))
            self.observations[i] = self.encode(observation)
            if self.possible is not None:
                self.possible[i] = possible_actions(info, self.possible.shape[1])

    def step(self, actions, lanes):
        rewards = np.zeros(len(self.envs))
        terminated, truncated = np.zeros((2, len(self.envs)), bool)
        following = self.observations.copy()
        possible = None if self.possible is None else self.possible.copy()
        for i in np.flatnonzero(lanes):
            action = int(actions[i]) + self.first_action
            observation, rewards[i], terminated[i], truncated[i], info = self.envs[i].step(action)
            following[i] = self.encode(observation)
            if possible is not None:
                possible[i] = possible_actions(info, possible.shape[1], terminated=terminated[i])
        self.observations, self.possible = following, possible
        self.next_possible = possible
        return following, rewards, terminated, truncated, lanes


class TableLanes:
    """A `TableWorld` played by E mice at once; each draws what the environment itself would draw from the same seed.

    `states` int64[E] is where they are, of which `observations` are what they see.
    """

    repeatable, begins_by_itself = True, False

    def __init__(self, world, num_lanes, masked=False):
        mdp = world.mdp
        self.num_actions, self.num_outcomes = mdp.num_actions, mdp.next_state.shape[2]
        self.next_state, self.reward, self.terminal = (
            array.reshape(-1) for array in (mdp.next_state.astype(np.int64), mdp.reward, mdp.terminal)
        )
        self.chances = np.cumsum(mdp.probability, axis=2).reshape(-1, self.num_outcomes)
        self.start, self.starts = None if world.start is None else world.start.reshape(-1), world.starts
        self.time_limit = world.time_limit or np.iinfo(np.int64).max
        self.by_chance = world.draw_always or self.num_outcomes > 1
        self.seen, self.masks = world.observed, world.possible if masked else None
        if self.seen is not None and self.seen.ndim == 1:
            self.seen = self.seen - int(world.env.observation_space.start)
        self.states, self.steps = np.zeros((2, num_lanes), np.int64)
        self._look()
        self.generators = [None] * num_lanes
        self.drawn, self.used = np.zeros((num_lanes, _DRAWS_AT_ONCE)), np.zeros(num_lanes, np.int64)

    def begin(self, lanes, seeds):
        self.steps[lanes] = 0
        if self.by_chance:
            for i in np.flatnonzero(lanes):
                self.generators[i] = np.random.default_rng(int(seeds[i]))  # as Gymnasium seeds an environment
            self.used[lanes] = _DRAWS_AT_ONCE
        if self.starts is not None:
            for i in np.flatnonzero(lanes):
                generator = np.random.default_rng(int(seeds[i]))
                self.states[i] = self.starts[int(generator.random() * len(self.starts))]
        elif len(self.start) == 1:
            self.states[lanes] = int(self.start[0])
        else:
            self.states[lanes] = np.argmax(np.cumsum(self.start) > self._draw(lanes)[lanes, None], axis=1)
        self._look()

    def step(self, actions, lanes):
        outcome = self.states * self.num_actions + actions
        if self.by_chance:
            which = np.argmax(self.chances[outcome] > self._draw(lanes)[:, None], axis=1)
            outcome = outcome * self.num_outcomes + which
        self.steps += lanes
        self.states = np.where(lanes, self.next_state[outcome], self.states)
        self._look()
        return self.observations, self.reward[outcome], self.terminal[outcome], self.steps >= self.time_limit, lanes

    def _look(self):
        self.observations = self.states if self.seen is None else self.seen[self.states]
        self.possible = self.next_possible = None if self.masks is None else self.masks[self.states]

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

    def __init__(self, env, masked=False):
        self.env, self.mode = env, env.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP)
        self.begins_by_itself = self.mode != AutoresetMode.DISABLED
        self.first_action = int(env.single_action_space.start)
        self.encode = encoder(env.single_observation_space, lanes=env.num_envs)
        self.over, self.observations = np.zeros(env.num_envs, bool), None
        self.possible = self.next_possible = (
            np.ones((env.num_envs, env.single_action_space.n), bool) if masked else None
        )

    def begin(self, lanes, seeds):
        if self.observations is None or (lanes.all() and not self.begins_by_itself):
            generator = np.random.default_rng(seeds)
            first = int(generator.integers(2**31))  # the lanes get this one and those after it
            self._reset(np.ones_like(self.over), seed=first)
        elif lanes.any() and not self.begins_by_itself:
            self._reset(lanes, options={"reset_mask": lanes})

    def _reset(self, lanes, **how):
        observations, infos = self.env.reset(**how)
        self.observations = self.encode(observations)
        self.over = self.over & ~lanes
        if self.possible is not None:
            self.possible = masks_in(infos, self.possible, lanes, np.zeros_like(lanes))

    def step(self, actions, lanes):
        if self.mode == AutoresetMode.DISABLED and self.over.any():  # nobody plays there any more, but it must go on
            begun = self.over.copy()
            self._reset(begun, options={"reset_mask": begun})
            if self.possible is not None:  # what was chosen for the end may be impossible in the beginning
                actions = np.where(begun, self.possible.argmax(axis=1), actions)
        resting = self.over if self.mode == AutoresetMode.NEXT_STEP else np.zeros_like(self.over)
        observations, rewards, terminated, truncated, infos = self.env.step(actions + self.first_action)
        self.observations = following = self.encode(observations)
        self.over = np.asarray(terminated | truncated)
        if self.possible is not None:
            self._see_masks(infos, terminated)
        if self.mode == AutoresetMode.SAME_STEP and self.over.any():
            following = following.copy()
            last = np.stack([np.asarray(infos["final_obs"][i]) for i in np.flatnonzero(self.over)])
            following[self.over] = encoder(self.env.single_observation_space, lanes=len(last))(last)
        return following, rewards, terminated, truncated, lanes & ~resting

    def _see_masks(self, infos, terminated):
        same_step = self.mode == AutoresetMode.SAME_STEP  # in which these are masks of beginnings, never of ends
        everybody, ends = np.ones_like(self.over), np.asarray(terminated) & (not same_step)
        self.possible = self.next_possible = masks_in(infos, self.possible, everybody, ends)
        if same_step and self.over.any():
            self.next_possible = masks_in(infos.get("final_info", {}), self.possible, self.over, terminated)


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
