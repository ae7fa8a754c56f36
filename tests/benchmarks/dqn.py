"""Deep Q-learning: many agents side by side against Stable-Baselines3, a one-file loop, and the original program.

    python tests/benchmarks/dqn.py

All play the lesson's maze in which walls pay nothing, with a network of 16 one-hot inputs, 20 hidden nodes and 4
outputs, and make a gradient step of Adam every step. All but the original program (original_dqn.py), which has neither,
draw batches of 32 from a replay buffer of 10,000 and copy the network to a target network every 100 steps.
"""

import os
from importlib.util import find_spec

import cleanrl_shaped
import numpy as np
import torch
from measure import medians, seconds, show

from course_lib import Maze
from course_lib.dqn import DQNAgent

HAS_SB3, HAS_KERAS = (find_spec(name) is not None for name in ("stable_baselines3", "keras"))
SHARED = {"gamma": 0.95, "learning_rate": 1e-3, "batch_size": 32}
SETTINGS = SHARED | {"epsilon": 0.5, "replay": 10_000, "target_update": 100}
HIDDEN = 20
SHORTEST = 6  # moves from the start of the lesson's maze to its goal
AGENTS, CUDA_AGENTS = (1, 64, 256), (1024, 4096, 16384)
SB3, CLEANRL = "Stable-Baselines3", "CleanRL-shaped loop"
ORIGINAL = f"original program, Keras on {os.environ.get('KERAS_BACKEND', 'torch')}"
# agents, over what, how many times; the original program's text has Keras on TensorFlow
TARGETS = [(1, SB3, 2), (1, CLEANRL, 1), (64, SB3, 75), (64, "original program, Keras on tensorflow", 5000)]


def ours(num_agents, device="cpu"):
    return f"DQNAgent, {num_agents} agent{'s' * (num_agents > 1)}{', GPU' * (device == 'cuda')}"


def lesson():
    """The lesson's maze, where running into a wall pays nothing and ends the episode."""
    return Maze(wall_reward=0.0)


def new_agent(num_agents, device="cpu"):
    return DQNAgent(lesson(), hidden=(HIDDEN,), epsilon_decay=1.0, num_agents=num_agents, device=device, **SETTINGS)


def run_ours(num_agents, device, num_steps):
    """Seconds a step of all agents together; on a GPU, of a tenth of the steps."""
    agent = new_agent(num_agents, device)
    if device == "cuda":  # fewer steps are timed there, so those that only fill the memory would weigh too much
        num_steps //= 10
        agent.train(num_steps=SHARED["batch_size"])

    def work():
        agent.train(num_steps=num_steps)
        if device == "cuda":
            torch.cuda.synchronize()

    return seconds(work) / num_steps


def new_sb3():
    """Stable-Baselines3's DQN with its own loss (Huber) and limit to the gradient, which cannot be had otherwise."""
    from stable_baselines3 import DQN

    return DQN(
        "MlpPolicy", lesson(), **SHARED, policy_kwargs={"net_arch": [HIDDEN]}, device="cpu", seed=0,
        buffer_size=SETTINGS["replay"], learning_starts=SHARED["batch_size"], train_freq=1, gradient_steps=1,
        target_update_interval=SETTINGS["target_update"],
        exploration_initial_eps=SETTINGS["epsilon"], exploration_final_eps=SETTINGS["epsilon"],
    )  # fmt: skip


def run_sb3(num_steps):
    model = new_sb3()
    return seconds(lambda: model.learn(num_steps, log_interval=None)) / num_steps


def train_cleanrl(num_steps):
    return cleanrl_shaped.train(lesson(), num_steps, hidden=HIDDEN, **SETTINGS)


def run_cleanrl(num_steps):
    return seconds(lambda: train_cleanrl(num_steps)) / num_steps


def run_original(num_episodes):
    """Seconds a step, and the action values at the end."""
    import original_dqn

    taken, agent = original_dqn.seconds_a_step(num_episodes)
    return taken, original_dqn.q_values(agent)


def on_threads(number, run):
    """What `run` returns when torch may use so many threads."""
    before = torch.get_num_threads()
    torch.set_num_threads(number)
    try:
        return run()
    finally:
        torch.set_num_threads(before)


def best_threads(run):
    """Whether `run` is faster on 1 thread of torch or on 2."""
    taken = medians({number: lambda number=number: on_threads(number, run) for number in (1, 2)}, 3)
    return min(taken, key=taken.get)


def way_to_goal(q_table):
    """How many best actions lead from the start to the goal; None if they do not lead there."""
    maze = lesson()
    state, _ = maze.reset()
    for step in range(1, len(q_table) + 1):
        state, _, terminated, _, _ = maze.step(int(np.argmax(q_table[state])))
        if terminated:
            return step if state in maze.goals else None
    return None


def q_tables_ours(num_steps, num_agents):
    agent = new_agent(num_agents)
    agent.train(num_steps=num_steps)
    return agent.q_values(np.arange(lesson().grid.size))


def q_table_cleanrl(num_steps):
    learner = train_cleanrl(num_steps)
    return learner.q_network(learner.one_hot).detach().numpy()


def q_table_sb3(num_steps):
    model = new_sb3()
    model.learn(num_steps, log_interval=None)
    states, _ = model.policy.obs_to_tensor(np.arange(lesson().grid.size))
    return model.q_net(states).detach().numpy()


