"""Learn in an unknown world, with a table: Q-learning (Watkins, 1989; Sutton & Barto, 2nd ed., section 6.5)."""

import gymnasium
import numpy as np

from course_lib.choice import checked_mask, epsilon_greedy, possible_actions, random_argmax
from course_lib.files import generator_in, load_arrays, save_arrays
from course_lib.generators import OneForMany
from course_lib.history import History, Rollout
from course_lib.table_world import TableWorld
from course_lib.validate import fraction, number, whole_number

_STEPS_BETWEEN_LOOKS = 1_000_000  # compiled steps before Python gets a look in, to move a bar or to be interrupted
_RATES_KEPT = 2**20  # learning rates that a compiled loop works out once, those of so many first updates


class QAgent:
    """A table of action values and the agent that fills it by acting epsilon-greedily.

    q_table[s, a] += step * (r + gamma * max(q_table[s']) - q_table[s, a]), without the max after a terminated step.

    env            any Gymnasium environment with Discrete observations and actions
    gamma          discount, in [0, 1]
    alpha          learning rate, in (0, 1]
    epsilon        how often an action is random, in [0, 1]; multiplied by epsilon_decay after every episode
    mask_actions   leave out the actions that `info["action_mask"]` rules out, when acting and in the max above
    alpha_power    0: the step is alpha; p > 0: it is alpha / n^p at the n-th update of a (state, action). The table
                   converges to Q* with probability 1 for 0.5 < p <= 1 (Robbins & Monro, 1951)
    seed           of everything random: the agent's generator, which also draws the seed of `env`

    q_table float64[S, A] starts at zero, visits int64[S, A] counts updates. `history` is the latest `train`'s.
    Equal values are chosen among at random. Where the world is known to be a table (Maze, FrozenLake, CliffWalking,
    Taxi, or a world that says so itself) the same loop runs compiled, with the same result to the last bit.
    """

    def __init__(
        self, env, *, gamma=0.9, alpha=0.1, epsilon=0.1, epsilon_decay=1.0, alpha_power=0.0, mask_actions=False, seed=0
    ):
        shape = _table_shape(env)
        self.gamma = fraction("gamma", gamma)
        self.alpha = fraction("alpha", alpha, above_zero=True)
        self.epsilon = fraction("epsilon", epsilon)
        self.epsilon_decay = fraction("epsilon_decay", epsilon_decay)
        self.alpha_power = number("alpha_power", alpha_power)
        if self.alpha_power < 0:
            raise ValueError(f"alpha_power must not be negative, got {alpha_power!r}")
        self.mask_actions = bool(mask_actions)
        self.seed = whole_number("seed", seed)
        self.env = env
        self.rng = np.random.default_rng(self.seed)
        self.q_table, self.visits = np.zeros(shape), np.zeros(shape, np.int64)
        self.history = _Records(0).history()
        env.reset(seed=int(self.rng.integers(2**31)))

    def act(self, state, possible=None):
        """An action for `state`: random with probability epsilon, else a best one. `ValueError` if out of range.

        possible   the state's action mask, [A]: only these. An agent with mask_actions has to be told, or raises
                   `ValueError`; so does a mask of another shape, or without any possible action.
        """
        row = whole_number("state", state, at_least=self._first_state, below=self._first_state + len(self.q_table))
        if possible is not None:
            possible = checked_mask(possible, self.q_table.shape[1:], "possible")
        elif self.mask_actions:
            raise ValueError('with mask_actions, act needs to know what is possible: act(state, info["action_mask"])')
        values = self.q_table[row - self._first_state]
        return epsilon_greedy(values, self.epsilon, self.rng, possible) + self._first_action

    def train(self, num_episodes=1000, *, max_steps=1000, progress=False):
        """Play `num_episodes` more episodes of at most `max_steps` steps, learning from each; returns their `History`.

        Interrupted, the agent keeps what it has learned, and `history` the episodes it has finished.
        `progress=True` shows a bar.
        """
        records = _Records(whole_number("num_episodes", num_episodes))
        max_steps = whole_number("max_steps", max_steps, at_least=1)
        self._check_tables()
        play = self._way_to_play(max_steps)
        bar = _bar(num_episodes) if progress else None
        try:
            while records.done < num_episodes:
                play(records)
                if bar is not None:
                    bar.update(records.done - bar.n)
        finally:
            self.history = records.history()
            if bar is not None:
                bar.close()
        return self.history

    def test(self, max_steps=1000):
        """One greedy walk of at most `max_steps` steps, learning nothing; returns the `Rollout`."""
        max_steps = whole_number("max_steps", max_steps, at_least=1)
        self._check_tables()
        state, info = self.env.reset()
        states, actions, rewards = [int(state)], [], []
        terminated = truncated = False
        while not (terminated or truncated) and len(actions) < max_steps:
            row = self.q_table[states[-1] - self._first_state]
            actions.append(random_argmax(row, self.rng, self._possible(info)) + self._first_action)
            state, reward, terminated, truncated, info = self.env.step(actions[-1])
            states.append(int(state))
            rewards.append(float(reward))
        return Rollout(np.array(states), np.array(actions), np.array(rewards), bool(terminated), not terminated)

    def save(self, path):
        """Write the agent to `path`: table, settings and the state of its generators (safetensors, no pickle)."""
        settings = {name: getattr(self, name) for name in _SETTINGS}
        generators = {
            "rng": self.rng.bit_generator.state,
            "env_rng": self.env.unwrapped.np_random.bit_generator.state,
        }
        arrays = {"q_table": self.q_table, "visits": self.visits}
        save_arrays(path, arrays, {"agent": settings, **generators}, kind="QAgent")

    @classmethod
    def load(cls, path, env):
        """The agent saved in `path`, at work in `env`: training goes on as if it had never stopped.

        `ValueError` for a damaged or foreign file, and for an `env` with other numbers of states or actions.
        """
        arrays, settings = load_arrays(path, kind="QAgent")
        shape = _table_shape(env)
        try:
            q_table, visits = arrays["q_table"].astype(float), arrays["visits"].astype(np.int64)
            rng, env_rng = generator_in(settings["rng"]), generator_in(settings["env_rng"])
            saved = {"mask_actions": False} | settings["agent"]  # files from before there were masks
            agent_settings = {name: saved[name] for name in _SETTINGS}
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"{path} is not a saved QAgent: missing or of another form is {error!r}") from None
        if visits.shape != q_table.shape or not np.isfinite(q_table).all():
            raise ValueError(f"{path} is not a saved QAgent: its table holds NaN, or its visits have another shape")
        if q_table.shape != shape:
            raise ValueError(f"{path} holds a table of shape {q_table.shape}, this environment needs {shape}")
        agent = cls(env, **agent_settings)
        agent.q_table, agent.visits, agent.rng = q_table, visits, rng
        env.unwrapped.np_random.bit_generator.state = env_rng.bit_generator.state
        return agent

    def _check_tables(self):
        """`q_table`, `visits` and `env` may have been replaced: the compiled loop needs them to fit together."""
        shape = _table_shape(self.env)
        for name, dtype in (("q_table", float), ("visits", np.int64)):
            if np.shape(getattr(self, name)) != shape:
                raise ValueError(f"{name} must have shape {shape} for this env, got {np.shape(getattr(self, name))}")
            setattr(self, name, np.ascontiguousarray(getattr(self, name), dtype=dtype))

    @property
    def _first_state(self):
        return int(self.env.observation_space.start)

    @property
    def _first_action(self):
        return int(self.env.action_space.start)

    def _possible(self, info, terminated=False):
        return possible_actions(info, self.q_table.shape[1], terminated=terminated) if self.mask_actions else None

    def _way_to_play(self, max_steps):
        """A function that plays on, for an episode or many steps, and writes what happened into `_Records`."""
        world = TableWorld.of(self.env)
        if world is None or (self.mask_actions and world.possible is None):  # no mask that is known beforehand
            return lambda records: self._play_in_python(records, max_steps)
        if world.time_limit is not None:
            max_steps = min(max_steps, world.time_limit)
        kernel = _by_chance(world, self) if world.starts is None else _along(world, self)
        return lambda records: _play_compiled(kernel, self, records, max_steps)

    def _play_in_python(self, records, max_steps):
        """One episode, step by step through the environment: the loop of lesson 3, for any Discrete environment."""
        observation, info = self.env.reset()
        state, episode_return, terminated, truncated = int(observation) - self._first_state, 0.0, False, False
        possible = self._possible(info)
        for step in range(1, max_steps + 1):
            action = epsilon_greedy(self.q_table[state], self.epsilon, self.rng, possible)
            observation, reward, terminated, truncated, info = self.env.step(action + self._first_action)
            next_state, possible = int(observation) - self._first_state, self._possible(info, terminated)
            self._learn(state, action, float(reward), next_state, terminated, possible)
            episode_return += float(reward)
            state = next_state
            if terminated or truncated:
                break
        records.add(episode_return, step, terminated)
        self.epsilon *= self.epsilon_decay

    def _learn(self, state, action, reward, next_state, terminated, next_possible=None):
        """One update of the table (Sutton & Barto, 2nd ed., eq. 6.8)."""
        self.visits[state, action] += 1
        alpha = self.alpha
        if self.alpha_power:
            alpha = self.alpha / float(self.visits[state, action]) ** self.alpha_power
        following = self.q_table[next_state] if next_possible is None else self.q_table[next_state][next_possible]
        target = reward if terminated else reward + self.gamma * following.max()
        self.q_table[state, action] += alpha * (target - self.q_table[state, action])


