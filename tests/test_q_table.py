"""The agent learns what Q-learning learns, by whichever loop, and keeps it when it is stopped, saved or wrapped."""

import itertools

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.toy_text import FrozenLakeEnv
from gymnasium.spaces import Discrete
from gymnasium.wrappers import RecordEpisodeStatistics, TimeLimit, TransformReward
from hypothesis import given, settings
from hypothesis import strategies as st
from test_bellman import best_values
from test_maze import random_rules, world_by_the_rules

from course_lib import Maze, QAgent, kernels, q_table
from course_lib.choice import epsilon_greedy, random_argmax

UP, DOWN, LEFT, RIGHT = range(4)

WORLDS = {
    "maze": lambda: Maze(),
    "slippery maze": lambda: Maze(slip=0.3),
    "maze that always slips": lambda: Maze(slip=1.0, wall_ends_episode=False),
    "wide random maze": lambda: Maze.random(3, 7, slip=0.1, step_reward=-0.01, wall_ends_episode=False, seed=4),
    "high random maze": lambda: Maze.random(6, 2, wall_reward=-0.3, cell_rewards=np.linspace(-1, 1, 12).reshape(6, 2)),
    "registered maze": lambda: gymnasium.make("course_lib/Maze-v0", slip=0.1, max_episode_steps=11),
    "maze with a tight limit in a loose one": lambda: TimeLimit(TimeLimit(Maze(slip=0.1), 9), 13),
    "maze with a loose limit in a tight one": lambda: TimeLimit(TimeLimit(Maze(slip=0.1), 13), 9),
    "lake": lambda: gymnasium.make("FrozenLake-v1"),
    "lake without slipping": lambda: gymnasium.make("FrozenLake-v1", is_slippery=False),
    "large lake": lambda: gymnasium.make("FrozenLake-v1", map_name="8x8"),
    "lake without a time limit": lambda: FrozenLakeEnv(),
    "lake of one cell": lambda: FrozenLakeEnv(desc=[["S"]]),
    "taxi": lambda: gymnasium.make("Taxi-v4"),
    "taxi in the rain": lambda: gymnasium.make("Taxi-v4", is_rainy=True),
    "cliff": lambda: gymnasium.make("CliffWalking-v1"),
    "slippery cliff": lambda: gymnasium.make("CliffWalkingSlippery-v1"),
}
SETTINGS = {
    "the lesson's agent": {},
    "one that explores much and steps shorter and shorter": {
        "alpha": 1.0, "alpha_power": 0.7, "epsilon": 0.9, "epsilon_decay": 0.97, "gamma": 0.99, "seed": 5,
    },
}  # fmt: skip
every_world = pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())
every_setting = pytest.mark.parametrize("agent_settings", SETTINGS.values(), ids=SETTINGS.keys())


@pytest.fixture
def compiled_calls(monkeypatch):
    """The calls of the compiled loop, one entry each."""
    calls, real = [], kernels.q_learning

    def counted(*arguments):
        calls.append(len(arguments))
        return real(*arguments)

    monkeypatch.setattr(kernels, "q_learning", counted)
    return calls


def everything(agent):
    """All that training changes, to the last bit."""
    record = agent.history
    return {
        "q_table": agent.q_table.tobytes(),
        "visits": agent.visits.tobytes(),
        "epsilon": agent.epsilon.hex(),
        "history": tuple(
            array.tobytes()
            for array in (record.episode_return, record.episode_length, record.terminated, record.truncated)
        ),
        "agent's generator": agent.rng.bit_generator.state,
        "world's generator": agent.env.unwrapped.np_random.bit_generator.state,
    }