def check_ways(name, q_tables):
    """`ValueError` unless the best actions of every table of action values lead to the goal the shortest way."""
    found = [way_to_goal(q_table) for q_table in q_tables]
    if set(found) != {SHORTEST}:
        raise ValueError(f"the shortest way has {SHORTEST} moves, found by {name}: {found}")


def check_gradient_steps(num_steps):
    """`ValueError` unless from the same weights and batches DQNAgent and the one-file loop make the same, to 1e-5."""
    agent, rng = new_agent(1), np.random.default_rng(0)
    num_states, num_actions = lesson().mdp.next_state.shape[:2]
    learner = cleanrl_shaped.Learner(
        num_states, num_actions, hidden=HIDDEN, learning_rate=SETTINGS["learning_rate"], gamma=SETTINGS["gamma"]
    )
    linears = [module for module in learner.q_network.network if isinstance(module, torch.nn.Linear)]
    for linear, (weights, biases) in zip(linears, agent.layers, strict=True):
        linear.weight.data, linear.bias.data = torch.from_numpy(weights[0].T.copy()), torch.from_numpy(biases[0])
    learner.update_target()
    for _ in range(num_steps):
        states, next_states = rng.integers(num_states, size=(2, SHARED["batch_size"]))
        actions = rng.integers(num_actions, size=SHARED["batch_size"])
        rewards, dones = rng.integers(2, size=(2, SHARED["batch_size"])).astype(np.float32)
        learner.gradient_step(*map(torch.from_numpy, (states, actions, rewards, next_states, dones)))

        batch = agent._inputs.transition(states, actions, next_states)
        batch |= {"reward": torch.from_numpy(rewards), "discount": torch.from_numpy(SETTINGS["gamma"] * (1 - dones))}
        batch = {name: values[None] for name, values in batch.items()}
        with torch.no_grad():
            agent._learn(agent._look(np.zeros(1, int))[0], batch, np.ones(1, bool))
    theirs = [(linear.weight.detach().numpy().T, linear.bias.detach().numpy()) for linear in linears]
    pairs = zip(agent.layers, theirs, strict=True)
    off = max(np.abs(ours[0] - other).max() for layers in pairs for ours, other in zip(*layers, strict=True))
    if not off <= 1e-5:
        raise ValueError(f"after {num_steps} gradient steps the weights differ by {off:.1e}")


def check_original(num_episodes):
    """`ValueError` unless the original program runs and its action values are finite; it learns too slowly for more."""
    q_table = run_original(num_episodes)[1]
    if not np.isfinite(q_table).all():
        raise ValueError(f"the original program's action values are not finite: {q_table}")


def peers(num_steps, original_episodes):
    """{name: function that returns the seconds of a step} of the programs that are installed here."""
    runs = {CLEANRL: lambda: run_cleanrl(num_steps)}
    if HAS_SB3:
        runs[SB3] = lambda: run_sb3(num_steps)
    if HAS_KERAS:
        runs[ORIGINAL] = lambda: run_original(original_episodes)[0]
    return runs


def main(num_steps=1000, original_episodes=10, trial_steps=200, check_steps=4000, check_agents=64, repeats=9):
    check_gradient_steps(100)
    check_ways(ours(check_agents), q_tables_ours(check_steps, check_agents))
    check_ways(CLEANRL, [on_threads(1, lambda: q_table_cleanrl(check_steps))])
    if HAS_SB3:
        check_ways(SB3, [on_threads(1, lambda: q_table_sb3(check_steps))])
    if HAS_KERAS:
        check_original(num_episodes=1)
    threads = {name: best_threads(run) for name, run in peers(trial_steps, original_episodes).items()}
    runs = {
        name: lambda name=name, run=run: on_threads(threads[name], run)
        for name, run in peers(num_steps, original_episodes).items()
    }
    sizes = [(number, "cpu") for number in AGENTS]
    if torch.cuda.is_available():
        sizes += [(number, "cuda") for number in CUDA_AGENTS]
    for size in sizes:
        runs[ours(*size)] = lambda size=size: run_ours(*size, num_steps)
    taken = medians(runs, repeats)

    num_agents = {ours(*size): size[0] for size in sizes}
    rate = {name: num_agents.get(name, 1) / taken[name] for name in runs}
    rows = [("program", "torch's threads", "microseconds a step", "agent-steps a second")]
    rows += [(name, f"{threads.get(name, 1)}", f"{1e6 * taken[name]:,.0f}", f"{rate[name]:,.0f}") for name in runs]
    steps = f"{num_steps:,} steps (GPU: {num_steps // 10:,})"
    show(f"Deep Q-learning in the lesson's maze, {steps}, medians of {repeats} runs in turn", rows)

    rows = [("agent-steps a second of", "over those of", "times", "target")]
    targets = {(ours(number), other): f"{times:,} or more" for number, other, times in TARGETS}
    for name in num_agents:
        for other in threads:
            rows.append((name, other, f"{rate[name] / rate[other]:,.1f}", targets.get((name, other), "")))
    show("How many times as fast", rows)
    if not HAS_SB3:
        print('\nStable-Baselines3 is not installed: pip install -e ".[peers]"')
    if not HAS_KERAS:
        print('\nKeras, which the original program needs, is not installed: pip install -e ".[benchmarks]"')
    if not torch.cuda.is_available():
        print("\nno GPU that torch can use: no rows of more agents on one")


if __name__ == "__main__":
    main()
