"""Action masks of many lanes at once, in vector environments of every kind."""

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from observed_worlds import POSSIBLE, Plain, Saying

from course_lib import DQNAgent
from course_lib.dqn.masks import masks_in, nth_possible

every_mode = pytest.mark.parametrize("mode", list(AutoresetMode), ids=lambda mode: mode.value)


def test_the_networks_random_action_is_the_nth_possible_one():
    rng = np.random.default_rng(0)
    possible = rng.random((5000, 4)) < 0.6
    possible[:, 2] |= ~possible.any(axis=1)
    drawn = rng.random(5000)
    expected = [np.flatnonzero(mask)[int(number * mask.sum())] for mask, number in zip(possible, drawn, strict=True)]
    assert nth_possible(possible, drawn).tolist() == expected


@every_mode
def test_nobody_does_what_is_impossible_in_a_vector_environment(mode):
    """Not even in lanes in which nobody plays any more: the last has more to play than the others."""
    env = SyncVectorEnv(
        [lambda n=n: Plain(time_limit=n, vectors=True, ends=[20]) for n in (3, 7, 30)], autoreset_mode=mode
    )
    agent = DQNAgent(env, epsilon=0.5, replay=200, batch_size=8, target_update=5, mask_actions=True)
    agent.train(4)
    agent.test(3)
    taken = [set(lane.taken) for lane in env.envs]
    assert set.union(*taken) == taken[2] == POSSIBLE


@every_mode
@pytest.mark.parametrize("where", ["reset", "second reset", "step", "end"])
@pytest.mark.parametrize("info", [{}, {"action_mask": np.zeros(3, np.int8)}, {"action_mask": np.full(3, 2, np.int8)}])
def test_a_bad_mask_of_one_lane_is_refused(info, where, mode):
    def made(info, where):
        return SyncVectorEnv([Plain, lambda: Saying(info, where, ends=range(60))], autoreset_mode=mode)

    agent = DQNAgent(made(info, where), mask_actions=True, epsilon=1.0)
    if where == "end" and 2 not in info.get("action_mask", []):
        agent.train(20)
        assert agent.history.terminated[1].any()
        assert np.isfinite(agent.weights).all()
        return
    words = (
        r"must be" if 2 in info.get("action_mask", []) else "must leave an action" if info else "needs an environment"
    )
    with pytest.raises(ValueError, match=words):
        agent.train(20)


def test_masks_are_those_of_the_lanes_asked_for():
    before = np.array([[True, False], [False, True], [True, False], [False, True]])
    everybody, nobody = np.ones(4, bool), np.zeros(4, bool)
    told = np.array([[0, 1], [1, 0], [0, 1], [1, 1]], np.int8)
    assert (masks_in({"action_mask": told}, before, everybody, nobody) == told).all()
    assert (masks_in({}, before, nobody, nobody) == before).all()
    some = np.array([True, False, True, False])
    infos = {"action_mask": told, "_action_mask": some}
    assert masks_in(infos, before, some, nobody).tolist() == [[False, True]] * 4


def test_where_a_lane_has_terminated_everything_is_possible_that_is_not_ruled_out():
    before, lanes = np.array([[True, False]] * 4), np.array([True, True, True, False])
    infos = {
        "action_mask": np.array([[0, 1], [0, 0], [0, 0], [0, 0]]),
        "_action_mask": np.array([True, True, False, False]),
    }
    masks = masks_in(infos, before, lanes, np.ones(4, bool))
    assert masks.tolist() == [[False, True], [True, True], [True, True], [True, False]]
    assert masks_in({}, before, lanes, np.ones(4, bool)).tolist() == [[True, True]] * 3 + [[True, False]]


def test_masks_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"must be \[2, 3\] of 1"):
        masks_in({"action_mask": np.ones((2, 4))}, np.ones((2, 3), bool), np.ones(2, bool), np.zeros(2, bool))
