"""Torch for everything, in float32; parameters of its own, F.linear, and RMSprop."""

import math

import torch
import torch.nn.functional as F


def network_inputs(close, num_train, k):
    returns = torch.from_numpy(close).log().diff()
    scaled = (returns / returns[: num_train - 1].std(correction=0)).clamp(-5, 5)
    rows = torch.full((len(close), k), torch.nan)
    rows[k:] = scaled.unfold(0, k, 1).float()
    return rows.numpy()


def q_values(x, layers):
    x = torch.tensor(x, dtype=torch.float32)
    *hidden, (last_weights, last_biases) = layers
    for weights, biases in hidden:
        x = F.relu(F.linear(x, torch.tensor(weights.T, dtype=torch.float32), torch.tensor(biases, dtype=torch.float32)))
    return (x @ torch.tensor(last_weights).float() + torch.tensor(last_biases).float()).numpy()


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    online = torch.as_tensor(next_online).masked_fill(~torch.as_tensor(next_possible), float("-inf"))
    after = torch.as_tensor(next_target).gather(1, online.argmax(dim=1, keepdim=True)).squeeze(1)
    return (torch.as_tensor(rewards) + gamma * after.masked_fill(torch.as_tensor(terminated), 0.0)).numpy()


def forward(parameters, x):
    for i in range(0, len(parameters) - 2, 2):
        x = F.relu(F.linear(x, parameters[i], parameters[i + 1]))
    return F.linear(x, parameters[-2], parameters[-1])


def learn(observations, actions, rewards, next_observations, next_possible, terminated, steps, copy_every, seed):
    generator = torch.Generator().manual_seed(seed)
    sizes = [observations.shape[1], 32, 32, next_possible.shape[1]]
    parameters = []
    for n, m in zip(sizes, sizes[1:]):
        parameters.append(torch.randn(m, n, generator=generator) / math.sqrt(n))
        parameters.append(torch.zeros(m))
    for parameter in parameters:
        parameter.requires_grad_()
    old = [parameter.detach().clone() for parameter in parameters]
    optimizer = torch.optim.RMSprop(parameters, lr=0.001)
    x, next_x = torch.tensor(observations).float(), torch.tensor(next_observations).float()
    for step in range(steps):
        batch = torch.randperm(len(x), generator=generator)[:64]
        with torch.no_grad():
            y = targets(
                rewards[batch],
                terminated[batch],
                next_possible[batch],
                forward(parameters, next_x[batch]),
                forward(old, next_x[batch]),
                0.9,
            )
        chosen = F.one_hot(torch.tensor(actions)[batch], sizes[-1])
        loss = F.mse_loss((forward(parameters, x[batch]) * chosen).sum(dim=1), torch.tensor(y).float())
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        if (step + 1) % copy_every == 0:
            old = [parameter.detach().clone() for parameter in parameters]
    return forward(parameters, x).detach().numpy()


def best_moment(validation, patience):
    scores = torch.tensor(validation)
    for stop in range(len(scores)):
        best = int(scores[: stop + 1].argmax())
        if stop - best >= patience:
            break
    return stop, best
