"""What a study refuses, and what it says then: grids, seeds, functions, what these give, who gets them."""

import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from study_worlds import drawn, same

from course_lib import QAgent, study

# --- what cannot be meant ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("grid", "said"),
    [
        (3, "grid must be"),
        ([], "at least one setting"),
        ({"scale": []}, "at least one setting"),
        ([{"scale": 1}, 3], "grid must be"),
        ({"scale": [1, 1]}, "every setting once"),
        ({"scale": [np.nan]}, "setting scale must be a finite number"),
        ({"scale": object()}, "setting scale must be plain"),
        ({"scale": [np.zeros(2)]}, "must be plain"),
        ({"scale": [{1: 2}]}, "must be plain"),
        ({3: [1]}, "must be that of an argument, got 3"),
        ({"seed": [1]}, "given by seeds="),
        ({"colour": [1]}, r"drawn\(seed, size=3, scale=1.0\) cannot be called with .*'colour'"),
    ],
)
def test_a_grid_that_cannot_be_meant_is_refused(grid, said):
    with pytest.raises(ValueError, match=said):
        study.run(drawn, grid, seeds=2)


@pytest.mark.parametrize("seeds", [0, -1, 1.5, [], [1, 1], [-1], ["a"], None, "ab", [2**63]])
def test_so_are_seeds(seeds):
    with pytest.raises(ValueError, match="seed"):
        study.run(drawn, {}, seeds=seeds)


def nothing():
    return {}


def of_another(a):
    return {"a": a}


def by_name(*, seed):
    return {"x": seed}


@pytest.mark.parametrize("train", [None, "drawn", QAgent, np.sum, nothing, of_another, by_name])
def test_so_are_functions(train):
    with pytest.raises(ValueError, match=r"train must be a function|must be seed|cannot be called"):
        study.run(train, {}, seeds=2)


def test_so_are_blocks_and_executors():
    for block in (0, 1.5, "all"):
        with pytest.raises(ValueError, match="block"):
            study.run(drawn, {}, block=block)
    with pytest.raises(ValueError, match=r"executor must be a concurrent.futures.Executor, got 2"):
        study.run(drawn, {}, executor=2)


@pytest.mark.parametrize(
    ("given_back", "said"),
    [
        (None, "must return"),
        ({}, "must return"),
        ([1], "must return"),
        ({"x": "3"}, "x must be a number or a curve"),
        ({"x": [[1, 2], [3, 4]]}, r"x must be a number or a curve \[N\], got shape \[2, 2\]"),
        ({"x": [[1], [3, 4]]}, "x must be a number or a curve"),
        ({"a": 1}, "no setting's, got 'a'"),
        ({"seed": 1}, "no setting's, got 'seed'"),
        ({1: 1}, "no setting's, got 1"),
    ],
)
def test_what_is_given_back_must_be_numbers_with_names(given_back, said):
    def train(seed, a):
        return given_back if seed + a else None

    with pytest.raises(study.CellFailed, match=f"a = 5, seed 0: ValueError: .*{said}"):
        study.run(train, {"a": 5}, seeds=2)


def test_a_function_of_blocks_must_give_an_entry_for_each_seed():
    with pytest.raises(study.CellFailed, match=r"seeds 0 to 2: ValueError: x must be \[3\] numbers or \[3, N\] curves"):
        study.run(lambda seeds: {"x": float(sum(seeds))}, {}, seeds=3)
    assert study.run(lambda seeds: {"x": seeds * 2}, {}, seeds=3).measures["x"].tolist() == [[0, 2, 4]]


def test_all_runs_must_give_the_same():
    def odd(seed, size):
        return {"x": np.zeros(size + (seed == 3))} if seed != 5 else {"y": 0}

    with pytest.raises(study.CellFailed, match=r"size = 2, seed 3: gave x\[3\], others x\[2\]"):
        study.run(odd, {"size": [2]}, seeds=4)
    with pytest.raises(ValueError, match=r"size = 2, seed 3: gave x\[3\], but size = 2, seed 0 gave x\[2\]"):
        study.run(odd, {"size": [2, 4]}, seeds=5, block=1)
    with pytest.raises(ValueError, match="seed 5: gave y, but size = 2, seed 4 gave"):
        study.run(odd, {"size": [2]}, seeds=[4, 5], block=1)
    assert study.run(odd, {"size": [2, 4]}, seeds=2).curves["x"]["size = 4"].shape == (2, 4)


def test_labels_are_never_the_same():
    results = study.run(lambda seed, a: {"x": len(str(a)) + seed}, {"a": [1, "1", 1.0, None]}, seeds=2)
    assert results.labels == ["a = 1", "a = '1'", "a = 1.0", "a = None"]


def test_results_say_what_there_is():
    results = study.run(drawn, {"scale": [1, 2]}, seeds=2)
    with pytest.raises(ValueError, match="no measure 'curve'; there are: number"):
        results.summary("curve")
    with pytest.raises(ValueError, match="no curve 'number'; there are: curve"):
        results.bands("number")
    with pytest.raises(ValueError, match=r"one setting, and is 0; there are: scale = 1 or scale = 2"):
        results.scores("number", scale=3)
    with pytest.raises(ValueError, match="one setting, and is 2"):
        results.scores("number")