def train_side_by_side(env, seeds, num_episodes=1000, *, max_steps=1000, **settings):
    """The tables, float64[E, S, A], and the `History`, [E, N], of `QAgent(env, seed=seed, …).train()` for E seeds.

    The same to the last bit. Where the world is one of chances, such as a `Maze`, all learn in one compiled call, which
    leaves the interpreter to other threads. settings: of `QAgent`. `ValueError` as for it, and without any seed.
    """
    if not (seeds := [whole_number("seed", seed) for seed in seeds]):
        raise ValueError("seeds must be at least one, got none")
    num_episodes, max_steps = (
        whole_number("num_episodes", num_episodes),
        whole_number("max_steps", max_steps, at_least=1),
    )
    agent, world = QAgent(env, seed=seeds[0], **settings), TableWorld.of(env)
    tables, records = np.zeros((len(seeds), *agent.q_table.shape)), _Records((len(seeds), num_episodes))
    if world is None or world.starts is not None or agent.mask_actions:
        for i, seed in enumerate(seeds):
            agent = QAgent(env, seed=seed, **settings)
            history, tables[i] = agent.train(num_episodes, max_steps=max_steps), agent.q_table
            records.returns[i], records.lengths[i] = history.episode_return, history.episode_length
            records.terminated[i] = history.terminated
    else:
        from course_lib import kernels

        drawn, world_drawn = OneForMany(len(seeds)), OneForMany(len(seeds))
        for i, seed in enumerate(seeds):
            rng = np.random.default_rng(seed)
            env.reset(seed=int(rng.integers(2**31)))
            drawn.keep(i, rng)
            world_drawn.keep(i, env.unwrapped.np_random)
        mdp, max_steps = world.mdp, min(max_steps, world.time_limit or max_steps)
        kernels.q_learning_side_by_side(
            tables, np.zeros(tables.shape, np.int64), (mdp.next_state, mdp.probability, mdp.reward, mdp.terminal),
            world.start, world.draw_always, drawn.parts, world_drawn.parts, agent.gamma, agent.alpha,
            agent.alpha_power or None, agent.epsilon, agent.epsilon_decay, max_steps,
            records.returns, records.lengths, records.terminated,
        )  # fmt: skip
    return tables, History(records.returns, records.lengths, records.terminated, ~records.terminated)


