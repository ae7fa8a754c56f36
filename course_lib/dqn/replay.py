"""What the agents remember: E replay buffers side by side (Lin, 1992; Mnih et al., 2015)."""

import numpy as np
import torch

NUMPYS = {torch.float32: np.float32, torch.int64: np.int64, torch.bool: np.bool_}  # what stands for it in NumPy


class Replay:
    """The last `capacity` transitions of each of E agents, in tensors of [E * capacity, …], the oldest overwritten.

    fields  {name: (shape of one entry, torch dtype)}
    count   int64[E], how many transitions each agent has stored so far
    """

    def __init__(self, num_agents, capacity, fields, device):
        self.capacity, self.device = capacity, device
        try:
            self.tensors = {
                name: _zeros((num_agents * capacity, *shape), dtype, device) for name, (shape, dtype) in fields.items()
            }
        except (RuntimeError, MemoryError, ValueError, TypeError, OverflowError):
            raise ValueError(f"there is no memory for {capacity:,} transitions of {num_agents:,} agents") from None
        self.count = np.zeros(num_agents, np.int64)
        self._first = np.arange(num_agents) * capacity  # where an agent's entries begin

    def store(self, transition, agents):
        """Add one transition for each of those agents, bool[E]; transition: {name: tensor [E, …]}."""
        everybody = agents.all()
        places = self._first + self.count % self.capacity
        places = torch.from_numpy(places if everybody else places[agents]).to(self.device)
        chosen = None if everybody else torch.from_numpy(agents).to(self.device)
        for name, values in transition.items():
            self.tensors[name].index_copy_(0, places, values if everybody else values[chosen])
        self.count += agents

    def sample(self, numbers):
        """A batch {name: tensor [E, B, …]}; numbers, float64[E, B] in [0, 1), say which of an agent's entries."""
        filled = np.minimum(self.count, self.capacity)
        places = (numbers * filled[:, None]).astype(np.int64) + self._first[:, None]
        places = torch.from_numpy(places).to(self.device)
        shape, places = places.shape, places.reshape(-1)
        return {
            name: tensor.index_select(0, places).view(*shape, *tensor.shape[1:])
            for name, tensor in self.tensors.items()
        }


def _zeros(shape, dtype, device):
    """Zeros; on a processor by way of NumPy, which takes no memory for what has never been stored in."""
    if device.type != "cpu":
        return torch.zeros(shape, dtype=dtype, device=device)
    return torch.from_numpy(np.zeros(shape, NUMPYS[dtype]))
