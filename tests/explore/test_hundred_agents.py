"""The Q-learning explorer: its hundred agents are QAgents, and what it says of them is so."""

import re

import numpy as np
import pytest

from course_lib import Action, Maze, QAgent, evaluate_policy, policy_iteration, value_iteration
from course_lib.explore import hundred_agents
from course_lib.explore.how_good import greedy_way
from course_lib.explore.hundred_agents import MAX_STEPS, NUM_EPISODES, QLearning
from course_lib.q_table import History

from . import minus

FREE = {"wall_ends_episode": False}


def put(explored, **values):
    """Turn dials to these values, by what is written beside them."""
    for name, value in values.items():
        explored.turn(name, explored.view().control(name).texts.index(f"{value:g}"))
    return explored


def trained(maze, num_agents=100, **settings):
    agents = [QAgent(maze, seed=seed, **settings) for seed in range(num_agents)]
    histories = []
    for agent in agents:
        maze.reset(seed=int(np.random.default_rng(agent.seed).integers(2**31)))  # the mazes are one and the same
        histories.append(agent.train(NUM_EPISODES, max_steps=MAX_STEPS))
    return agents, histories


def curve(explored):
    return explored.view().panels[0]


def table(explored):
    return explored.view().panels[1]


SETTINGS = [
    {},
    {"alpha": 0.5},
    {"gamma": 0.5},
    {"epsilon": 0.3},
    {"epsilon": 1.0, "epsilon_decay": 0.9},
    {"slip": 0.2},
]


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_it_trains_qagents_and_says_what_came_of_them(settings):
    explored = put(QLearning(), **settings)
    rates = {name: value for name, value in settings.items() if name != "slip"}
    agents, histories = trained(Maze(**FREE, slip=settings.get("slip", 0.0)), **rates)
    moves = np.array([history.episode_length for history in histories])
    rewards = np.array([history.episode_return for history in histories])
    assert np.array_equal(explored.trained.moves, moves)
    assert np.array_equal(explored.trained.rewards, rewards)
    assert np.array_equal(explored.trained.tables, [agent.q_table for agent in agents])
    starts = np.sort([agent.q_table[0].max() for agent in agents])
    middle = explored.trained.middle
    assert agents[middle].q_table[0].max() == starts[49]
    low, median, high = (f"{round(float(p), 3):.3g}" for p in np.percentile(moves[:, -1], (5, 50, 95)))
    early = f"{np.median(moves[:, 9]):.3g}"
    told = f"Episode 10: {early} moves in the median; episode 100: {median} moves (5 to 95\u00a0%: {low} to {high})"
    assert told in explored.message
    exact = value_iteration(explored.trained.world.mdp, settings.get("gamma", 0.9)).values[0]
    assert f"worth {starts[49]:.3f} to the middle agent, exactly {exact:.3f}." in explored.message
    assert f"{explored.trained.good.sum()} of 100 tables" in explored.message


def test_the_curve_is_drawn_where_its_numbers_say():
    explored = put(QLearning(), epsilon=0.3)
    for stop, runs in enumerate((explored.trained.moves, explored.trained.rewards)):
        explored.turn("curve", stop)
        low, middle, high = np.percentile(runs, (5, 50, 95), axis=0)
        drawn = curve(explored)
        line = next(m for m in re.findall(r'<polyline points="([^"]*)"', drawn.svg) if len(m.split()) == NUM_EPISODES)
        heights = np.array([float(point.split(",")[1]) for point in line.split()])
        known = np.log(middle) if stop == 0 else middle
        fit = np.polyfit(known, heights, 1)
        assert fit[0] < 0, "more is higher"
        assert np.abs(np.polyval(fit, known) - heights).max() < 0.1
        band = re.search(r'<polygon points="([^"]*)"', drawn.svg).group(1).split()
        bounds = np.concatenate([low, high[::-1]])
        bounds = np.log(bounds) if stop == 0 else bounds
        assert np.abs(np.polyval(fit, bounds) - [float(point.split(",")[1]) for point in band]).max() < 0.1
        for episode in (1, 10, 100):
            told = [minus(f"{round(float(p[episode - 1]), 3):.3g}") for p in (middle, low, high)]
            assert "episode {}: {} ({} to {})".format(episode, *told) in drawn.words
    assert f"cut off at {MAX_STEPS}" in drawn.svg


