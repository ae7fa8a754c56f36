"""The market: one side of a share against gym-anytrading's environment, many traders at once, and the compiled walk.

    python tests/benchmarks/market.py

All act at random along the same closes and begin again at their end. `SideEnv` shows states of the last 8 moves
(Discrete) or the moves themselves (Box), and its whole `info`; gym-anytrading the last 8 prices and their changes. Both
are given actions drawn beforehand, for which the targets are meant, and then draw each by `action_space.sample()`. The
compiled walk is `coin_tossers`, which draws its actions itself. `QAgent.train` at epsilon 1 also learns from each step.

What differs: gym-anytrading pays the change of the price, in money and without a fee, when a position is closed and
nothing before; fees are in `total_profit` alone. An action is carried out at the next close, and "short" earns nothing.
So without fees its `total_profit` is what `SideEnv` makes of 1 long, filled at the next close: that is checked before
time is taken. Then come 50 passes over 3,000 bars, and 20 networks of one side, or of two in a thread each.
"""

import threading
from importlib.util import find_spec

import numpy as np
from dqn import on_threads
from measure import medians, seconds, show

from course_lib import QAgent
from course_lib.dqn import DQNAgent
from course_lib.market import (
    Part,
    ReturnsEncoder,
    RubberBandMarket,
    SideEnv,
    SideVectorEnv,
    WindowEncoder,
    account,
    coin_tossers,
    real_prices,
)

HAS_ANYTRADING, HAS_SB3 = (find_spec(name) is not None for name in ("gym_anytrading", "stable_baselines3"))
WINDOW, BARS, LANES = 8, 3000, (1, 64, 1024)
DISCRETE, BOX, ANYTRADING = "SideEnv, Discrete", "SideEnv, Box", "gym-anytrading"
SAMPLING = "{}, action_space.sample()"
COIN_TOSSERS = "coin_tossers, the compiled walk"
WALKS = {"QAgent.train, epsilon 1, masked": True, "QAgent.train, epsilon 1": False}
TARGETS = {DISCRETE: "above 1", BOX: "above 1", COIN_TOSSERS: "500 or more"}
LEARNING = {"gamma": 0.95, "alpha": 1.0, "alpha_power": 0.6, "epsilon": 1.0, "mask_actions": True}
EPISODE = 250  # bars, when learning
COMPILED, PLAIN, SB3 = "QAgent, compiled", "QAgent, stepping SideEnv", "Stable-Baselines3's DQN"
NETWORKS, BATCHES, NETWORK = 20, (128, 256), {"gamma": 0.95, "learning_rate": 1e-3}


class Stepped(SideEnv):
    """A `SideEnv` that agents have to step: being a subclass, it is not asked for its tables."""


def histories():
    """{name: prices} of a real share and of a made-up one."""
    return {"MSFT": real_prices("MSFT"), "rubber band": RubberBandMarket().prices(BARS, seed=0)}


def side_env(prices, encoder=None, kind=SideEnv, **settings):
    return kind(prices, (encoder or WindowEncoder(WINDOW)).fit(prices["close"]), side=1, **settings)


def anytrading_env(prices):
    from gym_anytrading.envs import StocksEnv

    return StocksEnv(prices.rename(columns=str.capitalize), WINDOW, (WINDOW, len(prices)))


def drawn(num_actions, num_steps):
    return np.random.default_rng(0).integers(num_actions, size=num_steps)


def run_stepped(env, actions):
    """Seconds a step; a number of actions, instead of a list of them, has each drawn by the action space."""
    env.reset(seed=0)
    env.action_space.seed(0)
    num_steps = actions if isinstance(actions, int) else len(actions)
    if isinstance(actions, int):
        actions = (env.action_space.sample() for _ in range(num_steps))

    def work():
        for action in actions:
            observation, reward, terminated, truncated, info = env.step(action)
            if terminated or truncated:
                env.reset()

    return seconds(work) / num_steps


