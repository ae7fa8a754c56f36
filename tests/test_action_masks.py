"""What is impossible is never done and never hoped for, by agents that are asked to look at masks."""

import gymnasium
import numpy as np
import pytest
import torch
from dqn_worlds import everything as everything_of_dqn
from dqn_worlds import remembered, watched
from gymnasium.wrappers import RecordEpisodeStatistics
from observed_worlds import CLOSE, HOLD, OPEN, POSSIBLE, Plain, Saying, Told
from test_q_table import everything

from course_lib import DQNAgent, Maze, QAgent
from course_lib.choice import epsilon_greedy, possible_actions, random_argmax
from course_lib.files import load_arrays, save_arrays

IMPOSSIBLE = {(0, CLOSE), (1, OPEN)}
MUCH = 1e9
LEARNING = {"replay": 200, "batch_size": 8, "target_update": 5, "mask_actions": True}
every_make = pytest.mark.parametrize("make", [Told, Plain])


def hoping(env, **agent_settings):
    """A QAgent that thinks impossible actions worth very much, and where they stand in its table."""
    agent = QAgent(env, **agent_settings)
    impossible = np.zeros((2, env.num_digits, 3), bool)
    for position, action in IMPOSSIBLE:
        impossible[position, :, action] = True
    impossible = impossible.reshape(-1, 3)
    agent.q_table[impossible] = MUCH
    return agent, impossible


# --- a choice ---------------------------------------------------------------------------------------------------------


def test_a_random_action_is_any_of_the_possible_ones_all_alike_likely():
    rng, possible = np.random.default_rng(0), np.array([True, False, True, True])
    drawn = [epsilon_greedy(np.array([0.0, 9.0, 0.0, 1.0]), 1.0, rng, possible) for _ in range(9000)]
    counts = np.bincount(drawn, minlength=4)
    assert counts[1] == 0
    assert counts[[0, 2, 3]].min() > 2800


def test_the_draws_are_those_of_a_choice_without_the_impossible_actions():
    ours, plain, which = np.random.default_rng(3), np.random.default_rng(3), np.array([1, 3, 4])
    values = np.array([5.0, 1.0, 7.0, 1.0, 0.0])
    for _ in range(200):
        chosen = epsilon_greedy(values, 0.5, ours, np.isin(np.arange(5), which))
        if plain.random() < 0.5:
            assert chosen == which[int(plain.random() * 3)]
        else:
            assert chosen == which[int(plain.random() * 2)], "a tie of the first two"
    assert ours.random() == plain.random()


def test_the_best_is_the_best_of_what_is_possible_and_one_action_left_is_taken_without_a_draw():
    rng = np.random.default_rng(0)
    before = rng.bit_generator.state
    assert random_argmax(np.array([3.0, 9.0, 5.0]), rng, np.array([True, False, True])) == 2
    assert random_argmax(np.array([3.0, 3.0, 3.0]), rng, np.array([False, True, False])) == 1
    assert rng.bit_generator.state == before


# --- tables -----------------------------------------------------------------------------------------------------------


@every_make
@pytest.mark.parametrize("epsilon", [0.0, 0.5, 1.0])
def test_a_table_never_does_and_never_hopes_for_what_is_impossible(make, epsilon):
    agent, impossible = hoping(make(), epsilon=epsilon, mask_actions=True)
    agent.train(200)
    assert (agent.q_table[impossible] == MUCH).all()
    assert not agent.visits[impossible].any()
    assert agent.visits[~impossible].any()
    assert np.abs(agent.q_table[~impossible]).max() < 100
    agent.env.taken.clear()
    for _ in range(20):
        agent.test()
    assert set(agent.env.taken) <= POSSIBLE


@every_make
def test_a_table_without_masks_does_and_hopes(make):
    agent, impossible = hoping(make(), epsilon=0.5)
    agent.train(200)
    assert agent.visits[impossible].any()
    assert agent.q_table[~impossible].max() > MUCH / 10


def test_taxi_has_masks_and_drives_by_them():
    agent = QAgent(gymnasium.make("Taxi-v4"), mask_actions=True, epsilon=1.0)
    agent.train(60)
    masks = np.array([agent.env.unwrapped.action_mask(state) for state in range(500)], bool)
    assert agent.visits.sum() > 5000
    assert not agent.visits[~masks].any()
    plain = QAgent(RecordEpisodeStatistics(gymnasium.make("Taxi-v4")), mask_actions=True, epsilon=1.0)
    plain.train(60)
    assert everything(plain) == everything(agent)