def textbook(env, episodes, *, gamma=0.9, alpha=0.1, epsilon=0.1, seed=0, max_steps=1000):
    """Q-learning as the book has it (Sutton & Barto, 2nd ed., section 6.5), with no help from the package."""
    rng = np.random.default_rng(seed)
    env.reset(seed=int(rng.integers(2**31)))
    num_actions = int(env.action_space.n)
    table = np.zeros((int(env.observation_space.n), num_actions))
    for _ in range(episodes):
        state, _ = env.reset()
        for _ in range(max_steps):
            if rng.random() < epsilon:
                action = int(rng.random() * num_actions)
            else:
                best = [a for a in range(num_actions) if table[state, a] == max(table[state])]
                action = best[int(rng.random() * len(best))] if len(best) > 1 else best[0]
            next_state, reward, terminated, truncated, _ = env.step(action)
            target = reward if terminated else reward + gamma * max(table[next_state])
            table[state, action] += alpha * (target - table[state, action])
            state = next_state
            if terminated or truncated:
                break
    return table


# --- three loops, one result ------------------------------------------------------------------------------------------


@every_world
@every_setting
def test_the_plain_and_the_compiled_loop_agree_to_the_last_bit(world, agent_settings, compiled_calls):
    compiled = QAgent(world(), **agent_settings)
    compiled.train(40, max_steps=90)
    assert len(compiled_calls) == 1
    plain = QAgent(
        RecordEpisodeStatistics(world()), **agent_settings
    )  # a wrapper that only watches is played in Python
    plain.train(40, max_steps=90)
    assert len(compiled_calls) == 1
    assert everything(plain) == everything(compiled)


@pytest.mark.parametrize("slip", [0.0, 0.2])
@every_setting
def test_a_trivial_subclass_learns_the_same_in_python(slip, agent_settings, compiled_calls):
    class SameMaze(Maze):
        """Another class may play by other rules, so it is played in Python; this one does not."""

    plain = QAgent(SameMaze.random(5, 4, slip=slip), **agent_settings)
    plain.train(60)
    assert not compiled_calls
    compiled = QAgent(Maze.random(5, 4, slip=slip), **agent_settings)
    compiled.train(60)
    assert compiled_calls
    assert everything(plain) == everything(compiled)


@every_world
def test_a_textbook_loop_learns_the_same_table(world):
    agent = QAgent(world(), seed=3)
    agent.train(40, max_steps=90)
    assert agent.q_table.tobytes() == textbook(world(), 40, seed=3, max_steps=90).tobytes()


