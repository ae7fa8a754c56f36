"""A network on its way through training: the lesson's agent, counted, and what the lesson says about it."""

import numpy as np
import pytest

from course_lib import DQNAgent, Maze, evaluate_policy, value_iteration
from course_lib.explore.training import EPISODES, Training

MAZE = Maze(wall_reward=0.0)
EXACT = value_iteration(MAZE.mdp, 0.95)
WALLS_AND_CHEESE = [6, 10, 12, 15]
PARTS = {"mask": True, "replay": False, "target": False, "double": False}
SETTINGS = {
    "mask": {"mask_terminal": True},
    "replay": {"replay": 10_000, "batch_size": 32},
    "target": {"target_update": 100},
    "double": {"double": True},
}


def run_of(parts, *, seed=0, episodes):
    run = Training(MAZE, PARTS | parts, seed)
    while run.episodes < episodes:
        run.go_on()
    return run


@pytest.fixture(scope="module")
def runs():
    """Networks trained to the end, by their name, with the seeds of the lesson's tasks."""
    kinds = {
        "mask": ({}, 0), "none": ({"mask": False}, 0),
        "replay": ({"replay": True}, 1), "both": ({"replay": True, "target": True}, 1),
    }  # fmt: skip
    return {name: run_of(parts, seed=seed, episodes=EPISODES) for name, (parts, seed) in kinds.items()}


@pytest.mark.parametrize("on", [(), ("mask",), ("mask", "replay"), ("mask", "replay", "target", "double"), ("target",)])
def test_it_is_the_agent_of_the_lesson(on):
    """In portions, and counted, it is what one gets in one go."""
    run = run_of({part: part in on for part in PARTS}, seed=3, episodes=30)
    settings = {"mask_terminal": False} | {name: v for part in on for name, v in SETTINGS[part].items()}
    agent = DQNAgent(Maze(wall_reward=0.0), gamma=0.95, seed=3, **settings)
    history = agent.train(30)
    last = run.moments[-1]
    for (weights, biases), (expected, expected_biases) in zip(last.layers, agent.layers, strict=True):
        assert (weights == expected[0]).all()
        assert (biases == expected_biases[0]).all()
    np.testing.assert_allclose(last.q, agent.q_values(np.arange(16))[0], atol=1e-5)
    assert last.tries.sum() == history.episode_length.sum()
    assert (run.episodes, len(run.moments)) == (30, 4)


def test_no_training_disturbs_another():
    """Not in one maze either, in which whoever moves takes the others along, and draws the next slip."""
    world = Maze(wall_reward=0.0, slip=0.2)
    both = [Training(world, PARTS, 0) for _ in range(2)]
    alone = Training(Maze(wall_reward=0.0, slip=0.2), PARTS, 0)
    world.reset(seed=5)
    before = world.np_random.bit_generator.state
    for _ in range(2):
        alone.go_on()
        for training in both:
            training.go_on()
    for training in both:
        assert (training.moments[-1].tries == alone.moments[-1].tries).all()
        assert (training.moments[-1].q == alone.moments[-1].q).all()
    assert world.np_random.bit_generator.state == before, "the learner's own maze stays where it is"


@pytest.mark.parametrize(("on", "name"), [
    ((), "no mask, seed 3"),
    (("mask",), "mask, seed 3"),
    (("mask", "target", "double"), "mask, target, double, seed 3"),
])  # fmt: skip
def test_it_is_called_what_it_is(on, name):
    assert Training(MAZE, {part: part in on for part in PARTS}, 3).name == name


def test_tries_are_counted_where_they_are_made():
    run = run_of({}, episodes=20)
    tries = run.moments[-1].tries
    assert (tries[WALLS_AND_CHEESE] == 0).all()
    arrivals = np.zeros(16, int)
    for s, a in np.argwhere(tries):
        if not MAZE.mdp.terminal[s, a, 0]:
            arrivals[MAZE.mdp.next_state[s, a, 0]] += tries[s, a]
    arrivals[0] += run.episodes
    assert (arrivals == tries.sum(axis=1)).all(), "whoever comes in goes on, and each episode begins in the start"
    assert (run.moments[1].tries <= tries).all()
    assert run.moments[0].tries.sum() == 0


def test_what_is_earned_is_what_the_arrows_are_worth(runs):
    for run in runs.values():
        for moment in run.moments[::10]:
            assert moment.earned == pytest.approx(evaluate_policy(MAZE.mdp, moment.q.argmax(axis=1), 0.95)[0])


def test_what_the_lesson_says_about_it(runs):
    end = {name: run.moments[-1] for name, run in runs.items()}
    assert abs(end["mask"].q[0].max() - 0.7738) < 0.05
    assert end["mask"].earned == pytest.approx(0.95**5)
    assert (end["none"].q.max(axis=1) > 1).all()
    for name in ("mask", "none"):
        assert (end[name].q[WALLS_AND_CHEESE].max(axis=1) > 0.1).all()

    def losses(run):
        best = np.array([moment.earned > 0.7737 for moment in run.moments])
        return (best[:-1] & ~best[1:]).sum()

    assert losses(runs["replay"]) > losses(runs["both"])
    wrong = np.abs([moment.q.max(axis=1) - EXACT.values for moment in runs["mask"].moments])
    first = (wrong < 0.1).argmax(axis=0)
    assert first[11] <= first[0], "first beside the cheese, then in the start, though it began much nearer to the truth"
    assert wrong[0, 11] > 1.5 * wrong[0, 0]
    acting = np.delete(np.arange(16), WALLS_AND_CHEESE)
    assert wrong[-1, acting].max() > 0.1, "beside the way it stays rough"
