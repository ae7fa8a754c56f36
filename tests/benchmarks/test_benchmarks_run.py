"""That each benchmark runs, at a tiny size, and that all programs in it come to the same result. Nothing about time."""

from contextlib import ExitStack

import checks
import dqn
import explorers
import market
import numpy as np
import planning
import pytest
import q_learning
import startup
import study
from measure import compile_c, compiler, medians

from course_lib.maze import Action

needs_gcc = pytest.mark.skipif(compiler() is None, reason="gcc is not installed")
needs_sb3 = pytest.mark.skipif(not dqn.HAS_SB3, reason="stable-baselines3 is not installed")
needs_anytrading = pytest.mark.skipif(not market.HAS_ANYTRADING, reason="gym-anytrading is not installed")
needs_keras = pytest.mark.skipif(not dqn.HAS_KERAS, reason="keras is not installed")
each_history = pytest.mark.parametrize("name", ["MSFT", "rubber band"])
calls_keras = pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # of Keras's own


def test_turns_are_taken_and_the_first_round_is_not_counted():
    calls = []
    times = {"a": iter([100.0, 1.0, 5.0, 3.0]), "b": iter([100.0, 2.0, 2.0, 7.0])}
    runs = {name: lambda name=name: calls.append(name) or next(times[name]) for name in times}
    assert medians(runs, 3) == {"a": 3.0, "b": 2.0}
    assert calls == ["a", "b"] * 4


@needs_gcc
def test_c_learns_the_same_table_to_the_last_bit():
    assert q_learning.check_c(q_learning.c_libraries(), 300) > 300 * q_learning.SHORTEST


def test_the_original_program_learns_the_same_way():
    assert q_learning.check_original(1000) > 1000 * q_learning.SHORTEST


@needs_gcc
@pytest.mark.parametrize("gamma", planning.GAMMAS)
def test_value_iteration_finds_the_distances_that_c_finds(gamma):
    maze = planning.Maze.random(40, 30, walls=0.2, seed=0)
    planning.check_search(planning.Search(compile_c("breadth_first.c"), maze), gamma)


@pytest.mark.parametrize("method", planning.QUANTECON_METHODS)
def test_quantecon_finds_the_same_values(method):
    pytest.importorskip("quantecon", reason="quantecon is not installed")
    planning.check_quantecon(planning.Maze.random(12, 10, walls=0.2, seed=0).mdp, 0.9, method)


def test_the_one_file_loop_makes_the_same_gradient_steps():
    dqn.check_gradient_steps(100)


def test_many_deep_agents_all_go_the_shortest_way():
    dqn.check_ways(dqn.ours(8), dqn.q_tables_ours(4000, 8))


def test_the_one_file_loop_goes_the_shortest_way():
    dqn.check_ways(dqn.CLEANRL, [dqn.on_threads(1, lambda: dqn.q_table_cleanrl(2000))])


@needs_sb3
def test_stable_baselines3_goes_the_shortest_way():
    dqn.check_ways(dqn.SB3, [dqn.on_threads(1, lambda: dqn.q_table_sb3(2000))])


@needs_keras
@calls_keras
def test_the_original_deep_program_runs():
    dqn.check_original(num_episodes=2)


def test_a_way_that_ends_in_a_wall_or_nowhere_is_no_way_to_the_goal():
    right, down, up = (np.eye(4)[np.full(16, action)] for action in (Action.RIGHT, Action.DOWN, Action.UP))
    assert [dqn.way_to_goal(q_table) for q_table in (right, down, up)] == [None] * 3


@each_history
@pytest.mark.parametrize("masked", [True, False])
def test_the_compiled_walk_comes_to_what_stepping_comes_to(name, masked):
    prices = market.histories()[name].iloc[-400:]
    assert market.check_walk(prices, masked, 5) == 5 * (400 - market.WINDOW - 1)


@each_history
def test_the_coins_pay_what_the_environment_pays(name):
    prices = market.histories()[name].iloc[-400:]
    assert market.check_coin_tossers(prices, 5) == 5 * (400 - market.WINDOW - 1)


@each_history
def test_the_environment_pays_what_the_account_says(name):
    prices = market.histories()[name].iloc[-400:]
    assert market.check_account(prices, 5) == 5 * (400 - market.WINDOW - 1)


@each_history
def test_every_lane_is_an_environment(name):
    assert market.check_vector(market.histories()[name], num_lanes=5, num_steps=100) == 5 * 3


