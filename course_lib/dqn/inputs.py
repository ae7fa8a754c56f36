"""How observations reach the networks: numbered states all at once, or vectors one by one.

Both answer the same questions; N is the number of rows that the networks are asked about at a time.

fields                      what of a transition is remembered, {name: (shape, torch dtype)}
most                        the largest number that may stand in such a field, {name: int}
transition(s, a, s_next)    those fields of one transition an agent, {name: tensor [E, …]}
asked(observations)         x, what to put into the networks, and which row of the answer is each agent's, int64[E]
question(observations, E)   the same for a learner's batch, [B, …] or [E, B, …]: x, and int64[E, B], or None where the
                            rows of the answer are in order; `ValueError` for what is no batch
batch(batch)                x, entries, next x, next rows: what to put in, and which entries s * A + a and which rows of
                            the answers belong to the transitions of a batch, int64[E, B]
"""

import gymnasium
import numpy as np
import torch


def inputs_of(observations, actions, device):
    """The way in for an agent with those spaces."""
    kind = Numbered if isinstance(observations, gymnasium.spaces.Discrete) else Vectors
    return kind(observations, int(actions.n), device)


class Numbered:
    """Discrete states, one-hot encoded.

    There are few of them, so the networks are asked about every state at once (x = None), and the batch picks from the
    table that comes out. The gradient is the one of the batch: what a state was picked for is added up.
    """

    fields = {"entry": ((), torch.int64), "next_row": ((), torch.int64)}

    def __init__(self, space, num_actions, device):
        self.first, self.num_inputs, self.num_actions, self.device = int(space.start), int(space.n), num_actions, device
        self.most = {"entry": self.num_inputs * num_actions - 1, "next_row": self.num_inputs - 1}

    def transition(self, observations, actions, following):
        entries = torch.from_numpy(observations * self.num_actions + actions).to(self.device)
        return {"entry": entries, "next_row": torch.from_numpy(following).to(self.device)}

    def asked(self, observations):
        return None, observations

    def batch(self, batch):
        return None, batch["entry"], None, batch["next_row"]

    def question(self, observations, num_agents):
        states = np.asarray(observations)
        if not np.issubdtype(states.dtype, np.integer) or not _is_batch(states.shape, (), num_agents):
            raise ValueError(
                f"observations must be states, int[B] or int[{num_agents}, B], got {states.dtype}{[*states.shape]}"
            )
        last = self.first + self.num_inputs - 1
        if states.size and (states.min() < self.first or states.max() > last):
            raise ValueError(f"states must be from {self.first} to {last}, got {states.min()} to {states.max()}")
        return None, np.broadcast_to(states - self.first, (num_agents, states.shape[-1]))


class Vectors:
    """Box observations, flattened to float32[n]; a batch goes through the networks as it is."""

    def __init__(self, space, num_actions, device):
        self.num_inputs, self.num_actions, self.device = int(np.prod(space.shape)), num_actions, device
        vector = ((self.num_inputs,), torch.float32)
        self.shape, self.most = space.shape, {"action": num_actions - 1}
        self.fields = {"observation": vector, "action": ((), torch.int64), "next_observation": vector}

    def transition(self, observations, actions, following):
        arrays = {"observation": observations, "action": actions, "next_observation": following}
        return {name: torch.from_numpy(array).to(self.device) for name, array in arrays.items()}

    def asked(self, observations):
        return torch.from_numpy(observations[:, None]).to(self.device), np.zeros(len(observations), np.int64)

    def batch(self, batch):
        rows = torch.arange(batch["action"].shape[1], device=self.device).expand(batch["action"].shape)
        return batch["observation"], rows * self.num_actions + batch["action"], batch["next_observation"], rows

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
        x = np.broadcast_to(vectors.reshape(*batch, self.num_inputs), (num_agents, batch[-1], self.num_inputs))
        return torch.from_numpy(np.ascontiguousarray(x)).to(self.device), None


def _is_batch(shape, one, num_agents):
    """Whether `shape` is that of a batch, [B, …] or [E, B, …], of observations of the shape `one`."""
    inner = len(shape) - len(one)
    return shape[inner:] == one and (inner == 1 or (inner == 2 and shape[0] == num_agents))
