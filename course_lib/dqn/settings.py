"""What agents are made from, checked: one clear `ValueError` for whatever cannot be meant."""

import gymnasium
import numpy as np
import torch
from gymnasium.vector import VectorEnv

from course_lib.validate import number, whole_number


def environment(env):
    if not isinstance(env, str):
        return env
    try:
        return gymnasium.make(env)
    except (gymnasium.error.Error, ImportError) as error:
        raise ValueError(f"there is no environment {env!r}: {' '.join(str(error).split())}") from None


def spaces(env):
    """The spaces of one agent's observations and actions, or a `ValueError`."""
    single = "single_" if isinstance(env, VectorEnv) else ""
    observations = getattr(env, f"{single}observation_space", None)
    actions = getattr(env, f"{single}action_space", None)
    if not isinstance(observations, gymnasium.spaces.Discrete | gymnasium.spaces.Box):
        raise ValueError(f"DQNAgent needs an environment with a Discrete or Box observation_space, got {observations}")
    if not isinstance(actions, gymnasium.spaces.Discrete):
        raise ValueError(f"DQNAgent needs an environment with a Discrete action_space, got {actions}")
    return observations, actions


def network_sizes(env, hidden):
    """The numbers of nodes, from inputs to outputs, of a network for `env` with those hidden layers."""
    observations, actions = spaces(env)
    inputs = observations.n if isinstance(observations, gymnasium.spaces.Discrete) else np.prod(observations.shape)
    try:
        hidden = tuple(whole_number("a hidden layer's size", nodes, at_least=1) for nodes in hidden)
    except TypeError:
        raise ValueError(f"hidden must be the sizes of the hidden layers, such as (20,), got {hidden!r}") from None
    return (int(inputs), *hidden, int(actions.n))


def positive(name, value):
    """`value` as a float above 0."""
    result = number(name, value)
    if result <= 0:
        raise ValueError(f"{name} must be positive, got {value!r}")
    return result


def weights(weights, shape):
    """`weights` as float32 of that shape, all finite."""
    try:
        with np.errstate(over="ignore"):  # what is too large becomes infinite, and is refused below
            flat = np.array(weights, np.float32)
    except (TypeError, ValueError):
        raise ValueError(f"weights must be numbers, got {weights!r}") from None
    if flat.shape != tuple(shape) or not np.isfinite(flat).all():
        raise ValueError(
            f"weights must be {[*shape]} finite numbers, got {[*flat.shape]}, or NaN or infinity among them"
        )
    return flat


def learning_starts(learning_starts, batch_size, replay):
    if learning_starts is None:
        return batch_size
    learning_starts = whole_number("learning_starts", learning_starts, at_least=batch_size)
    if replay is None and learning_starts > 1:
        raise ValueError(f"learning_starts of {learning_starts} needs a replay buffer to collect in, got replay=None")
    return learning_starts


def target_update(target_update):
    if target_update is None:
        return None
    if isinstance(target_update, float) and 0 < target_update < 1:
        return target_update
    try:
        return whole_number("target_update", target_update, at_least=1, below=2**63)
    except ValueError:
        raise ValueError(
            f"target_update must be None, a number of steps from 1 or a fraction below 1, got {target_update!r}"
        ) from None


def number_of_agents(num_agents, env):
    lanes = env.num_envs if isinstance(env, VectorEnv) else None
    num_agents = whole_number("num_agents", num_agents if num_agents is not None else lanes or 1, at_least=1)
    if lanes not in (None, num_agents):
        raise ValueError(f"a VectorEnv needs a lane an agent, got {lanes} lanes for {num_agents} agents")
    return num_agents


def device(device):
    try:
        device = torch.device(device)
        torch.empty(0, device=device).cpu()
    except (RuntimeError, AssertionError, TypeError, ImportError) as error:
        reason = str(error).strip().splitlines()[0]
        raise ValueError(f"device must be one that torch has here, such as 'cpu', got {device!r} ({reason})") from None
    return device


def how_long(num_episodes, num_steps):
    """How many episodes and how many steps, at most."""
    if num_episodes is None and num_steps is None:
        raise ValueError("say how long to train: num_episodes or num_steps")
    endless = np.iinfo(np.int64).max
    episodes = endless if num_episodes is None else whole_number("num_episodes", num_episodes)
    return episodes, endless if num_steps is None else whole_number("num_steps", num_steps)
