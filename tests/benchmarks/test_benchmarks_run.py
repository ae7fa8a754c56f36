"""That each benchmark runs, at a tiny size, and that all programs in it come to the same result. Nothing about time."""

import checks
import planning
import pytest
import q_learning
import startup
from measure import compile_c, compiler, medians

needs_gcc = pytest.mark.skipif(compiler() is None, reason="gcc is not installed")


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
