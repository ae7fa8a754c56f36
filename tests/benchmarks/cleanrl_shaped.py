"""Deep Q-learning as it is written in one file: the shape of CleanRL's dqn.py (Huang et al., 2022), written anew.

One environment, one network of `nn.Linear`, gradients by autograd, `torch.optim.Adam`, a replay buffer of arrays. What
is different favours this program: nothing is logged, the environment is stepped as it is instead of in a vector of one,
and the states of the batch become one-hot rows by picking from a table.
"""

import random

import numpy as np
import torch
from torch import nn, optim


class QNetwork(nn.Module):
    def __init__(self, num_states, num_hidden, num_actions):
        super().__init__()
        self.network = nn.Sequential(nn.Linear(num_states, num_hidden), nn.ReLU(), nn.Linear(num_hidden, num_actions))

    def forward(self, x):
        return self.network(x)


class ReplayBuffer:
    """The last `capacity` transitions: state, action, reward, next state, whether the step terminated the episode."""

    def __init__(self, capacity):
        self.capacity, self.count = capacity, 0
        self.states, self.actions, self.next_states = np.zeros((3, capacity), np.int64)
        self.rewards, self.dones = np.zeros((2, capacity), np.float32)

    def add(self, state, action, reward, next_state, done):
        i = self.count % self.capacity
        self.states[i], self.actions[i], self.rewards[i] = state, action, reward
        self.next_states[i], self.dones[i] = next_state, done
        self.count += 1

    def sample(self, batch_size):
        i = np.random.randint(min(self.count, self.capacity), size=batch_size)  # noqa: NPY002
        columns = self.states[i], self.actions[i], self.rewards[i], self.next_states[i], self.dones[i]
        return [torch.from_numpy(column) for column in columns]


class Learner:
    """Network, target network and optimizer, and what the training loop does with them."""

    def __init__(self, num_states, num_actions, *, hidden, learning_rate, gamma):
        self.one_hot, self.gamma = torch.eye(num_states), gamma
        self.q_network = QNetwork(num_states, hidden, num_actions)
        self.target_network = QNetwork(num_states, hidden, num_actions)
        self.optimizer = optim.Adam(self.q_network.parameters(), lr=learning_rate)
        self.update_target()

    def greedy(self, state):
        with torch.no_grad():
            return int(self.q_network(self.one_hot[state : state + 1]).argmax(dim=1))

    def gradient_step(self, states, actions, rewards, next_states, dones):
        with torch.no_grad():
            best_next = self.target_network(self.one_hot[next_states]).amax(dim=1)
            td_target = rewards + self.gamma * best_next * (1 - dones)
        q = self.q_network(self.one_hot[states]).gather(1, actions[:, None]).squeeze(1)
        loss = nn.functional.mse_loss(q, td_target)
        self.optimizer.zero_grad()
        loss.backward()
        self.optimizer.step()

    def update_target(self):
        self.target_network.load_state_dict(self.q_network.state_dict())


def train(env, num_steps, *, hidden, learning_rate, gamma, epsilon, replay, batch_size, target_update, seed=0):
    """The `Learner` after so many steps in `env`, from the `batch_size`-th on with a gradient step each."""
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    torch.manual_seed(seed)
    num_actions = int(env.action_space.n)
    learner = Learner(
        int(env.observation_space.n), num_actions, hidden=hidden, learning_rate=learning_rate, gamma=gamma
    )
    buffer = ReplayBuffer(replay)
    state, _ = env.reset(seed=seed)
    for step in range(1, num_steps + 1):
        action = random.randrange(num_actions) if random.random() < epsilon else learner.greedy(state)
        next_state, reward, terminated, truncated, _ = env.step(action)
        buffer.add(state, action, reward, next_state, terminated)
        state = env.reset()[0] if terminated or truncated else next_state
        if step >= batch_size:
            learner.gradient_step(*buffer.sample(batch_size))
        if step % target_update == 0:
            learner.update_target()
    return learner
