"""Agents on disk: all that training needs to go on, and what is wrong with a file that holds no agent."""

import numpy as np
import torch

from course_lib.dqn import settings as wanted
from course_lib.dqn.networks import number_of_weights
from course_lib.dqn.replay import NUMPYS
from course_lib.files import generator_in, load_arrays, save_arrays

_SETTINGS = (
    "hidden", "gamma", "learning_rate", "epsilon_decay", "replay", "batch_size", "learning_starts", "target_update",
    "double", "mask_terminal", "mask_actions", "num_agents", "seed",
)  # fmt: skip


def save(agent, path):
    """Write `agent` to `path`: arrays and JSON in one safetensors file."""
    longest = int(agent._underway.steps.max())
    arrays = {name: live.cpu().numpy() for name, live in _tensors(agent).items()}
    arrays |= _counters(agent) | {"actions": agent._underway.actions[:, :longest]}
    if agent._memory is not None:
        filled = int(np.minimum(agent._memory.count, agent.replay).max())
        arrays |= {name: live[:, :filled].cpu().numpy() for name, live in _memories(agent).items()}
    chosen = {name: getattr(agent, name) for name in _SETTINGS}
    settings = {"agent": chosen, "sizes": agent._online.sizes, "generators": agent._draws.states()}
    save_arrays(path, {name: np.ascontiguousarray(array) for name, array in arrays.items()}, settings, kind="DQNAgent")


def load(cls, path, env, device):
    """The agent that `save` wrote; `ValueError` for a file that is damaged, foreign, or from another kind of world."""
    arrays, settings = load_arrays(path, kind="DQNAgent")
    env = wanted.environment(env)
    try:
        told = {"mask_actions": False, "learning_starts": None} | settings["agent"]  # which older files do not have
        chosen = {name: told[name] for name in _SETTINGS}
        generators = [generator_in(state) for state in settings["generators"]]
        sizes, shape = tuple(int(size) for size in settings["sizes"]), arrays["weights"].shape
        told = len(generators), number_of_weights(sizes)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{path} is not a saved DQNAgent: missing or of another form is {error!r}") from None
    if told != shape or chosen["num_agents"] != len(generators):
        raise ValueError(f"{path} is not a saved DQNAgent: its weights, {shape}, are not those of {told}")
    try:
        needed = wanted.network_sizes(env, chosen["hidden"])
        agent = cls(env, **chosen, device=device) if sizes == needed else None
    except ValueError as error:
        raise ValueError(f"{path} cannot be loaded: {error}") from None
    if agent is None:
        raise ValueError(f"{path} holds networks with layers of {sizes} nodes, this environment needs {needed}")
    try:
        _fill(agent, arrays)
    except (KeyError, IndexError, ValueError) as error:
        raise ValueError(f"{path} is not a saved DQNAgent: {error}") from None
    agent._draws.generators = generators
    return agent


def _tensors(agent):
    """The numbers of the networks, {name: tensor [E, P]}, to be read or written in place."""
    tensors = {"weights": agent._online.flat, "first": agent._adam.first, "second": agent._adam.second}
    return tensors if agent.target_update is None else tensors | {"target": agent._target.flat}


def _counters(agent):
    """What is counted for each agent, {name: array [E]}, to be read or written in place."""
    underway = agent._underway
    counters = {"updates": agent._adam.updates, "epsilon": agent.epsilon}
    counters |= {"episode": underway.number, "steps": underway.steps, "return": underway.returns}
    return counters if agent._memory is None else counters | {"count": agent._memory.count}


def _memories(agent):
    """The replay buffers, {name: tensor [E, capacity, …]}, to be read or written in place."""
    shape = (agent.num_agents, agent.replay)
    return {name: tensor.view(*shape, *tensor.shape[1:]) for name, tensor in agent._memory.tensors.items()}


def _fill(agent, arrays):
    """Put the arrays of a file into a new agent; `ValueError` or `KeyError` for what does not belong there."""
    for name, live in _tensors(agent).items():
        live.copy_(torch.from_numpy(_checked(arrays, name, live.shape, np.float32)))
    for name, live in _counters(agent).items():
        live[:] = _checked(arrays, name, live.shape, live.dtype)
    for name in _counters(agent).keys() - {"return"}:
        _within(arrays, name, 0, 1 if name == "epsilon" else None)
    _within(arrays, "second", 0, None)

    longest = int(agent._underway.steps.max())
    actions = _checked(arrays, "actions", (agent.num_agents, longest), np.int64)
    _within(arrays, "actions", 0, agent._inputs.num_actions - 1)
    agent._underway.actions = np.pad(actions, [(0, 0), (0, 16)])
    if agent._memory is not None:
        filled = int(np.minimum(agent._memory.count, agent.replay).max())
        for name, live in _memories(agent).items():
            shape = (agent.num_agents, filled, *live.shape[2:])
            live[:, :filled] = torch.from_numpy(_checked(arrays, name, shape, NUMPYS[live.dtype]))
        for name, most in agent._inputs.most.items():
            _within(arrays, name, 0, most)
        _within(arrays, "discount", 0, 1)
        stored = np.arange(filled) < agent._memory.count[:, None]
        if agent.mask_actions and not arrays["next_possible"].any(axis=2)[stored].all():
            raise ValueError("next_possible rules out every action")


def _checked(arrays, name, shape, dtype):
    array = arrays[name]
    if array.shape != tuple(shape) or array.dtype != dtype:
        raise ValueError(f"{name} must be {np.dtype(dtype)}{[*shape]}, got {array.dtype}{[*array.shape]}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds NaN or infinity")
    return array


def _within(arrays, name, least, most):
    array = arrays[name]
    if array.size and (array.min() < least or (most is not None and array.max() > most)):
        raise ValueError(f"{name} must be from {least} to {most}, got {array.min()} to {array.max()}")
