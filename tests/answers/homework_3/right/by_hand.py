"""No torch at all: forward, backward and Adam written out in numpy; comprehensions elsewhere."""

import numpy as np


def network_inputs(close, num_train, k):
    r = np.concatenate(([np.nan], np.diff(np.log(close))))
    r /= np.std(r[1:num_train])
    r = np.clip(r, -5, 5)
    empty = [np.nan] * k
    return [r[t - k + 1 : t + 1] if t >= k else empty for t in range(len(close))]


def forward(x, layers):
    inputs = []
    for weights, biases in layers[:-1]:
        inputs.append(x)
        x = (x @ weights + biases).clip(min=0)
    inputs.append(x)
    return x @ layers[-1][0] + layers[-1][1], inputs


def q_values(x, layers):
    return forward(x, layers)[0].astype(np.float32)


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    best = [max(np.flatnonzero(p), key=q.__getitem__) for p, q in zip(next_possible, next_online)]
    return np.array([r if end else r + gamma * q[a] for r, end, q, a in zip(rewards, terminated, next_target, best)])


def learn(observations, actions, rewards, next_observations, next_possible, terminated, steps, copy_every, seed):
    rng = np.random.default_rng(seed)
    sizes = (observations.shape[1], 32, 32, next_possible.shape[1])
    layers = [
        [rng.uniform(-1, 1, size=(n, m)) / np.sqrt(n), rng.uniform(-1, 1, size=m) / np.sqrt(n)]
        for n, m in zip(sizes, sizes[1:])
    ]
    means = [[np.zeros_like(array) for array in layer] for layer in layers]
    squares = [[np.zeros_like(array) for array in layer] for layer in layers]
    order = np.arange(0)
    for step in range(steps):
        if step % copy_every == 0:
            old = [[array.copy() for array in layer] for layer in layers]
        if len(order) < 64:
            order = rng.permutation(len(actions))
        batch, order = order[:64], order[64:]
        there = next_observations[batch]
        y = targets(
            rewards[batch], terminated[batch], next_possible[batch], q_values(there, layers), q_values(there, old), 0.9
        )
        values, inputs = forward(observations[batch], layers)
        error = np.zeros_like(values)
        taken = np.arange(64), actions[batch]
        error[taken] = 2 * (values[taken] - y) / 64
        for i in reversed(range(len(layers))):
            gradients = inputs[i].T @ error, error.sum(axis=0)
            error = (error @ layers[i][0].T) * (inputs[i] > 0)
            for j, gradient in enumerate(gradients):
                means[i][j] = 0.9 * means[i][j] + 0.1 * gradient
                squares[i][j] = 0.999 * squares[i][j] + 0.001 * gradient**2
                mean, square = means[i][j] / (1 - 0.9 ** (step + 1)), squares[i][j] / (1 - 0.999 ** (step + 1))
                layers[i][j] = layers[i][j] - 0.002 * mean / (np.sqrt(square) + 1e-8)
    return q_values(observations, layers)


def best_moment(validation, patience):
    def best_up_to(stage):
        return max(range(stage + 1), key=lambda i: validation[i])

    stops = [stage for stage in range(len(validation)) if stage - best_up_to(stage) >= patience]
    stop = min(stops + [len(validation) - 1])
    return stop, best_up_to(stop)