def test_act_keeps_to_the_mask_it_is_given():
    for mask_actions in (False, True):
        agent, _ = hoping(Told(), epsilon=0.5, mask_actions=mask_actions)
        for position in range(2):
            state, mask = position * agent.env.num_digits, agent.env.mask(position)
            assert {agent.act(state, mask) for _ in range(60)} == {a for p, a in POSSIBLE if p == position}
            agent.epsilon = 0.0
            agent.q_table[state, HOLD] = 5.0
            assert {agent.act(state, possible=mask.astype(bool)) for _ in range(20)} == {HOLD}
            agent.epsilon = 0.5


def test_act_without_a_mask():
    agent = QAgent(Told(first=5), epsilon=1.0)
    assert {agent.act(5) for _ in range(60)} == {5, 6, 7}
    assert {agent.act(5, [0, 1, 1]) for _ in range(60)} == {6, 7}
    with pytest.raises(ValueError, match=r"act needs to know what is possible: act.state, info"):
        QAgent(Told(), mask_actions=True).act(0)
    for mask, words in (([1, 1], r"possible must be \[3\] of 1"), ([0, 0, 0], "possible must leave an action")):
        with pytest.raises(ValueError, match=words):
            agent.act(5, mask)


# --- networks ---------------------------------------------------------------------------------------------------------


@every_make
@pytest.mark.parametrize("seen", [{}, {"digits": 40}, {"vectors": True}], ids=["few states", "many states", "vectors"])
@pytest.mark.parametrize("switches", [{}, {"double": True}, {"replay": None, "batch_size": 1}], ids=str)
def test_networks_never_do_and_never_hope_for_what_is_impossible(make, seen, switches):
    """Their values are put in by hand: very high for open in a position and for close out of one."""
    env = make(**seen, ends=[20, 40])
    hopes = {}
    for mask_actions in (True, False):
        settings = LEARNING | switches | {"mask_actions": mask_actions}
        agent = DQNAgent(env, num_agents=2, hidden=(), epsilon=0.5, **settings)
        weights = np.zeros((agent._online.sizes[0] + 1, 3), np.float32)  # of each input, then the biases
        if seen == {"vectors": True}:
            weights[2, OPEN], weights[2, CLOSE], weights[3, CLOSE] = MUCH, -MUCH, MUCH
        else:
            weights[env.num_digits : -1, OPEN] = weights[: env.num_digits, CLOSE] = MUCH
        agent.weights = np.tile(weights.reshape(-1), (2, 1))
        steps, best, real = watched(agent), [], agent._best_next

        def noted(*arguments, best=best, real=real):
            best.append(real(*arguments))
            return best[-1]

        agent._best_next = noted
        agent.train(num_steps=60)
        hopes[mask_actions] = float(torch.cat(best, dim=1).max())
        assert len(steps) == 60
        if not mask_actions:
            continue
        for walk in agent.test(4):
            position = 0
            for action in walk.actions:
                assert (position, action) in POSSIBLE
                position = {HOLD: position, OPEN: 1, CLOSE: 0}[int(action)]
    assert hopes[True] < MUCH / 100
    assert hopes[False] > MUCH / 2


@every_make
def test_what_the_networks_remember_was_possible_and_the_masks_belong_to_the_next_state(make):
    agent = DQNAgent(make(vectors=True, ends=[20, 40]), num_agents=3, epsilon=0.9, **LEARNING)
    stored = remembered(agent)
    record = agent.train(num_steps=150)
    for own, terminated, lengths in zip(stored, record.terminated, record.episode_length, strict=True):
        assert {(int(t["observation"][2]), int(t["action"])) for t in own} == POSSIBLE
        for transition in own:
            assert transition["next_possible"].tolist() == make().mask(int(transition["next_observation"][2])).tolist()
        ends = np.cumsum(lengths[lengths > 0]) - 1
        stopped = [bool(own[end]["discount"] == 0) for end in ends]
        assert stopped == terminated[lengths > 0].tolist()
        assert sum(t["discount"] == 0 for t in own) == sum(stopped)
    assert record.terminated.any()
    assert record.truncated.any()


def test_masks_that_allow_everything_change_nothing():
    class Free(Plain):
        def mask(self, position):  # noqa: ARG002
            return np.ones(3, np.int8)

    for seen in ({}, {"digits": 40}, {"vectors": True}):
        masked, usual = (
            DQNAgent(Free(**seen), num_agents=2, **(LEARNING | {"mask_actions": m})) for m in (True, False)
        )
        for agent in (masked, usual):
            agent.train(num_steps=60)
        ours, theirs = everything_of_dqn(masked), everything_of_dqn(usual)
        assert ours.pop("remembered next_possible")
        assert ours == theirs
    masked, usual = (QAgent(Free(), mask_actions=m, epsilon=0.5) for m in (True, False))
    for agent in (masked, usual):
        agent.train(30)
    assert everything(masked) == everything(usual)