_SETTINGS = ("gamma", "alpha", "epsilon", "epsilon_decay", "alpha_power", "mask_actions", "seed")


def _table_shape(env):
    for name in ("observation_space", "action_space"):
        space = getattr(env, name, None)
        if not isinstance(space, gymnasium.spaces.Discrete):
            raise ValueError(f"QAgent needs an environment with a Discrete {name}, got {space}")
    return int(env.observation_space.n), int(env.action_space.n)


class _Records:
    """Room for the episodes of one `train`, or of several side by side, filled as they end."""

    def __init__(self, shape):
        self.returns, self.lengths = np.zeros(shape), np.zeros(shape, np.int64)
        self.terminated = np.zeros(shape, np.bool_)
        self.carry = np.zeros(4)  # what the compiled loop goes on from: episode, step in it, state, return so far

    @property
    def done(self):
        return int(self.carry[0])

    def add(self, episode_return, length, terminated):
        i = self.done
        self.returns[i], self.lengths[i], self.terminated[i] = episode_return, length, terminated
        self.carry[0] += 1

    def history(self):
        """The episodes that have ended; views, since nobody writes here any more."""
        terminated = self.terminated[: self.done]
        return History(self.returns[: self.done], self.lengths[: self.done], terminated, ~terminated)


def _play_compiled(kernel, agent, records, max_steps):
    """About a million steps; a mid-episode stop is carried in `records`."""
    done = records.done
    try:
        agent.epsilon = kernel(
            agent.epsilon, agent.epsilon_decay, max_steps, _STEPS_BETWEEN_LOOKS,
            records.carry, records.returns, records.lengths, records.terminated,
        )  # fmt: skip
    except KeyboardInterrupt:  # it is heard when the kernel is through, and what it returned is lost
        for _ in range(records.done - done):
            agent.epsilon *= agent.epsilon_decay
        raise


