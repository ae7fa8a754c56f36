"""A world seen through an observation, known as a table, is learned from as it would be step by step."""

import gymnasium
import numpy as np
import pytest
from dqn_worlds import everything as everything_of_dqn
from dqn_worlds import learned
from gymnasium.spaces import Box, Discrete
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import RecordEpisodeStatistics, TimeLimit, TransformReward
from observed_worlds import Plain, Told
from test_q_table import everything

from course_lib import MDP, DQNAgent, QAgent, kernels, q_table, value_iteration
from course_lib.dqn import lanes
from course_lib.table_world import TableWorld

WORLDS = {
    "tape": {},
    "one that ends": {"ends": range(3, 60, 7)},
    "numbers from 5 on": {"first": 5},
    "one start": {"starts": range(9, 10), "ends": [20]},
    "starts counted backwards": {"starts": range(44, 0, -5)},
    "starts in and out of a position": {"starts": range(5, 105, 33), "ends": [50]},
    "states seen as they are": {"digits": None},
    "everything looks alike": {"digits": 1},
}
SETTINGS = {
    "the lesson's agent": {},
    "masked": {"mask_actions": True, "epsilon": 0.3},
    "masked, steps shorter and shorter": {
        "mask_actions": True, "alpha": 1.0, "alpha_power": 0.6, "epsilon": 0.9, "epsilon_decay": 0.97, "gamma": 0.99,
        "seed": 5,
    },
    "never at random, steps shorter": {"epsilon": 0.0, "alpha_power": 0.7},
    "always at random": {"epsilon": 1.0, "mask_actions": True},
}  # fmt: skip
every_world = pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())
every_setting = pytest.mark.parametrize("agent_settings", SETTINGS.values(), ids=SETTINGS.keys())


@pytest.fixture
def compiled_calls(monkeypatch):
    """The calls of the compiled loop, one entry each."""
    calls, real = [], kernels.q_learning_along

    def counted(*arguments):
        calls.append(len(arguments))
        return real(*arguments)

    monkeypatch.setattr(kernels, "q_learning_along", counted)
    return calls


# --- tables -----------------------------------------------------------------------------------------------------------


@every_world
@every_setting
@pytest.mark.parametrize("rates_kept", [9, 2**16])
def test_the_plain_and_the_compiled_loop_agree_to_the_last_bit(
    world, agent_settings, rates_kept, compiled_calls, monkeypatch
):
    monkeypatch.setattr(q_table, "_RATES_KEPT", rates_kept)
    compiled = QAgent(Told(**world), **agent_settings)
    compiled.train(80)
    assert len(compiled_calls) == 1
    assert not compiled.env.taken, "nothing was stepped"
    plain = QAgent(Plain(**world), **agent_settings)
    plain.train(80)
    assert len(compiled_calls) == 1
    assert plain.env.taken
    assert everything(plain) == everything(compiled)
    assert bool(plain.history.terminated.any()) == ("ends" in world)
    assert plain.visits.max() > 9