def test_the_message_tells_of_the_curve_that_is_shown():
    explored = put(QLearning(), epsilon=0.3)
    for stop, (shown, told) in enumerate((("moves", "{} moves"), ("reward", "a reward of {}"))):
        runs = explored.trained.rewards if stop else explored.trained.moves
        low, median, high = (minus(f"{round(float(p), 3):.3g}") for p in np.percentile(runs[:, -1], (5, 50, 95)))
        early = told.format(minus(f"{round(float(np.median(runs[:, 9])), 3):.3g}"))
        last = (
            f"Episode 10: {early} in the median; episode 100: {told.format(median)} (5 to 95\u00a0%: {low} to {high})."
        )
        put(explored, epsilon=0.3)
        explored.turn("curve", stop)
        assert explored.message == f"The curve shows the {shown} of an episode. {last}"
        put(explored, epsilon=0.3)
        assert explored.message.startswith(f"{last} Without exploring")


def test_another_curve_trains_nobody():
    explored = QLearning()
    before = explored.trained
    explored.turn("curve", 1)
    assert explored.trained is before
    assert "Learning curve: reward" in curve(explored).svg
    explored.turn("slip", 0)
    assert explored.trained is not before


def test_the_table_is_the_middle_agents():
    explored = put(QLearning(), gamma=0.95)
    q, drawn = explored.trained.tables[explored.trained.middle], table(explored)
    acting = [s for s in range(16) if s not in (6, 10, 12, 15)]
    written = re.findall(r">(−?\d\.\d\d)<", drawn.svg)
    assert written == [minus(f"{q[s, a]:z.2f}") for s in acting for a in Action]
    assert f"Q of agent {explored.trained.middle}, the middle one" in drawn.svg
    way, end = greedy_way(explored.trained.world, q)
    assert end == "to the cheese"
    assert f"lead from the start {', '.join(Action(a).name.lower() for _, a in way)}: to the cheese" in drawn.words
    off = max(abs(q[s, a] - value_iteration(Maze(**FREE).mdp, 0.95).q[s, a]) for s, a in way)
    assert f"The largest error of Q on this way is {off:.3f}" in drawn.words
    assert drawn.svg.count('fill="#ffffff" stroke="#22262b"') == len(way) == 6


def test_where_moves_slip_a_good_table_earns_nearly_the_best_return():
    explored = put(QLearning(), slip=0.2)
    world, exact = explored.trained.world, value_iteration(explored.trained.world.mdp, 0.9).values[0]
    for q, good in zip(explored.trained.tables, explored.trained.good, strict=True):
        best = q >= q.max(axis=1, keepdims=True)
        earned = evaluate_policy(world.mdp, best / best.sum(axis=1, keepdims=True), 0.9)[0]
        assert good == (earned >= 0.9 * exact)
    assert 0 < explored.trained.good.sum() < 100
    assert "tables earn at least 90\u00a0% of the best possible return" in explored.message


NEGATIVE = {"step_reward": -1.0, "wall_reward": -1.0, "goal_reward": 0.0, "slip": 0.2}


@pytest.mark.parametrize("gamma", [0.9, 1])
@pytest.mark.parametrize("rules", [NEGATIVE, {"goal_reward": 0.0, "slip": 0.1}], ids=["costs", "nothing to win"])
def test_the_best_table_is_good_where_nothing_can_be_won(rules, gamma, monkeypatch):
    best = value_iteration(Maze(**FREE, **rules).mdp, gamma).q
    worst = -best

    def known(_world, seeds, num_episodes, **_):
        nothing = np.zeros((len(seeds), num_episodes))
        tables = np.array([worst if seed % 4 == 0 else best for seed in seeds])
        return tables, History(nothing, nothing.astype(int) + 1, nothing > 0, nothing == 0)

    monkeypatch.setattr(hundred_agents, "train_side_by_side", known)
    explored = put(QLearning(Maze(**FREE, **rules)), gamma=gamma)
    assert explored.trained.good.tolist() == [bool(seed % 4) for seed in range(100)]
    assert "75 of 100 tables come within 10\u00a0% of the best possible return." in explored.message