def test_a_measure_with_nan_is_kept_but_not_summarised():
    results = study.run(lambda seed: {"x": np.nan if seed == 1 else 1.0}, {}, seeds=3)
    assert results.table["x"].isna().sum() == 1
    with pytest.raises(ValueError, match="x of all runs: scores must be finite, got 1"):
        results.summary()


@pytest.mark.parametrize("name", ["n", "measure", "low", "high", "iqm"])
def test_a_setting_called_like_a_column_of_the_summary_is_refused_there(name):
    train = {}
    exec(f"def train(seed, {name}, scale=1): return {{'x': seed * {name}}}", train)
    results = study.run(train["train"], {name: [1, 2], "scale": 1}, seeds=3)
    with pytest.raises(ValueError, match=f"columns of its own called {name}: rename"):
        results.summary()
    if name in ("measure", "iqm"):
        statistic = np.median if name == "iqm" else study.interquartile_mean
        summary = results.summary("x", statistic=statistic)
        assert summary[name].tolist() == [1, 2]
        assert summary.columns.is_unique


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"env": {"slip": 2}}, "slip must be"),
        ({"env": {"slop": 0.1}}, "env must be the rules of a Maze"),
        ({"env": "NoSuch-v0"}, "there is no environment 'NoSuch-v0'"),
        ({"env": 3}, "there is no environment 3"),
        ({"curve": "returns"}, "curve must be None"),
        ({"curve": "episode_return", "every": 0}, "every must be"),
        ({"num_episodes": 0}, "num_episodes must be"),
        ({"alpha": 0}, "alpha must be"),
        ({"alhpa": 0}, "alhpa"),
    ],
)
@pytest.mark.parametrize("train", [study.train_tables, study.train_networks])
def test_settings_of_agents_that_cannot_be_meant_are_named(train, settings, said):
    if train is study.train_networks and "alpha" in settings:
        return
    with pytest.raises(study.CellFailed, match=f"seeds 0 to 1: .*{said}"):
        study.run(train, settings, seeds=2)


# --- functions that other processes do not find -----------------------------------------------------------------------


def test_a_function_within_another_is_not_handed_to_processes():
    def mine(seed):
        return {"x": seed}

    said = "mine is defined within another function of test_study_bad_input, where other processes do not find it"
    with ProcessPoolExecutor(1) as pool, pytest.raises(ValueError, match=said):
        study.run(mine, {}, executor=pool)
    with ThreadPoolExecutor(1) as pool:
        assert study.run(mine, {}, seeds=3, executor=pool).measures["x"].tolist() == [[0, 1, 2]]


def test_neither_is_one_of_a_notebook():
    """A notebook's functions are those of `__main__`, as a program's are."""
    code = """
from concurrent.futures import ProcessPoolExecutor
from course_lib import study
def mine(seed):
    return {"x": seed}
if __name__ == "__main__":
    print(study.run(mine, {}, seeds=3))
    try:
        study.run(mine, {}, seeds=3, executor=ProcessPoolExecutor(1))
    except ValueError as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines()[0] == "Results: 1 settings × 3 seeds: x", done.stderr
    assert "mine is defined in a notebook or a script, where other processes do not find it" in done.stdout
    assert "copy the file to every computer" in done.stdout
    assert "threads take any function" in done.stdout


class Elsewhere(ThreadPoolExecutor):
    """Threads that only hand work on, as a pool of interpreters does: what they get must be packed."""

    def submit(self, function, *arguments):
        pickle.dumps((function, *arguments))
        return super().submit(function, *arguments)


def test_an_executor_derived_from_threads_is_not_taken_for_threads():
    with Elsewhere(2) as pool:
        assert same(study.run(drawn, {}, executor=pool), study.run(drawn, {}))
        with pytest.raises(ValueError, match="threads take any function"):
            study.run(lambda seed: {"x": seed}, {}, executor=pool)


def test_local_workers_are_threads():
    with study.workers(threads=2) as pool:
        assert isinstance(pool, ThreadPoolExecutor)
        assert same(study.run(drawn, {}, executor=pool), study.run(drawn, {}))
    with study.workers() as pool:
        assert pool.submit(len, "abc").result() == 3
    with pytest.raises(ValueError, match="threads"), study.workers(threads=0):
        pass


def test_settings_are_plain_from_the_start():
    grid = {"scale": np.array([0.5, 1.5]), "size": (np.int64(2),)}
    results = study.run(drawn, grid, seeds=2)
    assert results.settings == [{"scale": 0.5, "size": 2}, {"scale": 1.5, "size": 2}]
    assert results.scores("number", scale=np.float64(0.5), size=np.int64(2)).tolist() == [
        drawn(0, 2, 0.5)["number"],
        drawn(1, 2, 0.5)["number"],
    ]
    assert {type(value) for chosen in results.settings for value in chosen.values()} == {int, float}
