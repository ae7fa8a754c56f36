"""Loops and lists as far as they go, and lists returned; a network as a class of its own, with Huber's loss."""

import math
import random

import torch


def network_inputs(close, num_train, k):
    returns = [None] + [math.log(close[t] / close[t - 1]) for t in range(1, len(close))]
    train = returns[1:num_train]
    mean = sum(train) / len(train)
    sigma = math.sqrt(sum((r - mean) ** 2 for r in train) / len(train))
    rows = []
    for t in range(len(close)):
        if t < k:
            rows.append([float("nan")] * k)
        else:
            rows.append([max(-5.0, min(5.0, r / sigma)) for r in returns[t - k + 1 : t + 1]])
    return rows


def q_values(x, layers):
    rows = [list(row) for row in x]
    for number, (weights, biases) in enumerate(layers, start=1):
        new_rows = []
        for row in rows:
            outputs = []
            for j in range(len(biases)):
                total = biases[j]
                for i in range(len(row)):
                    total += row[i] * weights[i][j]
                if number < len(layers) and total < 0:
                    total = 0.0
                outputs.append(total)
            new_rows.append(outputs)
        rows = new_rows
    return rows


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    y = []
    for i in range(len(rewards)):
        if terminated[i]:
            y.append(rewards[i])
            continue
        possible = [a for a in range(len(next_online[i])) if next_possible[i][a]]
        best = max(possible, key=lambda a: next_online[i][a])
        y.append(rewards[i] + gamma * next_target[i][best])
    return y


class Network(torch.nn.Module):
    def __init__(self, inputs, outputs):
        super().__init__()
        self.first = torch.nn.Linear(inputs, 64)
        self.second = torch.nn.Linear(64, outputs)

    def forward(self, x):
        return self.second(torch.relu(self.first(x)))


def learn(observations, actions, rewards, next_observations, next_possible, terminated, steps, copy_every, seed):
    chance = random.Random(seed)
    torch.manual_seed(seed)
    network = Network(observations.shape[1], next_possible.shape[1])
    target = Network(observations.shape[1], next_possible.shape[1])
    target.load_state_dict(network.state_dict())
    optimizer = torch.optim.Adam(network.parameters(), 0.002)
    x = torch.tensor(observations.tolist())
    next_x = torch.tensor(next_observations.tolist())
    for step in range(1, steps + 1):
        batch = chance.sample(range(len(actions)), 64)
        online, there = network(next_x[batch]).tolist(), target(next_x[batch]).tolist()
        y = targets(
            [rewards[i] for i in batch],
            [terminated[i] for i in batch],
            [next_possible[i] for i in batch],
            online,
            there,
            0.9,
        )
        values = network(x[batch])
        taken = values[list(range(64)), [actions[i] for i in batch]]
        loss = torch.nn.functional.smooth_l1_loss(taken, torch.tensor(y, dtype=torch.float32))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        if step % copy_every == 0:
            target.load_state_dict(network.state_dict())
    return network(x).tolist()


def best_moment(validation, patience):
    best_score, best_stage, age = -math.inf, None, 0
    for stage, score in enumerate(validation):
        if score > best_score:
            best_score, best_stage, age = score, stage, 0
        else:
            age += 1
        if age == patience:
            return [stage, best_stage]
    return [len(validation) - 1, best_stage]