def test_no_walk_is_below_the_picture():
    explored = QLearning(Maze())
    low = np.percentile(explored.trained.moves, 5, axis=0)
    assert low.min() < 6, "some end at a wall before the cheese could be reached"
    band = re.search(r'<polygon points="([^"]*)"', curve(explored).svg).group(1).split()
    heights = [float(point.split(",")[1]) for point in band[:NUM_EPISODES]]
    bottom = max(heights)
    assert (np.array(heights) == bottom).tolist() == (low == low.min()).tolist()
    assert bottom < 46 + 230 - 5, "above the axis"


def test_the_dotted_line_is_the_best_there_is():
    explored = QLearning()
    assert "fewest possible: 6<" in curve(explored).svg
    explored.turn("curve", 1)
    assert "best possible: 1<" in curve(explored).svg
    put(explored, slip=0.2).turn("curve", 0)
    costs = Maze(slip=0.2, step_reward=-1, wall_reward=-1, goal_reward=-1, **FREE)
    fewest = -value_iteration(costs.mdp, 1.0).values[0]
    assert fewest == pytest.approx(-policy_iteration(costs.mdp, 0.999999).values[0], abs=1e-3)
    assert f"fewest possible, on average: {fewest:.3g}<" in curve(explored).svg
    strict = QLearning(Maze())
    assert "fewest to the cheese: 6<" in curve(strict).svg, "and not the fewest possible: bumps end walks sooner"
    strict.turn("slip", 3)
    assert "possible" not in curve(strict).svg, "bumps end walks too soon to say"


def test_other_mazes_will_do():
    pocket = [[3, 0, 1, 0], [0, 4, 1, 0]]  # two cells that nobody can leave or enter
    endless = Maze([[3, 0, 4]], cell_rewards=[[0, 0.1, 0]])  # without discount there is no end to what it pays
    for maze in (Maze(pocket, **FREE), endless, Maze.random(8, 7, seed=3, **FREE), Maze([[3, 4]], goal_reward=0.0)):
        explored = QLearning(maze)
        for settings in ({"gamma": 1.0}, {"slip": 0.3}, {"gamma": 0.9}):
            view = put(explored, **settings).view()
            assert "; episode 100:" in view.message
            explored.turn("curve", 1)
            explored.view()
            explored.turn("curve", 0)


def test_a_slippery_maze_of_ones_own_stays_slippery():
    explored = QLearning(Maze(slip=0.15, **FREE))
    assert (explored.dials.slip, explored.trained.world.slip) == (0.15, 0.15)
    assert len(explored.view().control("slip").texts) == 7


def test_what_there_is_not_is_refused_before_anything_changes():
    explored = QLearning()
    before, trained_before = explored.view(), explored.trained
    for wrong in (
        lambda: explored.press("again"),
        lambda: explored.turn("beta", 0),
        lambda: explored.turn("alpha", 9),
        lambda: explored.turn("slip", 1.0),
        lambda: QLearning("maze"),
        lambda: QLearning(walks=([1.0], [3, 4])),
        lambda: QLearning(walks=([], [])),
        lambda: QLearning(walks=([1.0], [0])),
        lambda: QLearning(walks=7),
        lambda: QLearning(walks=([float("nan")], [3])),
        lambda: QLearning(Maze.random(2, 9)),
    ):
        with pytest.raises(
            ValueError, match=r"there is no|must be|the buttons are|Maze is needed|walks need|at most 8"
        ):
            wrong()
    assert explored.view() == before
    assert explored.trained is trained_before


def test_a_hundred_agents_are_a_hundred():
    assert (hundred_agents.NUM_AGENTS, QLearning().trained.moves.shape) == (100, (100, NUM_EPISODES))
