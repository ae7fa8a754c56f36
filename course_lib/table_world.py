"""An environment whose every step is a draw from a table that we have, so that it can be played without stepping it."""

from dataclasses import dataclass

import gymnasium
import numpy as np

from course_lib.maze import Maze
from course_lib.mdp import MDP

_NO_MORE_THAN_TIMING = (
    gymnasium.wrappers.TimeLimit,
    gymnasium.wrappers.OrderEnforcing,
    gymnasium.wrappers.PassiveEnvChecker,
)


@dataclass(frozen=True, eq=False)
class TableWorld:
    """What a `Maze`, or a toy-text world of Gymnasium's, does, as arrays.

    start         float64[1, 1, S] probabilities, or [1, 1, 1]: the state in which every episode begins
    draw_always   toy-text worlds draw a number even where only one thing can happen
    time_limit    of the `TimeLimit` wrappers around it, the shortest; None without
    """

    env: gymnasium.Env
    mdp: MDP
    start: np.ndarray
    draw_always: bool
    time_limit: int | None

    @classmethod
    def of(cls, env):
        """The table world that `env` is, or None: a subclass, a patched step or a wrapper may play by other rules."""
        time_limit, layer = None, env
        while isinstance(layer, gymnasium.Wrapper):
            if type(layer) not in _NO_MORE_THAN_TIMING or _is_patched(layer):
                return None
            if isinstance(layer, gymnasium.wrappers.TimeLimit):
                limit = layer._max_episode_steps
                time_limit = limit if time_limit is None else min(limit, time_limit)
            layer = layer.env
        if _is_patched(layer) or getattr(layer, "render_mode", None) == "human":  # somebody watches every step
            return None
        if type(layer) is Maze:
            return cls(env, layer.mdp, np.full((1, 1, 1), float(layer.start)), False, time_limit)
        if _is_toy_text(layer):
            start = np.append(layer.initial_state_distrib, 0.0)  # never a single entry, which would mean a state
            return cls(env, MDP.from_gymnasium(layer), start[None, None], True, time_limit)
        return None


def _is_patched(env):
    return bool({"step", "reset"} & vars(env).keys())


def _is_toy_text(env):
    from gymnasium.envs.toy_text import CliffWalkingEnv, FrozenLakeEnv, TaxiEnv

    return type(env) in (FrozenLakeEnv, CliffWalkingEnv, TaxiEnv) and not getattr(env, "fickle_passenger", False)
