"""The Q-learning explorer: its hundred agents are QAgents, and what it says of them is so."""

import itertools
import re
from html import unescape

import numpy as np
import pytest

from course_lib import Action, Maze, QAgent, evaluate_policy, explore, policy_iteration, value_iteration
from course_lib.explore import hundred_agents
from course_lib.explore.hundred_agents import MAX_STEPS, NUM_EPISODES, QLearning, greedy_way, leads_straight, returns_of
from course_lib.explore.mouse import KEPT_IN, keep_walks
from course_lib.q_table import History

FREE = {"wall_ends_episode": False}
WALKS = ([-3.0, -1.0, 1.0], [31, 14, 6])


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
    assert f"Episode 100: {median} moves in the median (5 to 95\u00a0%: {low} to {high})" in explored.message
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
            told = [f"{round(float(p[episode - 1]), 3):.3g}" for p in (middle, low, high)]
            assert "episode {}: {} ({} to {})".format(episode, *told) in drawn.words
    assert f"cut off at {MAX_STEPS}" in drawn.svg


def test_the_message_tells_of_the_curve_that_is_shown():
    explored = put(QLearning(), epsilon=0.3)
    for stop, (shown, told) in enumerate((("moves", "{} moves"), ("reward", "a reward of {}"))):
        runs = explored.trained.rewards if stop else explored.trained.moves
        low, median, high = (f"{round(float(p), 3):.3g}" for p in np.percentile(runs[:, -1], (5, 50, 95)))
        last = f"Episode 100: {told.format(median)} in the median (5 to 95\u00a0%: {low} to {high})."
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
    written = re.findall(r">(-?\d\.\d\d)<", drawn.svg)
    assert written == [f"{q[s, a]:z.2f}" for s in acting for a in Action]
    assert f"Q of agent {explored.trained.middle}, the middle one" in drawn.svg
    way, end = greedy_way(explored.trained.world, q)
    assert end == "to the cheese"
    assert f"lead from the start {', '.join(Action(a).name.lower() for _, a in way)}: to the cheese" in drawn.words
    off = max(abs(q[s, a] - value_iteration(Maze(**FREE).mdp, 0.95).q[s, a]) for s, a in way)
    assert f"The largest error of Q on this way is {off:.3f}" in drawn.words
    assert drawn.svg.count('fill="#ffffff" stroke="#22262b"') == len(way) == 6


def straight_by_walking(world, q):
    """Every way along best actions, walked: the slow and sure answer."""
    shortest = dict.fromkeys(world.goals, 0)
    for steps in range(1, world.grid.size):
        for s, a in itertools.product(range(world.grid.size), range(4)):
            if shortest.get(int(world.mdp.next_state[s, a, 0])) == steps - 1 and world.grid.flat[s] in (0, 3):
                shortest.setdefault(s, steps)
    at, steps = {world.start}, shortest[world.start]
    for _ in range(steps):
        at = {
            int(world.mdp.next_state[s, a, 0])
            for s in at - set(world.goals)
            for a in np.flatnonzero(np.isclose(q[s], q[s].max(), rtol=0, atol=1e-9))
        }
    return at <= set(world.goals)


@pytest.mark.parametrize(
    "world", [Maze(**FREE), Maze(), Maze.random(5, 6, seed=8, **FREE)], ids=["course", "strict", "random"]
)
def test_which_tables_lead_straight(world):
    rng = np.random.default_rng(1)
    exact = value_iteration(world.mdp, 0.9).q
    tables = exact + rng.choice([0.0, 1e-12, 0.3], size=(200, 1, 1)) * rng.normal(size=(200, *exact.shape))
    tables[:3] = 0.0
    tables[3:40] = np.where(rng.random((37, *exact.shape)) < 0.05, 1.0, exact)
    found = leads_straight(world, tables)
    assert found.tolist() == [straight_by_walking(world, q) for q in tables]
    assert 40 < found.sum() < 190
    assert not found[:3].any()


def test_a_bump_that_ends_the_walk_is_no_way_to_the_cheese():
    world = Maze([[3, 1], [0, 4]])
    q = np.zeros((1, 4, 4))
    q[0, 0, Action.RIGHT] = 1.0
    assert not leads_straight(world, q)[0]


