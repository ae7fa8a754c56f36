"""How observations reach the networks: as vectors, or as numbers of states.

All ways in answer the same questions; N is the number of rows that the networks are asked about at a time.

fields                      what of a transition is remembered, {name: (shape, torch dtype)}
most                        the largest number that may stand in such a field, {name: int}
transition(s, a, s_next)    those fields of one transition an agent, {name: tensor [E, …]}
asked(observations)         x, what to put into the networks, and which row of the answer is each agent's, int64[E]
question(observations, E)   x for a learner's batch, [B, …] or [E, B, …]; `ValueError` for what is no batch
as_seen(observations)       what the environment itself calls a stack of encoded observations
asks_all                    whether what is asked about to act serves for learning, too
batch(batch)                x, entries, next x, next rows: what to put in, and which entries s * A + a and which rows of
                            the answers belong to the transitions of a batch, int64[E, B]
"""

import gymnasium
import numpy as np
import torch

_FEW = 64  # states, up to which it is quicker to ask about all of them than to pick some


def inputs_of(observations, actions, device):
    """The way in for an agent with those spaces."""
    if not isinstance(observations, gymnasium.spaces.Discrete):
        return Vectors(observations, int(actions.n), device)
    return (FewStates if observations.n <= _FEW else ManyStates)(observations, int(actions.n), device)


class Vectors:
    """Box observations, flattened to float32[n]: what is asked about goes through the networks as it is."""

    asks_all = False

    def __init__(self, space, num_actions, device):
        self.num_actions, self.device, self.shape = num_actions, device, space.shape
        self.fields = self._fields((int(np.prod(space.shape)),), torch.float32)
        self.most = {"action": num_actions - 1}

    def _fields(self, shape, dtype):
        return {"observation": (shape, dtype), "action": ((), torch.int64), "next_observation": (shape, dtype)}

    def transition(self, observations, actions, following):
        arrays = {"observation": observations, "action": actions, "next_observation": following}
        return {name: torch.from_numpy(array).to(self.device) for name, array in arrays.items()}

    def asked(self, observations):
        return torch.from_numpy(observations[:, None]).to(self.device), np.zeros(len(observations), np.int64)

    def question(self, observations, num_agents):
        try:
            vectors = np.asarray(observations, np.float32)
        except (TypeError, ValueError):
            raise ValueError(f"observations must be numbers, got {observations!r}") from None
        if not _is_batch(vectors.shape, self.shape, num_agents):
            wanted = ", ".join(map(str, self.shape))
            raise ValueError(
                f"observations must have shape [B, {wanted}] or [{num_agents}, B, {wanted}], got {[*vectors.shape]}"
            )
        batch = vectors.shape[: vectors.ndim - len(self.shape)]
        size = int(np.prod(self.shape))
        x = np.broadcast_to(vectors.reshape(*batch, size), (num_agents, batch[-1], size))
        return torch.from_numpy(np.array(x, order="C")).to(self.device)

    def as_seen(self, observations):
        return observations.reshape(-1, *self.shape)

    def batch(self, batch):
        rows = torch.arange(batch["action"].shape[1], device=self.device).expand(batch["action"].shape)
        return batch["observation"], rows * self.num_actions + batch["action"], batch["next_observation"], rows


class ManyStates(Vectors):
    """Discrete states, one-hot encoded: an observation is the number of the input that is 1."""

    def __init__(self, space, num_actions, device):
        self.num_actions, self.device = num_actions, device
        self.first, self.num_states = int(space.start), int(space.n)
        self.fields = self._fields((), torch.int64)
        last = self.num_states - 1
        self.most = {"action": num_actions - 1, "observation": last, "next_observation": last}

    def question(self, observations, num_agents):
        states = np.asarray(observations)
        if not np.issubdtype(states.dtype, np.integer) or not _is_batch(states.shape, (), num_agents):
            raise ValueError(
                f"observations must be states, int[B] or int[{num_agents}, B], got {states.dtype}{[*states.shape]}"
            )
        last = self.first + self.num_states - 1
        if states.size and (states.min() < self.first or states.max() > last):
            raise ValueError(f"states must be from {self.first} to {last}, got {states.min()} to {states.max()}")
        x = np.broadcast_to(states.astype(np.int64) - self.first, (num_agents, states.shape[-1]))
        return torch.from_numpy(np.array(x, order="C")).to(self.device)

    def as_seen(self, observations):
        return observations + self.first


class FewStates(ManyStates):
    """Discrete states, so few that the networks are asked about every one of them at once (x = None).

    An answer is then a whole table, the same for acting and for learning, and a batch picks from it. The gradient is
    that of the batch: what a state was picked for is added up.
    """

    asks_all = True

    def __init__(self, space, num_actions, device):
        super().__init__(space, num_actions, device)
        self.fields = {"entry": ((), torch.int64), "next_state": ((), torch.int64)}
        self.most = {"entry": self.num_states * num_actions - 1, "next_state": self.num_states - 1}

    def transition(self, observations, actions, following):
        entries = torch.from_numpy(observations * self.num_actions + actions).to(self.device)
        return {"entry": entries, "next_state": torch.from_numpy(following).to(self.device)}

    def asked(self, observations):
        return None, observations

    def batch(self, batch):
        return None, batch["entry"], None, batch["next_state"]


def _is_batch(shape, one, num_agents):
    """Whether `shape` is that of a batch, [B, …] or [E, B, …], of observations of the shape `one`."""
    inner = len(shape) - len(one)
    return shape[inner:] == one and (inner == 1 or (inner == 2 and shape[0] == num_agents))