@every_world
@every_setting
def test_the_compiled_loop_can_stop_and_go_on_in_the_middle_of_an_episode(
    world, agent_settings, monkeypatch, compiled_calls
):
    at_once = QAgent(Told(**world), **agent_settings)
    at_once.train(30)
    monkeypatch.setattr(q_table, "_STEPS_BETWEEN_LOOKS", 7)
    bit_by_bit = QAgent(Told(**world), **agent_settings)
    bit_by_bit.train(30)
    assert len(compiled_calls) - 1 == -(-at_once.visits.sum() // 7)
    assert everything(bit_by_bit) == everything(at_once)


def test_interrupted_it_keeps_what_it_has_learned(monkeypatch):
    """Ctrl-C during the loop is heard when the loop returns; its result is then lost, its arrays are not."""
    real, calls = kernels.q_learning_along, []

    def interrupted(*arguments):
        calls.append(1)
        result = real(*arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(q_table, "_STEPS_BETWEEN_LOOKS", 50)
    monkeypatch.setattr(kernels, "q_learning_along", interrupted)
    agent, whole = (QAgent(Told(), mask_actions=True, epsilon_decay=0.9) for _ in range(2))
    with pytest.raises(KeyboardInterrupt):
        agent.train(50)
    monkeypatch.undo()
    assert (len(agent.history), agent.visits.sum()) == (6, 100)
    whole.train(6)
    assert agent.epsilon == whole.epsilon
    assert agent.history.episode_return.tolist() == whole.history.episode_return.tolist()


@pytest.mark.parametrize("make", [Told, Plain])
def test_training_goes_on_from_a_file_as_if_it_had_never_stopped(make, tmp_path):
    unbroken = QAgent(make(), mask_actions=True, alpha_power=0.6, epsilon_decay=0.99)
    unbroken.train(30)
    unbroken.save(tmp_path / "agent")
    resumed = QAgent.load(tmp_path / "agent", make())
    assert resumed.mask_actions is True
    for agent in (unbroken, resumed):
        agent.train(30)
    assert everything(resumed) == everything(unbroken)


@pytest.mark.parametrize("limit", [4, 15, 40])
def test_the_tighter_limit_of_world_and_wrapper_counts(limit, compiled_calls):
    compiled, plain = (QAgent(TimeLimit(make(time_limit=15), limit)) for make in (Told, Plain))
    for agent in (compiled, plain):
        agent.train(20)
    assert len(compiled_calls) == 1
    assert compiled.history.episode_length.tolist() == [min(limit, 15)] * 20
    assert everything(compiled) == everything(plain)


class ByOtherRules(Told):
    """It inherits a table that does not tell what it does."""

    def step(self, action):
        state, reward, *rest = super().step(action)
        return state, 2 * reward, *rest


def patched():
    env = Told()
    real = env.step
    env.step = lambda action: real(action)
    return env


def watched():
    env = Told()
    env.render_mode = "human"
    return env


@pytest.mark.parametrize(
    "make",
    [
        ByOtherRules, patched, watched, lambda: RecordEpisodeStatistics(Told()),
        lambda: TransformReward(Told(), lambda reward: 2 * reward),
    ],
    ids=["subclass", "patched", "watched", "recorded", "transformed"],
)  # fmt: skip
def test_a_world_with_rules_of_its_own_is_played_by_them(make, compiled_calls):
    assert TableWorld.of(make()) is None
    agent = QAgent(make())
    agent.train(3)
    assert not compiled_calls
    assert len(agent.env.unwrapped.taken) == agent.visits.sum() > 0


@pytest.mark.parametrize("make", [Told, Plain])
def test_only_a_termination_stops_the_bootstrap(make):
    """With alpha = 1 the values become exact: through every time limit, and not through the ends."""
    world = {"digits": None, "length": 12, "time_limit": 3, "ends": [4, 9]}
    told = Told(**world).as_table_world()
    reward = np.where(told["possible"][:, :, None], told["mdp"].reward, -1e6)  # never worth taking
    reward[[10, 11, 22, 23]] = 0.0  # seen at the end of the last episodes, never acted in
    exact = value_iteration(MDP(told["mdp"].next_state, told["mdp"].probability, reward, told["mdp"].terminal), 0.9)
    agent = QAgent(make(**world), alpha=1.0, gamma=0.9, epsilon=1.0, mask_actions=True)
    agent.train(5000)
    tried = agent.visits > 0
    assert tried.sum() == 2 * 10 + 2 * 7, "everywhere out of a position; in one not at the beginning and at the ends"
    np.testing.assert_allclose(agent.q_table[tried], exact.q[tried], atol=1e-9)


# --- networks ---------------------------------------------------------------------------------------------------------

SEEN = {"few states": {}, "many states": {"digits": 40, "first": 3}, "vectors": {"vectors": True}}
SWITCHES = {
    "the defaults": {},
    "masked": {"mask_actions": True, "epsilon": 0.6},
    "everything": {
        "replay": 60, "batch_size": 4, "target_update": 7, "double": True, "mask_terminal": False, "hidden": (12, 9),
        "epsilon": 0.8, "epsilon_decay": 0.97, "learning_rate": 3e-3, "mask_actions": True,
    },
    "no second opinion": {"replay": 60, "batch_size": 4, "target_update": 0.05, "mask_actions": True},
}  # fmt: skip
every_sight = pytest.mark.parametrize("seen", SEEN.values(), ids=SEEN.keys())
every_switch = pytest.mark.parametrize("switches", SWITCHES.values(), ids=SWITCHES.keys())


@every_sight
@every_switch
def test_networks_learn_the_same_from_the_table_and_from_the_world_itself(seen, switches):
    table, plain = (DQNAgent(make(ends=range(3, 60, 7), **seen), num_agents=3, **switches) for make in (Told, Plain))
    assert type(table._lanes()) is lanes.TableLanes
    assert type(plain._lanes()) is lanes.EnvLanes
    for agent in (table, plain):
        agent.train(num_steps=70)
    assert everything_of_dqn(table) == everything_of_dqn(plain)
    assert table.history.terminated.any()
    for agent in (table, plain):  # on in the middle of an episode
        agent.train(3, max_steps=11)
    assert everything_of_dqn(table) == everything_of_dqn(plain)
    assert not table.env.taken
    for ours, theirs in zip(table.test(2), plain.test(2), strict=True):
        for name in ("states", "actions", "rewards", "terminated"):
            np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))