@pytest.mark.parametrize("slip", [0.1, 0.5])
@pytest.mark.parametrize("gamma", [0.5, 0.95])
@pytest.mark.parametrize("rules", [FREE, {}], ids=["free", "strict"])
def test_what_tables_earn_is_their_policys_value(slip, gamma, rules):
    world, rng = Maze(**rules, slip=slip), np.random.default_rng(2)
    tables = np.round(value_iteration(world.mdp, gamma).q + rng.normal(scale=0.2, size=(30, 16, 4)), 1)
    best = tables >= tables.max(axis=2, keepdims=True)
    expected = [evaluate_policy(world.mdp, b / b.sum(axis=1, keepdims=True), gamma)[0] for b in best]
    assert returns_of(world, tables, gamma) == pytest.approx(expected, abs=1e-4)


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
            assert "Episode 100:" in view.message
            explored.turn("curve", 1)
            explored.view()
            explored.turn("curve", 0)


def test_a_slippery_maze_of_ones_own_stays_slippery():
    explored = QLearning(Maze(slip=0.15, **FREE))
    assert (explored.dials.slip, explored.trained.world.slip) == (0.15, 0.15)
    assert len(explored.view().control("slip").texts) == 7


def test_ways_that_lead_nowhere_are_told():
    world, q = Maze(**FREE), np.zeros((16, 4))
    assert greedy_way(world, q) == ([], "in cell 0 all actions are alike to it")
    q[0, Action.UP] = 1
    assert greedy_way(world, q) == ([(0, 0)], "it runs in a circle through cell 0")
    q[0], q[1] = (0, 0, 0, 1), (0, 0, 1, 0)
    assert greedy_way(world, q) == ([(0, 3), (1, 2)], "it runs in a circle through cell 0")
    q[1] = (0, 0, 0, 1)
    q[2] = (0, 1, 0, 0)
    assert greedy_way(Maze(), q)[1] == "a bump in cell 2 ends it"
    assert greedy_way(world, q) == ([(0, 3), (1, 3), (2, 1)], "it runs in a circle through cell 2")


def test_ones_own_walks_stand_beside_the_agents():
    explored = QLearning(walks=WALKS)
    drawn = curve(explored)
    assert "you, in lesson 0<" in drawn.svg
    assert drawn.words.endswith("You, in lesson 0: 31, 14, 6.")
    assert len(re.findall(r'<rect [^>]*stroke="#ffffff" stroke-width="0.8"', drawn.svg)) == 3 + 1, "walks, legend"
    explored.turn("curve", 1)
    assert curve(explored).words.endswith("You, in lesson 0: -3, -1, 1.")
    explored.press("walks")
    assert "you" not in unescape(curve(explored).svg)
    assert explored.view().control("walks").label == "show my walks from lesson 0"
    explored.press("walks")
    assert "you, in lesson 0" in curve(explored).svg
    assert explored.view().control("walks").label == "hide my walks"
    assert "3 of them. The last one took 6 moves and had a reward of +1" in explored.message
    quick = QLearning(walks=([1.0], [1]))
    quick.press("walks")
    quick.press("walks")
    assert "The last one took 1 move and" in quick.message
    assert QLearning(Maze([[3, 4]])).message.startswith("Episode 100: 1 move in the median (5 to 95\u00a0%: 1 to ")


def test_very_long_walks_have_room():
    explored = QLearning(walks=([-900.0], [4000]))
    for stop in (0, 1):
        explored.turn("curve", stop)
        square = re.findall(r'<rect x="[\d.]+" y="([\d.]+)" width="8" height="8"', curve(explored).svg)[0]
        assert 46 < float(square) < 46 + 230


def test_the_walks_kept_in_lesson_0_are_read_when_asked_for_and_not_before(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    without = explore.q_learning().still()
    explored = QLearning()
    explored.press("walks")
    assert explored.message.startswith("There are no walks of yours yet: play lesson 0")
    assert "you" not in curve(explored).svg
    for damaged in ("{", '{"returns": [1], "lengths": []}', '{"returns": "a"}'):
        (tmp_path / KEPT_IN).write_text(damaged, encoding="utf-8")
        explored.press("walks")
        assert explored.message.startswith("my_mouse.json cannot be read as walks")
        assert "you" not in curve(explored).svg
    keep_walks(KEPT_IN, *WALKS)
    assert explore.q_learning().still() == without
    explored.press("walks")
    assert curve(explored).words.endswith("You, in lesson 0: 31, 14, 6.")


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