def run_vector(env, num_steps):
    """Seconds a step of one lane."""
    actions = drawn(3, (-(-num_steps // env.num_envs), env.num_envs))
    env.reset(seed=0)

    def work():
        for row in actions:
            env.step(row)

    return seconds(work) / actions.size


def walker(env, mask_actions):
    return QAgent(env, epsilon=1.0, epsilon_decay=1.0, mask_actions=mask_actions)


def run_coin_tossers(env, num_steps):
    number = max(1, num_steps // env.tape.length)
    coin_tossers(env, 1)  # compiled, or read from where it is kept
    return seconds(lambda: coin_tossers(env, number)) / (number * env.tape.length)


def run_walk(env, mask_actions, num_steps):
    agent = walker(env, mask_actions)
    taken = seconds(lambda: agent.train(max(1, num_steps // env.tape.length), max_steps=num_steps))
    return taken / agent.history.episode_length.sum()


def learner(kind, prices, passes):
    """An agent as the course trains it, and for how many episodes."""
    env = side_env(prices, kind=kind, episode_length=EPISODE)
    num_episodes = passes * env.tape.bars // EPISODE
    return QAgent(env, epsilon_decay=0.1 ** (1 / num_episodes), **LEARNING), num_episodes


def run_learner(kind, prices, passes):
    """Seconds a step."""
    agent, num_episodes = learner(kind, prices, passes)
    return seconds(lambda: agent.train(num_episodes)) / (num_episodes * EPISODE)


def run_sb3(prices, num_steps, batch_size):
    from stable_baselines3 import DQN

    model = DQN(
        "MlpPolicy", side_env(prices, ReturnsEncoder(WINDOW), episode_length=EPISODE), **NETWORK,
        policy_kwargs={"net_arch": [32, 32]}, device="cpu", seed=0, batch_size=batch_size, buffer_size=20_000,
        learning_starts=batch_size, train_freq=1, gradient_steps=1, target_update_interval=50,
    )  # fmt: skip
    model.learn(2 * batch_size, log_interval=None)
    return seconds(lambda: model.learn(num_steps, log_interval=None, reset_num_timesteps=False)) / num_steps


def networks(prices, side, batch_size):
    """20 networks of one side, which remember enough to learn from."""
    encoder = ReturnsEncoder(WINDOW).fit(prices["close"])
    env = SideEnv(prices, encoder, side=side, episode_length=EPISODE, reward_unit=encoder.sigma)
    agent = DQNAgent(
        env, num_agents=NETWORKS, hidden=(32, 32), replay=20_000, batch_size=batch_size, target_update=50, double=True,
        mask_actions=True, **NETWORK,
    )  # fmt: skip
    agent.train(num_steps=batch_size)
    return agent


def run_networks(prices, sides, batch_size, num_steps):
    """Seconds a step of 20 networks a side, each side in a thread of its own."""
    agents = [networks(prices, side, batch_size) for side in sides]
    threads = [threading.Thread(target=agent.train, kwargs={"num_steps": num_steps}) for agent in agents]

    def work():
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    return seconds(work) / num_steps


def check_walk(prices, mask_actions, num_episodes):
    """`ValueError` unless the compiled walk and stepping SideEnv come to the same, to the last bit; the steps."""
    agents = [walker(side_env(prices, kind=kind), mask_actions) for kind in (SideEnv, Stepped)]
    for agent in agents:
        agent.train(num_episodes, max_steps=len(prices))
    compiled, plain = (
        (agent.q_table, agent.visits, agent.history.episode_return, agent.history.episode_length, agent.rng.random())
        for agent in agents
    )
    if not all(np.array_equal(a, b) for a, b in zip(compiled, plain, strict=True)):
        raise ValueError("the compiled walk and stepping SideEnv came to different results")
    return int(agents[0].history.episode_length.sum())


def check_coin_tossers(prices, number):
    """`ValueError` unless the compiled coins pay what SideEnv pays when stepped, to the last bit; the steps."""
    env, rng = side_env(prices), np.random.default_rng(0)
    for made in coin_tossers(env, number, seed=0):
        rng.random()  # where to begin: there is one bar
        _, info = env.reset(seed=0)
        for _ in range(env.tape.length):
            coin = int(rng.random() * 2)
            _, _, _, _, info = env.step(np.flatnonzero(info["action_mask"])[coin])
        if info["log_equity"] != made:
            raise ValueError("the compiled coins and stepping SideEnv came to different results")
    return number * env.tape.length


def check_account(prices, num_episodes):
    """`ValueError` unless SideEnv pays what `account` says of the positions it was in, to the last bit; the steps."""
    for encoder in (WindowEncoder(WINDOW), ReturnsEncoder(WINDOW)):
        env, part = side_env(prices, encoder), Part("training", prices, WINDOW)
        actions = drawn(3, (num_episodes, len(part) - 1))
        for episode in actions:
            env.reset(seed=0)
            steps = [env.step(action) for action in episode.tolist()]
            rewards, infos = [step[1] for step in steps], [step[4] for step in steps]
            ours = account(part, np.array([info["position"] for info in infos] + [0]))
            same = np.array_equal(rewards, ours.rewards) and steps[-1][3]
            same = same and [info["log_equity"] for info in infos] == ours.log_equity[1:].tolist()
            if not same or infos[-1]["trades"] != ours.trades:
                raise ValueError("SideEnv and account came to different results")
    return actions.size


def check_vector(prices, num_lanes, num_steps):
    """`ValueError` unless every lane of SideVectorEnv is the SideEnv of its seed, step by step; how many ended."""
    env = side_env(prices, kind=SideVectorEnv, num_envs=num_lanes, episode_length=num_steps // 4)
    alone = [side_env(prices, episode_length=num_steps // 4) for _ in range(num_lanes)]
    env.reset(seed=0)
    for seed, lane in enumerate(alone):
        lane.reset(seed=seed)
    over, ended = [False] * num_lanes, 0
    for actions in drawn(3, (num_steps, num_lanes)):
        together = env.step(actions)
        for i, lane in enumerate(alone):
            if over[i]:
                observation, info = lane.reset()
                step = (observation, 0.0, False, False, info)
            else:
                step = lane.step(int(actions[i]))
            over[i] = step[2] or step[3]
            ended += over[i]
            infos = {name: values[i] for name, values in together[4].items() if not name.startswith("_")}
            same = all(np.array_equal(ours[i], theirs) for ours, theirs in zip(together[:4], step[:4], strict=True))
            if not (same and all(np.array_equal(infos[name], value) for name, value in step[4].items())):
                raise ValueError(f"lane {i} and SideEnv came to different results")
    return int(ended)


def check_anytrading(prices, num_episodes):
    """`ValueError` unless without fees gym-anytrading ends with the money that SideEnv ends with, to 0.1 %; the money.

    From the same bar, with the same orders: its buying is opening, its selling closing, where there is what to close.
    """
    theirs, ours = anytrading_env(prices), side_env(prices, cost=0.0, fill="next_close")
    theirs.trade_fee_bid_percent = theirs.trade_fee_ask_percent = 0.0
    money = []
    for episode in drawn(2, (num_episodes, ours.tape.length)).tolist():
        theirs.reset(seed=0)
        _, info = ours.reset(seed=0)
        for buys in episode:
            _, _, _, ended, profit = theirs.step(buys)
            _, _, _, truncated, info = ours.step((1 if buys else 2) if buys != info["position"] else 0)
        money.append((float(profit["total_profit"]), float(np.exp(info["log_equity"]))))
        if not (ended and truncated and np.isclose(*money[-1], rtol=1e-3, atol=0.0)):
            raise ValueError(f"gym-anytrading made {money[-1][0]:.5f} of 1, SideEnv {money[-1][1]:.5f}")
    return money


def check_learners(prices, passes):
    """`ValueError` unless the agent learns the same table compiled and stepping, to the last bit; its visits."""
    tables = []
    for kind in (SideEnv, Stepped):
        agent, num_episodes = learner(kind, prices, passes)
        agent.train(num_episodes)
        tables.append(agent.q_table)
    if not np.array_equal(*tables):
        raise ValueError("the compiled learner and the one that steps learned different tables")
    return int(agent.visits.sum())


def race_steps(name, prices, num_steps, walk_steps, repeats):
    """A table of random-action steps a second along these prices."""
    stepped = {DISCRETE: side_env(prices), BOX: side_env(prices, ReturnsEncoder(WINDOW))}
    if HAS_ANYTRADING:
        stepped[ANYTRADING] = anytrading_env(prices)
    runs = {}
    for program, env in stepped.items():
        actions = drawn(env.action_space.n, num_steps).tolist()
        runs[program] = lambda env=env, actions=actions: run_stepped(env, actions)
        runs[SAMPLING.format(program)] = lambda env=env: run_stepped(env, num_steps)
    for lanes in LANES:
        vector = side_env(prices, kind=SideVectorEnv, num_envs=lanes)
        runs[f"SideVectorEnv({lanes})"] = lambda vector=vector: run_vector(vector, num_steps)
    runs[COIN_TOSSERS] = lambda: run_coin_tossers(side_env(prices), walk_steps)
    for walk, masked in WALKS.items():
        runs[walk] = lambda masked=masked: run_walk(side_env(prices), masked, walk_steps)
    taken = medians(runs, repeats)
    peers = [peer for peer in (ANYTRADING, SAMPLING.format(ANYTRADING)) if peer in runs]
    rows = [("program", "ns a step", "steps a second", *(f"times {peer}" for peer in peers), "target")]
    for run in runs:
        times = [f"{taken[peer] / taken[run]:,.1f}" for peer in peers]
        rows.append((run, f"{1e9 * taken[run]:,.1f}", f"{1 / taken[run]:,.0f}", *times, TARGETS.get(run, "")))
    steps = f"{num_steps:,} random steps, compiled {walk_steps:,}"
    show(f"{name}, {len(prices):,} bars, {steps}, medians of {repeats} runs in turn", rows)


def race_learners(prices, passes, sb3_steps, repeats):
    """A table of how long a Q-table takes that is trained as the course trains it."""
    runs = {
        COMPILED: lambda: run_learner(SideEnv, prices, passes),
        PLAIN: lambda: run_learner(Stepped, prices, max(1, passes // 10)),
    }
    if HAS_SB3:
        runs |= {
            f"{SB3}, batches of {batch}": lambda batch=batch: on_threads(1, lambda: run_sb3(prices, sb3_steps, batch))
            for batch in BATCHES
        }
    taken, steps = medians(runs, repeats), passes * BARS
    rows = [("program", "steps a second", f"seconds for {steps:,}")]
    rows += [(name, f"{1 / taken[name]:,.0f}", f"{steps * taken[name]:,.3f}") for name in runs]
    show(f"{passes} passes over {BARS:,} bars, one side, medians of {repeats} runs in turn", rows)


def race_networks(prices, num_steps, repeats):
    """A table of how quickly 20 networks learn, on one side and on two."""
    sizes = [(batch, sides) for batch in BATCHES for sides in ((1,), (1, -1))]
    runs = {size: lambda size=size: run_networks(prices, size[1], size[0], num_steps) for size in sizes}
    taken = medians(runs, repeats)
    rows = [("batch", "sides", "milliseconds a step", "steps a second", "network-steps a second")]
    for batch, sides in sizes:
        step = taken[batch, sides]
        network_steps = f"{NETWORKS * len(sides) / step:,.0f}"
        rows.append((f"{batch}", f"{len(sides)}", f"{1e3 * step:.2f}", f"{1 / step:,.0f}", network_steps))
    show(f"DQNAgent, {NETWORKS} networks a side, {num_steps:,} steps, medians of {repeats} runs in turn", rows)


def main(
    num_steps=50_000, walk_steps=10_000_000, repeats=15, passes=50, sb3_steps=300, network_steps=200, long_repeats=5
):
    for name, prices in histories().items():
        check_account(prices, 1)
        check_vector(prices, 8, 200)
        check_coin_tossers(prices, 2)
        for masked in WALKS.values():
            check_walk(prices, masked, 2)
        if HAS_ANYTRADING:
            check_anytrading(prices, 2)
        race_steps(name, prices, num_steps, walk_steps, repeats)
    prices = RubberBandMarket().prices(BARS + WINDOW, seed=0)
    check_learners(prices, 1)
    race_learners(prices, passes, sb3_steps, long_repeats)
    race_networks(prices, network_steps, long_repeats)
    if not HAS_ANYTRADING:
        print('\ngym-anytrading is not installed: pip install -e ".[benchmarks]"')
    if not HAS_SB3:
        print('\nStable-Baselines3 is not installed: pip install -e ".[peers]"')


if __name__ == "__main__":
    main()