@needs_anytrading
@each_history
def test_gym_anytrading_makes_the_same_money_where_there_are_no_fees(name):
    money = market.check_anytrading(market.histories()[name], 5)
    assert len({round(ours, 3) for _, ours in money}) == 5


def test_the_compiled_learner_learns_what_the_stepping_one_learns():
    bars = 600
    assert market.check_learners(market.RubberBandMarket().prices(bars + market.WINDOW, seed=0), 5) == 5 * bars


@pytest.mark.parametrize("rules", study.WORLDS.values(), ids=study.WORLDS)
def test_threads_and_processes_train_the_same_agents(rules):
    with ExitStack() as stack:
        assert 0.5 < study.check_same(study.pools(stack), rules, num_agents=60, num_episodes=1000) <= 1


def test_study_prints_its_tables(capsys):
    study.main(num_agents=30, num_episodes=20, long_episodes=50, repeats=1)
    assert capsys.readouterr().out.count(f"| {study.TWO_PROCESSES} ") == 2


def test_q_learning_prints_its_table(capsys):
    q_learning.main(num_episodes=300, original_episodes=1000, repeats=1)
    assert q_learning.TRAIN in capsys.readouterr().out


def test_planning_prints_its_tables(capsys):
    planning.main(side=20, quantecon_side=10, repeats=1, quantecon_repeats=1)
    assert "slip 0.2" in capsys.readouterr().out


def test_checks_prints_its_table(capsys):
    answers = checks.whole_answers()
    assert len(answers) > 5
    checks.main(repeats=1, answers={checks.REFERENCE: answers[checks.REFERENCE]})
    assert f"the reference, {checks.REFERENCE}" in capsys.readouterr().out


def test_startup_prints_its_tables(capsys):
    startup.main(repeats=1, calls=["QAgent.train"], call_repeats=1)
    assert "import course_lib" in capsys.readouterr().out


@calls_keras
def test_dqn_prints_its_tables(capsys, monkeypatch):
    monkeypatch.setattr(dqn, "AGENTS", (1, 2))
    dqn.main(num_steps=40, original_episodes=1, trial_steps=1, check_steps=2000, check_agents=1, repeats=1)
    assert dqn.ours(2) in capsys.readouterr().out


def test_dqn_says_what_is_not_installed(capsys, monkeypatch):
    for name, value in {"AGENTS": (1,), "HAS_SB3": False, "HAS_KERAS": False}.items():
        monkeypatch.setattr(dqn, name, value)
    dqn.main(num_steps=40, trial_steps=1, check_steps=2000, check_agents=1, repeats=1)
    printed = capsys.readouterr().out
    assert printed.count("is not installed") == 2
    assert not any(name in printed for name in (f"| {dqn.SB3}", f"| {dqn.ORIGINAL}"))


def test_market_prints_its_tables(capsys, monkeypatch):
    for name, value in {"LANES": (1, 2), "BATCHES": (8,), "NETWORKS": 2}.items():
        monkeypatch.setattr(market, name, value)
    tiny_market(passes=2)
    printed = capsys.readouterr().out
    assert all(f"| {program} " in printed for program in (market.DISCRETE, market.COIN_TOSSERS, market.COMPILED))
    assert printed.count("network-steps a second") == 1


def test_market_says_what_is_not_installed(capsys, monkeypatch):
    for name, value in {"LANES": (1,), "BATCHES": (8,), "HAS_ANYTRADING": False, "HAS_SB3": False}.items():
        monkeypatch.setattr(market, name, value)
    tiny_market(passes=1)
    printed = capsys.readouterr().out
    assert printed.count("is not installed") == 2
    assert not any(name in printed for name in (f"| {market.ANYTRADING}", f"| {market.SB3}"))


def tiny_market(passes):
    market.main(num_steps=50, walk_steps=50, repeats=1, passes=passes, sb3_steps=1, network_steps=1, long_repeats=1)


def test_explorers_are_measured_in_a_browser():
    pytest.importorskip("playwright", reason='playwright is not installed: pip install -e ".[browser]"')
    if not explorers.find_browser():
        pytest.skip("there is no browser")
    taken = explorers.measure(2, explorers.LESSONS[:1])
    assert [what.split(":")[0] for what in taken][:2] == ["limit", "usual"]
    assert sum(what.startswith("02 Bellman by hand") for what in taken) > 2
    assert all(0 < milliseconds < 60_000 for numbers in taken.values() for milliseconds in numbers)
