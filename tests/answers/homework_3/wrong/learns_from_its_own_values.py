"""The network itself says what the next state is worth; the target network is never asked."""

import copy

import numpy as np
import torch
from torch import nn

CHECK = "learns_with_a_target_that_holds_still"
SAYS = "comes from the network itself"


def learn(observations, actions, rewards, next_observations, next_possible, terminated, steps, copy_every, seed):
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = nn.Sequential(
        nn.Linear(observations.shape[1], 32),
        nn.ReLU(),
        nn.Linear(32, 32),
        nn.ReLU(),
        nn.Linear(32, next_possible.shape[1]),
    )
    target = copy.deepcopy(network)
    optimizer = torch.optim.Adam(network.parameters(), lr=0.002)
    x = torch.tensor(observations, dtype=torch.float32)
    next_x = torch.tensor(next_observations, dtype=torch.float32)
    r = torch.tensor(rewards, dtype=torch.float32)
    a, possible, over = torch.tensor(actions), torch.tensor(next_possible), torch.tensor(terminated)
    for step in range(steps):
        if step % copy_every == 0:
            target.load_state_dict(network.state_dict())
        i = rng.integers(len(a), size=64)
        with torch.no_grad():
            best = network(next_x[i]).masked_fill(~possible[i], -torch.inf).argmax(1, keepdim=True)
            after = network(next_x[i]).gather(1, best).squeeze(1)
            y = r[i] + 0.9 * after * ~over[i]
        taken = network(x[i]).gather(1, a[i][:, None]).squeeze(1)
        loss = nn.functional.mse_loss(taken, y)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    with torch.no_grad():
        return network(x).numpy()
