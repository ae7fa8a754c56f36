"""An environment whose every step is a draw from a table that we have, so that it can be played without stepping it."""

from dataclasses import dataclass

import gymnasium
import numpy as np

from course_lib.choice import checked_mask
from course_lib.maze import Maze
from course_lib.mdp import MDP
from course_lib.validate import whole_number

_NO_MORE_THAN_TIMING = (
    gymnasium.wrappers.TimeLimit,
    gymnasium.wrappers.OrderEnforcing,
    gymnasium.wrappers.PassiveEnvChecker,
)
_TOLD = ("mdp", "observed", "possible", "starts", "time_limit")  # by a world's own as_table_world


@dataclass(frozen=True, eq=False)
class TableWorld:
    """What a `Maze`, a toy-text world of Gymnasium's, or a world that says so itself does, as arrays.

    start         float64[1, 1, S] probabilities, or [1, 1, 1]: the state in which every episode begins
    draw_always   toy-text worlds draw a number even where only one thing can happen
    time_limit    of the `TimeLimit` wrappers around it, the shortest; None without

    A world says so itself by a method `as_table_world`, of its own class, which gives a dictionary of `mdp` (K = 1),
    its own `time_limit`, in steps, or None, and

    observed      what is seen in each state, int64[S] or float32[S, n]; None: the number of the state
    possible      bool[S, A], the action masks; None: there are none
    starts        a `range` of states: an episode begins in starts[int(np_random.random() * len(starts))]

    Nothing but the start is drawn in it, and that at every reset. `ValueError` where these do not fit together.
    """

    env: gymnasium.Env
    mdp: MDP
    start: np.ndarray | None
    draw_always: bool
    time_limit: int | None
    observed: np.ndarray | None = None
    possible: np.ndarray | None = None
    starts: range | None = None

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
        if "as_table_world" in vars(type(layer)):
            return cls._told_by(layer, env, time_limit)
        if type(layer) is Maze:
            return cls(env, layer.mdp, np.full((1, 1, 1), float(layer.start)), False, time_limit)
        if _is_toy_text(layer):
            start = np.append(layer.initial_state_distrib, 0.0)  # never a single entry, which would mean a state
            return cls(env, MDP.from_gymnasium(layer), start[None, None], True, time_limit)
        return None

    @classmethod
    def _told_by(cls, world, env, time_limit):
        """What `world` says about itself, checked: compiled loops look up whatever they are told to."""
        told = world.as_table_world()
        mdp, observed, possible, starts, limit = (told.get(name) for name in _TOLD)
        if not isinstance(mdp, MDP) or mdp.next_state.shape[2] != 1 or mdp.num_actions != env.action_space.n:
            raise ValueError(f"mdp must be an MDP of {env.action_space.n} actions with 1 outcome each, got {mdp!r}")
        if possible is not None:
            possible = checked_mask(possible, (mdp.num_states, mdp.num_actions), "possible")
        ends = (starts[0], starts[-1]) if isinstance(starts, range) and starts else (-1,)
        if min(ends) < 0 or max(ends) >= mdp.num_states:
            raise ValueError(f"starts must be a range of states from 0 to {mdp.num_states - 1}, got {starts!r}")
        observed = _as_seen(observed, mdp.num_states, env.observation_space)
        if limit is not None:
            limit = whole_number("time_limit", limit, at_least=1)
            time_limit = limit if time_limit is None else min(limit, time_limit)
        return cls(env, mdp, None, False, time_limit, observed, possible, starts)


def _as_seen(observed, num_states, space):
    """What is seen in each state, int64[S] or float32[S, n], or None; `ValueError` for what is not in `space`."""
    by_number = isinstance(space, gymnasium.spaces.Discrete)
    if observed is None and by_number and space.n == num_states:
        return None
    observed = np.asarray(observed)
    if by_number:
        fits = observed.shape == (num_states,) and np.issubdtype(observed.dtype, np.integer)
        fits = fits and observed.min() >= space.start and observed.max() < space.start + space.n
        wanted = f"{num_states} whole numbers"
    else:
        shape = (num_states, int(np.prod(space.shape)))
        fits = observed.shape == shape and np.issubdtype(observed.dtype, np.floating)
        wanted = f"{[*shape]} floats"
    if not fits:
        raise ValueError(f"observed must be {wanted} in {space}, got {observed.dtype}{[*observed.shape]}")
    return np.ascontiguousarray(observed, np.int64 if by_number else np.float32)


def _is_patched(env):
    return bool({"step", "reset"} & vars(env).keys())


def _is_toy_text(env):
    from gymnasium.envs.toy_text import CliffWalkingEnv, FrozenLakeEnv, TaxiEnv

    return type(env) in (FrozenLakeEnv, CliffWalkingEnv, TaxiEnv) and not getattr(env, "fickle_passenger", False)
