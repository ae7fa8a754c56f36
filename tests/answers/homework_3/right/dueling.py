"""Typed, with small classes: a dueling network, SGD with momentum, and early stopping as an object."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

Layer = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True)
class Scale:
    sigma: float

    @classmethod
    def of(cls, returns: NDArray[np.float64]) -> Scale:
        return cls(float(np.sqrt(np.mean((returns - returns.mean()) ** 2))))

    def __call__(self, returns: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.minimum(np.maximum(returns / self.sigma, -5.0), 5.0)


def network_inputs(close: NDArray[np.float64], num_train: int, k: int) -> NDArray[np.float64]:
    logs = np.log(close)
    scaled = Scale.of(logs[1:num_train] - logs[: num_train - 1])(logs[1:] - logs[:-1])
    columns = [np.r_[[np.nan] * k, scaled[j : len(scaled) - k + 1 + j]] for j in range(k)]
    return np.column_stack(columns)


def q_values(x: NDArray[np.float64], layers: Sequence[Layer]) -> NDArray[np.float64]:
    def outputs() -> Iterator[NDArray[np.float64]]:
        rows = x
        for weights, biases in layers:
            before = np.dot(rows, weights) + biases[None, :]
            yield before
            rows = before * (before > 0)

    *_, last = outputs()
    return last


def targets(rewards, terminated, next_possible, next_online, next_target, gamma: float) -> NDArray[np.float64]:
    lowest = next_online.min() - 1.0
    masked = next_online.copy()
    masked[~next_possible] = lowest
    one_hot = np.eye(next_online.shape[1])[masked.argmax(axis=1)]
    discount = np.where(terminated, 0.0, gamma)
    return rewards + discount * (one_hot * next_target).sum(axis=1)


class Dueling(nn.Module):
    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.trunk = nn.Sequential(nn.Linear(inputs, 32), nn.ReLU(), nn.Linear(32, 32), nn.ReLU())
        self.value = nn.Linear(32, 1)
        self.advantage = nn.Linear(32, outputs)

    def forward(self, x: Tensor) -> Tensor:
        x = self.trunk(x)
        advantage = self.advantage(x)
        return self.value(x) + advantage - advantage.mean(dim=-1, keepdim=True)


def learn(observations, actions, rewards, next_observations, next_possible, terminated, steps, copy_every, seed):
    torch.manual_seed(seed)
    network = Dueling(observations.shape[1], next_possible.shape[1])
    target = copy.deepcopy(network).requires_grad_(False)
    optimizer = torch.optim.SGD(network.parameters(), lr=0.01, momentum=0.9)
    x = torch.as_tensor(observations, dtype=torch.float32)
    there = torch.as_tensor(next_observations, dtype=torch.float32)
    data = torch.utils.data.TensorDataset(
        x,
        torch.as_tensor(actions),
        torch.as_tensor(rewards, dtype=torch.float32),
        there,
        torch.as_tensor(next_possible),
        torch.as_tensor(terminated),
    )
    for step in range(steps):
        s, a, r, s2, possible, over = data[torch.randint(len(data), (64,))]
        best = network(s2).detach().masked_fill(possible.logical_not(), -torch.inf).argmax(1, keepdim=True)
        after = target(s2).gather(1, best).flatten()
        y = torch.where(over, r, r + 0.9 * after)
        loss = nn.functional.mse_loss(network(s).gather(1, a.unsqueeze(1)).flatten(), y)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        if not (step + 1) % copy_every:
            target.load_state_dict(network.state_dict())
    with torch.inference_mode():
        return network(x).numpy()


@dataclass
class Stopper:
    patience: int
    best: int = 0
    scores: list[float] = field(default_factory=list)

    def goes_on(self, score: float) -> bool:
        self.scores.append(score)
        if score > self.scores[self.best]:
            self.best = len(self.scores) - 1
        return len(self.scores) - 1 - self.best < self.patience


def best_moment(validation: NDArray[np.float64], patience: int) -> tuple[int, int]:
    stopper = Stopper(patience)
    for score in validation:
        if not stopper.goes_on(score):
            break
    return len(stopper.scores) - 1, stopper.best
