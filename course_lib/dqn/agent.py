"""Deep Q-learning (Mnih et al., 2015) for E agents at once."""

import numpy as np
import torch

from course_lib.dqn import saved, settings
from course_lib.dqn.calm import small_tensors, whole_steps
from course_lib.dqn.draws import Draws
from course_lib.dqn.episodes import Ended, Underway
from course_lib.dqn.inputs import inputs_of
from course_lib.dqn.lanes import lanes_of
from course_lib.dqn.masks import nth_possible
from course_lib.dqn.networks import Adam, Networks, add_at, starting_weights
from course_lib.dqn.replay import Replay
from course_lib.dqn.walks import greedy_walks
from course_lib.validate import fraction, whole_number

_REMEMBERED = {"reward": ((), torch.float32), "discount": ((), torch.float32)}  # of a transition, beside its states


class DQNAgent:
    """E agents, each with a network for its action values, trained side by side by deep Q-learning.

    weights -= Adam's step along the gradient of the mean of (q(s, a) - y)^2 over a batch, where y = r + gamma max_a'
    q'(s', a'), and y = r after a terminated step; q' is the target network, or q itself where there is none.

    env              a Gymnasium environment with Discrete or Box observations and Discrete actions, its id, or a
                     `VectorEnv` with a lane an agent
    hidden           nodes of the hidden layers (ReLU); Discrete states go in one-hot encoded
    gamma            discount, in [0, 1]
    learning_rate    of Adam (Kingma & Ba, 2015)
    epsilon          how often an action is random, in [0, 1]; multiplied by epsilon_decay after every episode
    replay           how many transitions an agent remembers to learn from (Lin, 1992); None: only the latest
    batch_size       transitions in a gradient step; one follows every step in the world, once there are that many
    learning_starts  how many transitions an agent collects before it begins to learn; None: batch_size
    target_update    gradient steps between copies of q to q'; a fraction below 1: how much of the way to q the target
                     network goes after each of them (Lillicrap et al., 2016); None: no target network
    double           q chooses the action, q' says what it is worth (van Hasselt et al., 2016)
    mask_terminal    False: bootstrap from terminal states too, a mistake that lesson 6 makes on purpose
    mask_actions     leave out the actions that `info["action_mask"]` rules out, when acting and in y. `ValueError` from
                     an environment without such masks, or with one of another shape or that rules out everything
    num_agents       E; None: 1, or the lanes of a `VectorEnv`
    device           where networks and memories are: 'cpu' or 'cuda'
    seed             agent i draws everything from seed + i, and is the agent one gets alone with that seed

    The defaults are the first agent of lesson 6 with the terminal mask. `epsilon` is float64[E], `history` the latest
    `train`'s; `env` may be replaced by one with the same spaces, to test elsewhere than one trains. `ValueError` for a
    setting out of range and for spaces of another kind.
    """

    def __init__(
        self, env, *, hidden=(20,), gamma=0.95, learning_rate=1e-3, epsilon=0.5, epsilon_decay=0.999, replay=None,
        batch_size=1, learning_starts=None, target_update=None, double=False, mask_terminal=True, mask_actions=False,
        num_agents=None, device="cpu", seed=0,
    ):  # fmt: skip
        self.env = settings.environment(env)
        sizes = settings.network_sizes(self.env, hidden)
        self.hidden = sizes[1:-1]
        self.gamma = fraction("gamma", gamma)
        self.learning_rate = settings.positive("learning_rate", learning_rate)
        epsilon = fraction("epsilon", epsilon)
        self.epsilon_decay = fraction("epsilon_decay", epsilon_decay)
        self.batch_size = whole_number("batch_size", batch_size, at_least=1)
        self.replay = None if replay is None else whole_number("replay", replay, at_least=self.batch_size)
        if replay is None and self.batch_size > 1:
            raise ValueError(f"a batch_size of {batch_size} needs a replay buffer to draw from, got replay=None")
        self.learning_starts = settings.learning_starts(learning_starts, self.batch_size, self.replay)
        self.target_update = settings.target_update(target_update)
        self.double, self.mask_terminal, self.mask_actions = bool(double), bool(mask_terminal), bool(mask_actions)
        if self.double and self.target_update is None:
            raise ValueError("double needs a target network to ask for a second opinion, got target_update=None")
        self.num_agents = settings.number_of_agents(num_agents, self.env)
        self.device = settings.device(device)
        self.seed = whole_number("seed", seed)

        self._inputs = inputs_of(*settings.spaces(self.env), self.device)
        generators = [np.random.default_rng(self.seed + i) for i in range(self.num_agents)]
        flat = np.stack([starting_weights(sizes, generator) for generator in generators])
        self._online = Networks(sizes, torch.from_numpy(flat).to(self.device))
        self._target = self._online if self.target_update is None else Networks(sizes, self._online.flat.clone())
        self._everybody = torch.arange(self.num_agents, device=self.device)
        self._target_table = None  # what the target network says of all states, until it changes
        self._adam = Adam(self._online.flat)
        self._underway = Underway([int(generator.integers(2**31)) for generator in generators])
        fields = _REMEMBERED | self._inputs.fields
        if self.mask_actions:
            fields["next_possible"] = (sizes[-1:], torch.bool)
        self._memory = self.replay and Replay(self.num_agents, self.replay, fields, self.device)
        self._draws = Draws(generators, 2 + (self.batch_size if self.replay else 0))
        self.epsilon = np.full(self.num_agents, epsilon)
        self.history = Ended(self.num_agents).history()

    @property
    def weights(self):
        """All weights and biases, float32[E, P], a copy; put others in their place to go on with those.

        So one keeps the best of several moments. The target networks become copies. `ValueError` for another shape, and
        for NaN or infinity.
        """
        return self._online.flat.cpu().numpy().copy()

    @weights.setter
    def weights(self, weights):
        flat = settings.weights(weights, self._online.flat.shape)
        self._online.flat.copy_(torch.from_numpy(flat))
        self._target.flat.copy_(self._online.flat)
        self._target_table = None

    @property
    def layers(self):
        """[(weights float32[E, inputs, outputs], biases float32[E, outputs]), …], a copy."""
        return [(w.cpu().numpy().copy(), b.squeeze(1).cpu().numpy().copy()) for w, b in self._online.layers]

    def q_values(self, observations):
        """What the networks say, float32[E, B, A], of B observations: [B, …] for all agents alike, or [E, B, …].

        A batch of Discrete observations is int[B]; one state is a batch of one. `ValueError` for anything else. Nothing
        is masked: an impossible action has a value too, which means nothing.
        """
        with small_tensors():
            return self._online.forward(self._inputs.question(observations, self.num_agents)).q.cpu().numpy()

    def train(self, num_episodes=None, *, num_steps=None, max_steps=1000, progress=False):
        """Every agent plays so many more episodes, or steps, learning from each step; returns their `History`, [E, N].

        With num_steps the last episode stays unfinished, and the next call goes on in it. Agents with fewer episodes
        than others have NaN (return), 0 (length) and False at the end of their row. max_steps: the most steps of an
        episode; it does not hold in a `VectorEnv` that begins its episodes by itself. Stopped (Ctrl-C), the agents
        keep what they have learned, and a further `train`, also of a saved and loaded agent, goes on as if nothing had
        happened. `progress=True` shows a bar.
        """
        wanted = settings.how_long(num_episodes, num_steps)
        max_steps = whole_number("max_steps", max_steps, at_least=1)
        lanes = self._lanes()
        ended, stepped = Ended(self.num_agents), np.zeros(self.num_agents, np.int64)
        bar = _bar(num_episodes, num_steps, self.num_agents) if progress else None
        try:
            with small_tensors(), whole_steps() as stop_if_asked:
                self._underway.go_on(lanes)
                while (playing := (ended.count < wanted[0]) & (stepped < wanted[1])).any():
                    stepped += self._step(lanes, playing, max_steps, ended)
                    if bar is not None:
                        done = int(ended.count.sum()) if num_steps is None else int(stepped.min())
                        bar.update(done - bar.n)
                    stop_if_asked()
        finally:
            self.history = ended.history()
            if bar is not None:
                bar.close()
        return self.history

    def test(self, num_episodes=1, *, max_steps=1000, seed=0):
        """Greedy walks that teach nothing, so many of each agent, agent by agent: list[Rollout].

        They begin from `seed`: the same call gives the same walks. A walk of max_steps steps is cut (truncated).
        """
        num_episodes = whole_number("num_episodes", num_episodes, at_least=1)
        max_steps, seed = whole_number("max_steps", max_steps, at_least=1), whole_number("seed", seed)
        lanes = self._lanes()
        generators = [np.random.default_rng((seed, int(first))) for first in self._underway.first_seeds]
        seeds = np.stack([generator.integers(2**31, size=num_episodes) for generator in generators])
        with small_tensors():
            walks = greedy_walks(lanes, lambda _: self._look_and_choose(lanes)[1], seeds, max_steps)
        first_action = int(settings.spaces(self.env)[1].start)
        for walk in walks:
            walk.states, walk.actions = self._inputs.as_seen(walk.states), walk.actions + first_action
        return walks

    def save(self, path):
        """Write the agents to `path`, with all that training needs to go on (safetensors, no pickle)."""
        saved.save(self, path)

    @classmethod
    def load(cls, path, env, *, device="cpu"):
        """The agents saved in `path`, at work in `env`: training goes on as if it had never stopped.

        `ValueError` for a damaged or foreign file, and for an `env` that the networks do not fit.
        """
        return saved.load(cls, path, env, device)

    def _lanes(self):
        """The worlds to play in. `env` may have been replaced: `ValueError` if the networks do not fit it any more."""
        settings.number_of_agents(self.num_agents, self.env)
        inputs = inputs_of(*settings.spaces(self.env), self.device)
        needed = settings.network_sizes(self.env, self.hidden)
        if needed != self._online.sizes:
            raise ValueError(f"the networks have layers of {self._online.sizes} nodes, this env needs others: {needed}")
        if type(inputs) is not type(self._inputs):
            raise ValueError(f"the networks were made for another kind of observations than {self.env}'s")
        self._inputs = inputs
        return lanes_of(self.env, self.num_agents, self.mask_actions)

    def _look(self, observations):
        """The `Pass` for what the agents see, and what they think of it, float32[E, A]."""
        x, rows = self._inputs.asked(observations)
        passed = self._online.forward(x)
        return passed, passed.q[self._everybody, torch.from_numpy(rows).to(self.device)].cpu().numpy()

    def _look_and_choose(self, lanes):
        """The `Pass` for what the agents see, and a best possible action of each, int64[E]."""
        passed, q = self._look(lanes.observations)
        return passed, (np.where(lanes.possible, q, -np.inf) if self.mask_actions else q).argmax(axis=1)

    def _step(self, lanes, playing, max_steps, ended):
        """One step of the agents that are `playing`, and what is learned from it. Which agents really stepped, bool[E].

        Whatever a stranger's environment raises, it raises before anything is changed, or when all is done.
        """
        drawn, observations = self._draws.rows(), lanes.observations
        explores = drawn[:, 0] < self.epsilon
        passed = best = None
        if self._memory is None or self._inputs.asks_all or not explores.all():
            passed, best = self._look_and_choose(lanes)
        if self.mask_actions:
            at_random = nth_possible(lanes.possible, drawn[:, 1])
        else:
            at_random = (drawn[:, 1] * self._inputs.num_actions).astype(np.int64)
        actions = at_random if best is None else np.where(explores, at_random, best)
        following, rewards, terminated, truncated, stepped = lanes.step(actions, playing)

        transition = self._inputs.transition(observations, actions, following)
        outcome = np.array([rewards, self.gamma * ~(terminated & self.mask_terminal)], np.float32)
        transition["reward"], transition["discount"] = torch.from_numpy(outcome).to(self.device)
        if self.mask_actions:
            transition["next_possible"] = torch.from_numpy(lanes.next_possible).to(self.device)
        if self._memory is None:
            batch, learning = {name: values.unsqueeze(1) for name, values in transition.items()}, stepped
        else:
            self._memory.store(transition, stepped)
            learning = stepped & (self._memory.count >= self.learning_starts)
            batch = self._memory.sample(drawn[:, 2:]) if learning.any() else None
        if learning.any():
            self._learn(passed, batch, learning)

        self._draws.spend(stepped)
        self._underway.add(actions, rewards, stepped)
        over = terminated | truncated
        if not lanes.begins_by_itself:
            over = over | (self._underway.steps >= max_steps)
        over = over & stepped
        if over.any():
            ended.add(over, self._underway, terminated)
            self.epsilon[over] *= self.epsilon_decay
            self._underway.end(over)
            self._underway.begin(lanes, over)
        return stepped

    def _learn(self, passed, batch, learning):
        """One gradient step of those agents that are `learning`, bool[E], on a batch each."""
        x, entries, next_x, next_rows = self._inputs.batch(batch)
        if x is not None:
            passed = self._online.forward(x)
        if self.mask_actions:
            best = self._best_next(passed, next_x, next_rows, batch["next_possible"])
        else:
            best = self._best_next(passed, next_x).gather(1, next_rows)
        y = batch["reward"] + batch["discount"] * best
        q = passed.q.flatten(1)
        error = q.gather(1, entries) - y
        dq = add_at(torch.zeros_like(q), entries, error * (2 / error.shape[1]))
        gradient = self._online.backward(passed, dq.view_as(passed.q))
        self._adam.step(self._online.flat, gradient, self.learning_rate, learning)
        self._update_target(learning)

    def _best_next(self, passed, next_x, rows=None, possible=None):
        """max_a' q'(s', a'), or q'(s', argmax_a' q(s', a')) if `double`, of every row of next_x; float32[E, N].

        With masks, bool[E, B, A], of those rows, int64[E, B], over their possible actions; float32[E, B].
        """

        def ask(networks):
            if next_x is not None:
                return networks.forward(next_x).q
            if networks is self._online:  # has been asked about all states already
                q = passed.q
            else:
                if self._target_table is None:
                    self._target_table = networks.forward(None).q
                q = self._target_table
            return q if possible is None else q.gather(1, rows.unsqueeze(2).expand(possible.shape))

        def only_possible(q):
            return q if possible is None else q.masked_fill(~possible, -torch.inf)

        q = ask(self._target)
        if not self.double:
            return only_possible(q).amax(dim=2)
        return q.gather(2, only_possible(ask(self._online)).argmax(dim=2, keepdim=True)).squeeze(2)

    def _update_target(self, learning):
        if self.target_update is None:
            return
        if self.target_update < 1:
            share = torch.from_numpy((self.target_update * learning).astype(np.float32)).to(self.device)
            self._target.flat.lerp_(self._online.flat, share[:, None])
            self._target_table = None
            return
        due = learning & (self._adam.updates % self.target_update == 0)
        if not due.any():
            return
        self._target_table = None
        if due.all():
            self._target.flat.copy_(self._online.flat)
        else:
            which = torch.from_numpy(np.flatnonzero(due)).to(self.device)
            self._target.flat.index_copy_(0, which, self._online.flat[which])


def _bar(num_episodes, num_steps, num_agents):
    from tqdm.auto import tqdm

    if num_steps is None:
        return tqdm(total=num_episodes * num_agents, unit="episode", leave=False)
    return tqdm(total=num_steps, unit="step", leave=False)