# --- masks that are wrong or missing ----------------------------------------------------------------------------------


BAD_MASKS = {
    "no info": ({}, r"mask_actions needs an environment that gives info.*action_mask.*, got nothing in info"),
    "other info": ({"speed": 3}, r"got \['speed'\] in info"),
    "none": ({"action_mask": None}, r"got \['action_mask'\] in info"),
    "short": ({"action_mask": np.ones(2, np.int8)}, r"must be \[3\] of 1"),
    "a number": ({"action_mask": 1}, r"must be \[3\] of 1"),
    "a row too many": ({"action_mask": np.ones((1, 3))}, r"must be \[3\] of 1"),
    "ragged": ({"action_mask": [[1], [1, 0], 1]}, r"must be \[3\] of 1"),
    "text": ({"action_mask": "101"}, r"must be \[3\] of 1"),
    "other numbers": ({"action_mask": np.array([1, 2, 0])}, r"must be \[3\] of 1"),
    "nan": ({"action_mask": np.array([1, np.nan, 0])}, r"must be \[3\] of 1"),
    "nothing possible": ({"action_mask": np.zeros(3, np.int8)}, "must leave an action possible"),
}
every_bad_mask = pytest.mark.parametrize(("info", "words"), BAD_MASKS.values(), ids=BAD_MASKS.keys())


@every_bad_mask
@pytest.mark.parametrize("where", ["reset", "step"])
def test_a_bad_mask_is_refused_and_nothing_is_learned_from_the_step(info, words, where):
    table, networks = QAgent(Saying(info, where), mask_actions=True), DQNAgent(Saying(info, where), mask_actions=True)
    before = everything(table)["q_table"], everything_of_dqn(networks)["weights"]
    for agent in (table, networks):
        for call in (lambda agent=agent: agent.train(2), agent.test):
            with pytest.raises(ValueError, match=words):
                call()
    assert (everything(table)["q_table"], everything_of_dqn(networks)["weights"]) == before
    assert not table.visits.any()


@every_bad_mask
def test_an_end_may_do_without_a_mask_but_not_with_a_wrong_one(info, words):
    for agent in (
        QAgent(Saying(info, "end", ends=range(60)), mask_actions=True, epsilon=1.0),
        DQNAgent(Saying(info, "end", ends=range(60)), mask_actions=True, epsilon=1.0, mask_terminal=False),
    ):
        if "must be" in words:
            with pytest.raises(ValueError, match=words):
                agent.train(20)
        else:
            agent.train(20)
            assert agent.history.terminated.any()
            assert np.isfinite(agent.weights if isinstance(agent, DQNAgent) else agent.q_table).all()


def test_worlds_without_masks_say_so():
    for agent in (QAgent(Maze(), mask_actions=True), DQNAgent(Maze(), mask_actions=True, num_agents=2)):
        with pytest.raises(ValueError, match=r'mask_actions needs an environment that gives info\["action_mask"\]'):
            agent.train(1)
    assert possible_actions({"action_mask": [1, 0, True]}, 3).tolist() == [True, False, True]


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [QAgent, DQNAgent])
def test_files_from_before_there_were_masks_still_load(kind, tmp_path):
    agent = kind(Maze())
    agent.train(3)
    agent.save(tmp_path / "agent")
    arrays, saved = load_arrays(tmp_path / "agent", kind=kind.__name__)
    assert saved["agent"].pop("mask_actions") is False
    save_arrays(tmp_path / "agent", arrays, saved, kind=kind.__name__)
    resumed = kind.load(tmp_path / "agent", Maze())
    assert resumed.mask_actions is False
    resumed.train(3)


def test_a_file_in_which_nothing_is_possible_is_refused(tmp_path):
    agent = DQNAgent(Told(), num_agents=2, **LEARNING)
    agent.train(num_steps=20)
    agent.save(tmp_path / "agent")
    arrays, saved = load_arrays(tmp_path / "agent", kind="DQNAgent")
    arrays["next_possible"][1, 7] = False
    save_arrays(tmp_path / "agent", arrays, saved, kind="DQNAgent")
    with pytest.raises(ValueError, match="not a saved DQNAgent: next_possible rules out every action"):
        DQNAgent.load(tmp_path / "agent", Told())