@every_world
def test_the_compiled_loop_can_stop_and_go_on_in_the_middle_of_an_episode(world, monkeypatch, compiled_calls):
    agent_settings = SETTINGS["one that explores much and steps shorter and shorter"]
    at_once = QAgent(world(), **agent_settings)
    at_once.train(20, max_steps=50)
    assert len(compiled_calls) == 1
    monkeypatch.setattr(q_table, "_STEPS_BETWEEN_LOOKS", 7)
    bit_by_bit = QAgent(world(), **agent_settings)
    bit_by_bit.train(20, max_steps=50)
    assert len(compiled_calls) - 1 == -(-at_once.visits.sum() // 7)
    assert everything(bit_by_bit) == everything(at_once)


@pytest.mark.parametrize("make", [Maze, lambda: RecordEpisodeStatistics(Maze())], ids=["compiled", "plain"])
def test_training_twice_is_training_once_for_as_long(make):
    once, twice = (QAgent(make(), epsilon_decay=0.99, alpha_power=0.6) for _ in range(2))
    whole = once.train(50)
    parts = [twice.train(20), twice.train(0), twice.train(30)]
    assert [len(part) for part in parts] == [20, 0, 30]
    assert np.concatenate([part.episode_return for part in parts]).tobytes() == whole.episode_return.tobytes()
    once.history = twice.history = parts[-1]
    assert everything(twice) == everything(once)


def test_the_seed_decides_everything():
    first, again, other = (QAgent(Maze(slip=0.2), seed=seed) for seed in (1, 1, 2))
    for agent in (first, again, other):
        agent.train(30)
    assert everything(first) == everything(again)
    assert everything(first) != everything(other)


def test_a_bar_changes_nothing_and_goes_to_stderr(capsys):
    quiet, talking = QAgent(Maze()), QAgent(Maze())
    quiet.train(30)
    assert capsys.readouterr().err == ""
    talking.train(30, progress=True)
    shown = capsys.readouterr()
    assert "episode" in shown.err
    assert shown.out == ""
    assert everything(quiet) == everything(talking)


# --- what must not be played compiled ---------------------------------------------------------------------------------


class GenerousMaze(Maze):
    def step(self, action):
        state, reward, *rest = super().step(action)
        return state, 2 * reward, *rest


def patched(env, name="step"):
    """`env` with one method of this one instance replaced by a spy that changes the rewards, or the beginnings."""
    real = getattr(env, name)

    def step(action):
        state, reward, *rest = real(action)
        return state, reward - 1, *rest

    def reset(**arguments):
        real(**arguments)
        return env.step(RIGHT)[0], {}

    setattr(env, name, {"step": step, "reset": reset}[name])
    return env


class ImpatientLimit(TimeLimit):
    def step(self, action):
        *answer, terminated, truncated, info = super().step(action)
        return *answer, terminated, truncated or self._elapsed_steps == 2, info


OTHER_RULES = {
    "subclass with its own step": GenerousMaze,
    "patched step": lambda: patched(Maze()),
    "patched reset": lambda: patched(Maze(), "reset"),
    "patched step of a wrapper": lambda: patched(TimeLimit(Maze(), 20)),
    "patched step inside a wrapper": lambda: TimeLimit(patched(gymnasium.make("FrozenLake-v1").unwrapped), 20),
    "wrapper that changes rewards": lambda: TransformReward(Maze(), lambda reward: 3 * reward - 0.1),
    "subclass of a wrapper": lambda: ImpatientLimit(Maze(), 20),
    "fickle taxi": lambda: gymnasium.make("Taxi-v4", fickle_passenger=True),
}


@pytest.mark.parametrize("world", OTHER_RULES.values(), ids=OTHER_RULES.keys())
def test_a_world_with_rules_of_its_own_is_played_by_them(world, compiled_calls):
    agent = QAgent(world())
    agent.train(30, max_steps=100)
    assert not compiled_calls
    assert agent.q_table.tobytes() == textbook(world(), 30, max_steps=100).tobytes()


def test_a_world_that_somebody_watches_is_played_step_by_step(monkeypatch, compiled_calls):
    frames = []
    monkeypatch.setattr(FrozenLakeEnv, "render", lambda self: frames.append(self.s))
    agent = QAgent(FrozenLakeEnv(render_mode="human"))
    frames.clear()
    agent.train(5)
    assert not compiled_calls
    assert len(frames) == agent.visits.sum() + 5


def test_a_changed_table_of_a_toy_world_is_the_one_that_counts():
    env = FrozenLakeEnv(is_slippery=False)
    for actions in env.P.values():
        for a, outcomes in actions.items():
            actions[a] = [(p, s_next, r - 0.5, done) for p, s_next, r, done in outcomes]
    agent = QAgent(env)
    agent.train(20, max_steps=30)
    assert agent.q_table.min() < -0.01


# --- terminated is not truncated --------------------------------------------------------------------------------------


class OneRoom(gymnasium.Env):
    """One state, one action, a reward of 1, and an end after every step of the kind asked for."""

    observation_space = action_space = Discrete(1)

    def __init__(self, terminated, truncated):
        self.end = terminated, truncated

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        return 0, {}

    def step(self, action):
        assert action == 0
        return 0, 1.0, *self.end, {}


@pytest.mark.parametrize(
    ("terminated", "truncated", "worth"), [(True, False, 1.0), (False, True, 2.0), (True, True, 1.0)]
)
def test_only_a_termination_stops_the_bootstrap(terminated, truncated, worth):
    agent = QAgent(OneRoom(terminated, truncated), gamma=0.5, alpha=1.0)
    record = agent.train(60)
    assert agent.q_table[0, 0] == worth
    assert record.episode_length.tolist() == [1] * 60
    assert record.terminated.all() == terminated
    assert (record.truncated == ~record.terminated).all()


def test_the_cut_of_max_steps_does_not_stop_the_bootstrap():
    agent = QAgent(OneRoom(False, False), gamma=0.5, alpha=1.0)
    record = agent.train(60, max_steps=3)
    assert agent.q_table[0, 0] == 2.0
    assert record.episode_length.tolist() == [3] * 60
    assert record.truncated.all()


@pytest.mark.parametrize("wrap", [lambda env: env, RecordEpisodeStatistics], ids=["compiled", "plain"])
def test_a_time_limit_does_not_stop_the_bootstrap_and_the_goal_does(wrap):
    corridor = {"grid": [[3, 4]], "step_reward": 1.0, "goal_reward": 1.0}
    agent = QAgent(wrap(TimeLimit(Maze(**corridor), 1)), gamma=0.5, alpha=1.0, epsilon=1.0)
    record = agent.train(300)
    assert agent.q_table.tolist() == [[2.0, 2.0, 2.0, 1.0], [0.0] * 4]
    assert (record.terminated != record.truncated).all()
    assert record.terminated.any()
    assert record.truncated.any()


def test_a_goal_in_the_very_last_step_is_a_termination():
    agent = QAgent(TimeLimit(Maze([[3, 4]]), 1), epsilon=1.0)
    record = agent.train(100, max_steps=1)
    assert (record.terminated == (record.episode_return == 1)).all()
    assert record.terminated.any()


# --- what is learned --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_the_lessons_numbers(seed):
    agent = QAgent(Maze(wall_reward=0.0, wall_ends_episode=False), gamma=0.9, alpha=0.1, epsilon=0.1, seed=seed)
    agent.train(20_000)
    path = agent.test().states[:-1]  # several paths have six steps, and an agent settles on one of them
    assert agent.q_table[path].max(axis=1).round(5).tolist() == [0.59049, 0.6561, 0.729, 0.81, 0.9, 1.0]


def test_the_lessons_path():
    agent = QAgent(Maze(wall_reward=0.0, wall_ends_episode=False), seed=3)
    agent.train(200_000)
    path = [0, 1, 5, 9, 13, 14]  # right, down, down, down, right, right
    assert agent.q_table[path].max(axis=1).round(5).tolist() == [0.59049, 0.6561, 0.729, 0.81, 0.9, 1.0]


def test_a_walk_tells_where_it_went_what_it_did_and_what_it_got():
    agent = QAgent(Maze(step_reward=-0.5))
    for state, action in [(0, RIGHT), (1, DOWN), (5, DOWN), (9, DOWN), (13, RIGHT), (14, RIGHT)]:
        agent.q_table[state, action] = 1
    walk = agent.test()
    assert walk.states.tolist() == [0, 1, 5, 9, 13, 14, 15]
    assert walk.actions.tolist() == [RIGHT, DOWN, DOWN, DOWN, RIGHT, RIGHT]
    assert walk.rewards.tolist() == [-0.5] * 5 + [1]
    assert (walk.terminated, walk.truncated) == (True, False)


@settings(derandomize=True, deadline=None, max_examples=25)
@given(st.integers(0, 10_000), st.floats(0.6, 0.8))
def test_with_a_decaying_rate_the_table_comes_close_to_the_best_values(seed, power):
    rules = random_rules(seed)
    rules["grid"] = Maze.random(
        *np.random.default_rng(seed).integers(2, 5, 2).tolist(), walls=0.2, seed=seed
    ).grid.tolist()
    rules["cell_rewards"] = None
    agent = QAgent(Maze(**rules), gamma=0.7, alpha=1.0, alpha_power=power, epsilon=1.0, seed=seed)
    agent.train(60_000, max_steps=40)
    best = best_values(world_by_the_rules(**rules), 0.7)
    often = agent.visits.min(axis=1) > 3000
    assert often[agent.env.start]
    error = np.abs(agent.q_table.max(axis=1) - best)[often]
    assert error.max() < 0.1 * max(1.0, np.abs(best).max())


def test_the_rate_falls_with_the_visits_of_each_state_and_action():
    agent = QAgent(OneRoom(True, False), alpha=0.5, alpha_power=1.0)
    agent.train(1)
    assert agent.q_table[0, 0] == 0.5
    agent.train(1)
    assert agent.q_table[0, 0] == 0.5 + 0.25 * 0.5
    assert agent.visits[0, 0] == 2


def test_epsilon_decays_once_an_episode():
    agent = QAgent(Maze(), epsilon=0.5, epsilon_decay=0.5)
    agent.train(3)
    assert agent.epsilon == 0.5**4


# --- how it chooses ---------------------------------------------------------------------------------------------------


def test_act_is_greedy_but_for_a_share_epsilon():
    agent = QAgent(Maze(), epsilon=0.4)
    agent.q_table[0] = [0, 1, 0, 0]
    shares = np.bincount([agent.act(0) for _ in range(10_000)], minlength=4) / 10_000
    np.testing.assert_allclose(shares, [0.1, 0.7, 0.1, 0.1], atol=0.025)
    agent.epsilon = 0.0
    assert {agent.act(0) for _ in range(100)} == {DOWN}


def test_act_does_not_learn():
    agent = QAgent(Maze())
    agent.act(0)
    assert not agent.q_table.any()
    assert not agent.visits.any()


def test_ties_are_broken_at_random_by_act():
    firsts = []
    for seed in range(400):
        agent = QAgent(Maze(), epsilon=0.0, seed=seed)
        agent.q_table[0] = [2, 1, 2, 2]
        firsts.append(agent.act(0))
    counts = np.bincount(firsts, minlength=4)
    assert counts[DOWN] == 0
    assert counts[[UP, LEFT, RIGHT]].min() > 90


@pytest.mark.parametrize("wrap", [lambda env: env, RecordEpisodeStatistics], ids=["compiled", "plain"])
def test_ties_are_broken_at_random_by_training(wrap):
    tried = np.zeros(4)
    for seed in range(400):
        agent = QAgent(wrap(Maze()), epsilon=0.0, seed=seed)
        agent.q_table[0] = [2, 1, 2, 2]
        agent.train(1, max_steps=1)
        tried += agent.visits[0]
    assert tried[DOWN] == 0
    assert tried[[UP, LEFT, RIGHT]].min() > 90


def test_a_clear_best_action_takes_no_draw():
    rng = np.random.default_rng(0)
    before = rng.bit_generator.state
    assert random_argmax(np.array([0.0, 3.0, 1.0]), rng) == 1
    assert rng.bit_generator.state == before


def test_a_random_action_may_be_any_all_alike_likely():
    rng = np.random.default_rng(0)
    counts = np.bincount([epsilon_greedy(np.array([9.0, 0.0, 0.0]), 1.0, rng) for _ in range(9000)])
    assert counts.min() > 2800


# --- a walk -----------------------------------------------------------------------------------------------------------


def test_a_walk_learns_nothing_and_is_never_random_but_in_ties():
    agent = QAgent(Maze(wall_reward=0.0, wall_ends_episode=False), epsilon=1.0, seed=1)
    agent.train(3000)
    before = agent.q_table.tobytes(), agent.visits.tobytes(), agent.history
    walks = [agent.test() for _ in range(20)]
    assert all(walk.terminated and len(walk) == 6 for walk in walks)
    assert (agent.q_table.tobytes(), agent.visits.tobytes(), agent.history) == before


def test_a_walk_is_cut_by_its_own_limit_or_the_worlds():
    for walk in (
        QAgent(Maze(wall_ends_episode=False)).test(max_steps=4),
        QAgent(TimeLimit(Maze([[3, 0, 4]]), 4)).test(),
    ):
        assert (walk.terminated, walk.truncated) == (False, True)
        assert (len(walk), len(walk.states)) == (4, 5)


# --- spaces that do not begin at 0 ------------------------------------------------------------------------------------


class Corridor(gymnasium.Env):
    """Five cells; the second action goes on, the first goes back; the last cell pays 1 and ends."""

    def __init__(self, first_state=0, first_action=0):
        self.observation_space = Discrete(5, start=first_state)
        self.action_space = Discrete(2, start=first_action)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        self.place = 0
        return int(self.observation_space.start), {}

    def step(self, action):
        assert self.action_space.contains(action)
        self.place = max(0, self.place + (1 if action == self.action_space.start + 1 else -1))
        done = self.place == 4
        return int(self.observation_space.start) + self.place, float(done), done, False, {}


@pytest.mark.parametrize(("first_state", "first_action"), [(7, 0), (0, 3), (100, -2)])
def test_states_and_actions_may_begin_at_any_number(first_state, first_action):
    usual, moved = QAgent(Corridor()), QAgent(Corridor(first_state, first_action))
    usual.train(50)
    moved.train(50)
    assert moved.q_table.tobytes() == usual.q_table.tobytes()
    assert usual.q_table[3, 1] > 0.9
    walk = moved.test()
    assert walk.states.tolist() == [first_state + i for i in range(5)]
    assert walk.actions.tolist() == [first_action + 1] * 4
    moved.epsilon = 0.0
    assert moved.act(first_state + 3) == first_action + 1


# --- interrupted ------------------------------------------------------------------------------------------------------


def assert_kept_the_first_part(agent, steps):
    """The interrupted agent has learned from `steps` steps, and its history is the beginning of an unbroken one."""
    unbroken = QAgent(Maze(slip=0.1), epsilon_decay=0.9, seed=2)
    record, whole = agent.history, unbroken.train(50)
    assert 0 < len(record) < 50
    assert agent.visits.sum() == steps
    assert agent.q_table.any()
    for name in ("episode_return", "episode_length", "terminated", "truncated"):
        np.testing.assert_array_equal(getattr(record, name), getattr(whole, name)[: len(record)])
    assert 0 <= steps - record.episode_length.sum() < whole.episode_length[len(record)] + 1
    again = QAgent(Maze(slip=0.1), epsilon_decay=0.9, seed=2)
    again.train(len(record))
    assert agent.epsilon == again.epsilon


def test_stopped_in_the_middle_of_a_step_the_agent_keeps_what_it_has():
    class InterruptedMaze(Maze):
        steps = 0

        def step(self, action):
            self.steps += 1
            if self.steps == 101:
                raise KeyboardInterrupt
            return super().step(action)

    agent = QAgent(InterruptedMaze(slip=0.1), epsilon_decay=0.9, seed=2)
    with pytest.raises(KeyboardInterrupt):
        agent.train(50)
    assert_kept_the_first_part(agent, 100)
    assert len(agent.train(5)) == 5, "it can go on"


@pytest.mark.parametrize("heard", ["before", "after"])
def test_stopped_around_the_compiled_loop_the_agent_keeps_what_it_has(heard, monkeypatch):
    """Ctrl-C during the loop is heard when the loop returns; its result is then lost, its arrays are not."""
    real, calls = kernels.q_learning, []

    def interrupted(*arguments):
        calls.append(1)
        if heard == "before" and len(calls) == 3:
            raise KeyboardInterrupt
        result = real(*arguments)
        if heard == "after" and len(calls) == 2:
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(q_table, "_STEPS_BETWEEN_LOOKS", 50)
    monkeypatch.setattr(kernels, "q_learning", interrupted)
    agent = QAgent(Maze(slip=0.1), epsilon_decay=0.9, seed=2)
    with pytest.raises(KeyboardInterrupt):
        agent.train(50)
    monkeypatch.undo()
    assert_kept_the_first_part(agent, 100)
    assert len(agent.train(5)) == 5, "it can go on"


# --- saved and loaded -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("agent_settings", SETTINGS.values(), ids=SETTINGS.keys())
@pytest.mark.parametrize(
    "world",
    [
        Maze,
        lambda: Maze(slip=0.3),
        lambda: gymnasium.make("FrozenLake-v1"),
        lambda: RecordEpisodeStatistics(Maze(slip=0.3)),
        Corridor,
    ],
    ids=["maze", "slippery maze", "lake", "played in Python", "a learner's own"],
)
def test_training_goes_on_from_a_file_as_if_it_had_never_stopped(world, agent_settings, tmp_path):
    unbroken = QAgent(world(), **agent_settings)
    unbroken.train(30)
    unbroken.save(tmp_path / "agent")
    resumed = QAgent.load(tmp_path / "agent", world())
    assert len(resumed.history) == 0
    for agent in (unbroken, resumed):
        agent.train(30)
    assert everything(resumed) == everything(unbroken)
    assert (resumed.gamma, resumed.alpha, resumed.alpha_power, resumed.epsilon_decay, resumed.seed) == (
        unbroken.gamma, unbroken.alpha, unbroken.alpha_power, unbroken.epsilon_decay, unbroken.seed,
    )  # fmt: skip


def test_loading_leaves_the_file_as_it_is_and_saving_leaves_the_agent(tmp_path):
    agent, path = QAgent(Maze(slip=0.3)), tmp_path / "agent"
    agent.train(10)
    before = everything(agent)
    agent.save(path)
    assert everything(agent) == before
    content = path.read_bytes()
    QAgent.load(path, Maze(slip=0.3)).train(10)
    assert path.read_bytes() == content


# --- the record -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wrap", [lambda env: env, RecordEpisodeStatistics], ids=["compiled", "plain"])
def test_the_history_counts_every_step_and_reward(wrap):
    agent = QAgent(wrap(Maze(step_reward=-0.5, goal_reward=3.0, wall_reward=-2.0)), epsilon=0.5)
    record = agent.train(200, max_steps=15)
    assert record is agent.history
    assert record.episode_length.sum() == agent.visits.sum()
    assert record.episode_length.max() == 15
    last_rewards = record.episode_return + 0.5 * (record.episode_length - 1)
    assert set(last_rewards[record.terminated].tolist()) == {3.0, -2.0}
    assert set(last_rewards[record.truncated].tolist()) == {-0.5}


def test_an_agent_that_has_not_trained_has_an_empty_history_and_an_empty_table():
    agent = QAgent(Maze())
    assert len(agent.history) == 0
    assert (agent.q_table.shape, agent.q_table.dtype, agent.q_table.any()) == ((16, 4), np.float64, False)
    assert (agent.visits.shape, agent.visits.dtype, agent.visits.any()) == ((16, 4), np.int64, False)


@pytest.mark.parametrize("wrap", [lambda env: env, RecordEpisodeStatistics], ids=["compiled", "plain"])
@pytest.mark.parametrize("kind", [lambda table: table.tolist(), np.asfortranarray, lambda table: table.astype(int)])
def test_a_table_put_in_by_hand_may_be_of_any_kind(kind, wrap):
    table = np.full((16, 4), 2.0)
    usual, other = (QAgent(wrap(Maze(slip=0.1))) for _ in range(2))
    usual.q_table, other.q_table = table.copy(), kind(table)
    usual.train(20)
    other.train(20)
    assert everything(other) == everything(usual)


def test_agents_with_settings_of_their_own_do_not_disturb_each_other():
    alone = QAgent(Maze(slip=0.2), seed=0)
    alone.train(20)
    together = [QAgent(Maze(slip=0.2), seed=seed) for seed in (0, 1)]
    for _, agent in itertools.product(range(20), together):
        agent.train(1)
    assert together[0].q_table.tobytes() == alone.q_table.tobytes()