def _by_chance(world, agent):
    """The compiled loop for worlds whose states are what is seen, ready but for how long to play."""
    from course_lib import kernels

    mdp, world_rng = world.mdp, world.env.unwrapped.np_random
    return lambda *how_long: kernels.q_learning(
        agent.q_table, agent.visits, (mdp.next_state, mdp.probability, mdp.reward, mdp.terminal),
        world.start, world.draw_always, agent.rng, world_rng,
        agent.gamma, agent.alpha, agent.alpha_power or None, *how_long,
    )  # fmt: skip


def _along(world, agent):
    """The compiled loop for worlds in which only the start is drawn, ready but for how long to play.

    It knows a state by its moves: those for the possible actions, in their order, in a row of A places.
    """
    from course_lib import kernels

    mdp, num_actions = world.mdp, world.mdp.num_actions
    seen = np.arange(mdp.num_states) if world.observed is None else world.observed - agent._first_state
    possible = world.possible if agent.mask_actions else np.ones((mdp.num_states, num_actions), bool)
    actions = np.argsort(~possible, axis=1, kind="stable")
    counts = possible.sum(axis=1)
    next_state, reward, terminal = (
        np.take_along_axis(array[:, :, 0], actions, axis=1) for array in (mdp.next_state, mdp.reward, mdp.terminal)
    )
    moves = (
        (seen[:, None] * num_actions + actions).astype(np.uint32).reshape(-1),
        (next_state * np.int64(num_actions)).astype(np.uint32).reshape(-1),
        np.where(terminal, 0, counts[next_state]).astype(np.uint32).reshape(-1),
        reward.reshape(-1),
    )
    starts = (world.starts.start, world.starts.step, len(world.starts))
    rates = np.zeros(_RATES_KEPT) if agent.alpha_power else None
    world_rng = world.env.unwrapped.np_random
    return lambda *how_long: kernels.q_learning_along(
        agent.q_table, agent.visits, moves, counts.astype(np.uint32), starts, agent.rng, world_rng,
        agent.gamma, agent.alpha, agent.alpha_power, rates, *how_long,
    )  # fmt: skip


def _bar(num_episodes):
    from tqdm.auto import tqdm

    return tqdm(total=num_episodes, unit="episode", leave=False)