@every_sight
@every_switch
@pytest.mark.parametrize("mode", list(AutoresetMode), ids=lambda mode: mode.value)
def test_networks_learn_the_same_in_a_vector_environment(seen, switches, mode):
    world = {"starts": range(9, 10), "ends": [20], "time_limit": 13, **seen}  # its lanes draw as it likes
    table = DQNAgent(Told(**world), num_agents=3, **switches)
    vector = DQNAgent(SyncVectorEnv([lambda: Plain(**world)] * 3, autoreset_mode=mode), **switches)
    for agent in (table, vector):
        agent.train(num_steps=70)
    assert table.history.terminated.any()
    assert table.history.truncated.any()
    assert everything_of_dqn(vector) == everything_of_dqn(table)


@every_sight
def test_agents_of_an_ensemble_are_those_one_gets_alone(seen):
    together = DQNAgent(Told(**seen), num_agents=3, seed=4, **SWITCHES["everything"])
    together.train(6)
    rows = everything_of_dqn(together)
    for i in range(3):
        alone = DQNAgent(Told(**seen), seed=4 + i, **SWITCHES["everything"])
        alone.train(6)
        for name, [row] in everything_of_dqn(alone).items():
            if not name.startswith("actions"):  # which are as many as the longest of all episodes has
                assert row == rows[name][i], name


@every_sight
def test_networks_go_on_from_a_file_as_if_they_had_never_stopped(seen, tmp_path):
    unbroken = DQNAgent(Told(**seen), num_agents=2, **SWITCHES["everything"])
    unbroken.train(num_steps=37)
    unbroken.save(tmp_path / "agent")
    resumed = DQNAgent.load(tmp_path / "agent", Told(**seen))
    assert resumed.mask_actions is True
    for agent in (unbroken, resumed):
        agent.train(num_steps=50)
    assert learned(resumed) == learned(unbroken)


# --- tables that do not fit -------------------------------------------------------------------------------------------


def telling(**changes):
    class Changed(Told):
        def as_table_world(self):
            return super().as_table_world() | changes

    return Changed


TWO_OUTCOMES = MDP(np.zeros((120, 3, 2), int), np.full((120, 3, 2), 0.5), np.zeros((120, 3, 2)), np.zeros((120, 3, 2)))
ONE_ACTION = MDP(np.zeros((120, 1, 1), int), np.ones((120, 1, 1)), np.zeros((120, 1, 1)), np.zeros((120, 1, 1)))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mdp": None}, "mdp must be an MDP of 3 actions with 1 outcome each, got None"),
        ({"mdp": TWO_OUTCOMES}, "mdp must be .* got MDP.120 states, 3 actions, up to 2 outcomes"),
        ({"mdp": ONE_ACTION}, "mdp must be .* got MDP.120 states, 1 actions"),
        ({"observed": None}, r"observed must be 120 whole numbers in Discrete.8.*, got object\[\]"),
        ({"observed": np.zeros(119, int)}, r"observed must be .* got int64\[119\]"),
        ({"observed": np.zeros(120)}, r"observed must be .* got float64\[120\]"),
        ({"observed": np.full(120, 8)}, r"observed must be 120 whole numbers in Discrete.8"),
        ({"observed": np.full(120, -1)}, r"observed must be 120 whole numbers in Discrete.8"),
        ({"possible": np.ones((120, 2))}, r"possible must be \[120, 3\] of 1"),
        ({"possible": np.zeros((120, 3))}, "possible must leave an action possible"),
        ({"starts": None}, "starts must be a range of states from 0 to 119, got None"),
        ({"starts": [3]}, "starts must be a range"),
        ({"starts": range(0)}, "starts must be a range"),
        ({"starts": range(-1, 5)}, "starts must be a range"),
        ({"starts": range(110, 121)}, "starts must be a range"),
        ({"starts": range(200, 5, -10)}, "starts must be a range"),
        ({"time_limit": 0}, "time_limit must be at least 1"),
        ({"time_limit": 2.5}, "time_limit must be a whole number"),
    ],
)  # fmt: skip
def test_a_table_that_does_not_fit_is_refused(changes, words):
    for agent in (QAgent(telling(**changes)()), DQNAgent(telling(**changes)())):
        with pytest.raises(ValueError, match=words):
            agent.train(1)


@pytest.mark.parametrize("observed", [np.zeros((120, 2), np.float32), np.zeros((120, 3), int), np.zeros(120), None])
def test_vectors_that_do_not_fit_are_refused(observed):
    with pytest.raises(ValueError, match=r"observed must be \[120, 3\] floats in Box"):
        DQNAgent(telling(observed=observed)(vectors=True)).train(1)


def test_what_a_world_need_not_say_is_taken_for_none():
    class Short(gymnasium.Env):
        observation_space, action_space = Discrete(4), Discrete(2)

        def as_table_world(self):
            next_state = np.array([[1, 2], [3, 0], [0, 0], [3, 3]])[:, :, None]
            ones = np.ones(next_state.shape)
            return {"mdp": MDP(next_state, ones, ones, next_state == 3), "starts": range(3)}

    world = TableWorld.of(Short())
    assert (world.observed, world.possible, world.time_limit, world.start) == (None, None, None, None)
    agent = QAgent(Short(), alpha=1.0, gamma=0.5, epsilon=1.0)
    agent.train(300)
    assert agent.q_table.round(6).tolist() == [[2.0, 2.0], [1.0, 2.0], [2.0, 2.0], [0.0, 0.0]]
    assert lanes.lanes_of(Short(), 2).observations.tolist() == [0, 0]


def test_a_box_of_several_dimensions_is_flattened():
    class Square(Told):
        def __init__(self):
            super().__init__(vectors=True)
            self.observation_space = Box(-10, 10, (1, 3))

        def seen(self, position, time):
            return super().seen(position, time)[None]

        def as_table_world(self):
            told = super().as_table_world()
            return told | {"observed": told["observed"].reshape(120, 3)}

    square, usual = DQNAgent(Square()), DQNAgent(Told(vectors=True))
    for agent in (square, usual):
        agent.train(5)
    assert learned(square) == learned(usual)
    assert square.test()[0].states.shape[1:] == (1, 3)
