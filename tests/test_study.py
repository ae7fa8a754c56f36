"""Studies: what they train, that nothing but settings and seeds decides the result, and what they refuse."""

import os
import signal
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from study_worlds import NETWORKS, TABLES, InOrder, drawn, ends_its_process, fails, same, slow

from course_lib import DQNAgent, Maze, QAgent, study


@pytest.fixture(autouse=True)
def one_torch_thread():
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


# --- what comes out ---------------------------------------------------------------------------------------------------


def test_a_cell_of_tables_is_what_one_gets_alone():
    results = study.run(study.train_tables, TABLES, seeds=[4, 0, 9])
    assert results.labels[1] == "alpha = 0.1, epsilon = 0.3"
    history = QAgent(Maze(slip=0.2), alpha=0.1, epsilon=0.3, seed=9).train(60)
    assert results.scores("mean_return", alpha=0.1, epsilon=0.3)[2] == history.episode_return.mean()
    assert results.scores("end_return", alpha=0.1, epsilon=0.3)[2] == history.episode_return[-6:].mean()
    assert results.scores("mean_length", alpha=0.1, epsilon=0.3)[2] == history.episode_length.mean()
    curve = results.curves["episode_return"]["alpha = 0.1, epsilon = 0.3"][2]
    parts = [history.episode_return[first : first + 7].mean() for first in range(0, 60, 7)]
    assert curve == pytest.approx(parts, abs=1e-15)


def test_a_cell_of_networks_is_what_one_gets_side_by_side():
    results = study.run(study.train_networks, NETWORKS, seeds=range(3, 6))
    agents = DQNAgent(Maze(slip=0.1), num_agents=3, seed=3, hidden=(5,), learning_rate=0.01)
    history = agents.train(6, max_steps=20)
    assert np.array_equal(results.scores("mean_return", learning_rate=0.01), history.episode_return.mean(axis=1))
    assert np.array_equal(results.scores("mean_length", learning_rate=0.01), history.episode_length.mean(axis=1))


def test_networks_whose_seeds_do_not_follow_each_other_are_those_of_their_seeds():
    grid = NETWORKS | {"learning_rate": 0.01, "curve": "episode_length", "every": 2}
    results = study.run(study.train_networks, grid, seeds=[7, 2, 3, 11])
    for i, seed in enumerate([7, 2, 3, 11]):
        alone = DQNAgent(Maze(slip=0.1), seed=seed, hidden=(5,), learning_rate=0.01).train(6, max_steps=20)
        assert results.measures["mean_length"][0, i] == pytest.approx(alone.episode_length.mean())
        assert len(results.curves["episode_length"][results.labels[0]][i]) == 3


def test_an_environment_may_be_one_of_gymnasiums():
    results = study.run(study.train_tables, {"env": "FrozenLake-v1", "num_episodes": 30}, seeds=2)
    assert (results.measures["mean_length"] > 1).all()


def test_the_table_has_a_row_for_each_setting_and_seed():
    results = study.run(
        lambda seed, a, b: {"sum": 100 * a + 10 * len(b) + seed}, {"a": [1, 2], "b": ["x", "yy"]}, seeds=3
    )
    table = results.table
    assert list(table) == ["a", "b", "seed", "sum"]
    assert table["sum"].tolist() == [110, 111, 112, 120, 121, 122, 210, 211, 212, 220, 221, 222]
    assert table["seed"].tolist() == [0, 1, 2] * 4
    assert table.groupby(["a", "b"])["sum"].mean().tolist() == [111, 121, 211, 221]


def test_the_summary_has_a_row_for_each_setting():
    results = study.run(drawn, {"scale": [1.0, 3.0]}, seeds=40)
    summary = results.summary("number")
    assert list(summary) == ["scale", "n", "iqm", "low", "high"]
    for row, scores in zip(summary.itertuples(), results.measures["number"], strict=True):
        assert (row.iqm, row.low, row.high) == study.bootstrap(scores)
    assert summary["n"].tolist() == [40, 40]
    every = results.summary(statistic=np.median, seed=3, resamples=50)
    assert list(every) == ["scale", "measure", "n", "median", "low", "high"]
    assert every["median"].tolist() == [np.median(scores) for scores in results.measures["number"]]


def test_one_seed_has_no_interval():
    summary = study.run(drawn, {}, seeds=[5]).summary("number")
    assert summary["iqm"].tolist() == [drawn(5)["number"]]
    assert summary[["low", "high"]].isna().all(axis=None)


def test_bands_are_those_of_the_curves():
    results = study.run(drawn, {"size": [3, 5]}, seeds=10)
    bands = results.bands("curve", resamples=50)
    assert [len(found.middle) for found in bands.values()] == [3, 5]
    assert np.array_equal(bands["size = 5"], study.band(results.curves["curve"]["size = 5"], resamples=50))


def test_settings_may_be_listed_and_differ_in_their_names():
    results = study.run(slow, [{"pause": 0.0}, {"size": 4, "pause": 0}, {}], seeds=2)
    assert results.labels == ["pause = 0.0", "pause = 0, size = 4", "all runs"]
    assert results.table["size"].isna().sum() == 4


def test_what_varies_makes_the_label():
    results = study.run(drawn, {"size": 2, "scale": [1, 2]}, seeds=2)
    assert results.labels == ["scale = 1", "scale = 2"]
    assert study.run(drawn, {"size": 2}, seeds=2).labels == ["size = 2"]
    assert study.run(drawn, {}, seeds=2).labels == ["all runs"]
    assert repr(results) == "Results: 2 settings × 2 seeds: number, curve"


@settings(deadline=None)
@given(st.lists(st.floats(-10, 10), min_size=1, max_size=30), st.integers(1, 40))
def test_a_thinned_curve_keeps_the_means_of_its_parts(curve, every):
    plain = [np.mean(curve[first : first + every]) for first in range(0, len(curve), every)]
    assert study.thinned(curve, every) == pytest.approx(plain, abs=1e-12)
    assert study.thinned([curve, curve], every).shape == (2, len(plain))


# --- the same to the last bit -----------------------------------------------------------------------------------------


@settings(max_examples=20, deadline=None)
@given(st.permutations(range(8)))
def test_the_order_in_which_cells_are_finished_changes_nothing(order):
    results = study.run(drawn, {"scale": [1.0, 2.0]}, seeds=8, block=2, executor=InOrder(list(order)))
    assert same(results, study.run(drawn, {"scale": [1.0, 2.0]}, seeds=8, block=2))


@pytest.mark.parametrize(("train", "grid"), [(study.train_tables, TABLES), (study.train_networks, NETWORKS)])
def test_one_thread_two_threads_and_two_processes_find_the_same(train, grid):
    found = []
    for pool in (ThreadPoolExecutor(1), ThreadPoolExecutor(2), ProcessPoolExecutor(2, get_context("spawn"))):
        with pool:
            found.append(study.run(train, grid, seeds=9, block=2, executor=pool))
    assert same(found[0], found[1])
    assert same(found[0], found[2])
    assert same(found[0], study.run(train, grid, seeds=9, block=2))


@pytest.mark.parametrize("block", [1, 4, 100])
def test_tables_are_the_same_whatever_the_block(block):
    assert same(
        study.run(study.train_tables, TABLES, seeds=9, block=block), study.run(study.train_tables, TABLES, seeds=9)
    )


def test_networks_of_one_process_take_turns(monkeypatch):
    """Each puts torch on one thread and back: two at once would leave it as the other found it."""
    at_work, most, train = [], [], DQNAgent.train

    def watched(agent, *arguments, **keywords):
        at_work.append(agent)
        most.append(len(at_work))
        time.sleep(0.02)
        history = train(agent, *arguments, **keywords)
        at_work.pop()
        return history

    monkeypatch.setattr(DQNAgent, "train", watched)
    with ThreadPoolExecutor(3) as pool:
        study.run(study.train_networks, NETWORKS, seeds=6, block=1, executor=pool)
    assert len(most) == 12
    assert max(most) == 1


def test_torch_keeps_its_number_of_threads():
    torch.set_num_threads(2)
    study.run(study.train_networks, NETWORKS, seeds=4, block=1)
    assert torch.get_num_threads() == 2


# --- failures and interruptions ---------------------------------------------------------------------------------------


def test_a_failing_cell_names_its_settings_and_its_seed():
    with pytest.raises(
        study.CellFailed, match=r"bad = \[3\], seed 3: ZeroDivisionError: one division too many"
    ) as found:
        study.run(fails, {"bad": [[3]]}, seeds=6)
    assert isinstance(found.value.__cause__, ZeroDivisionError)


def test_so_it_does_from_another_process():
    with ProcessPoolExecutor(1) as pool, pytest.raises(study.CellFailed, match="seed 3: ZeroDivisionError: one div"):
        study.run(fails, {}, seeds=6, executor=pool)


@pytest.mark.parametrize("kind", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_without_a_folder_a_failure_stops_the_study(tmp_path, kind):
    with kind(1) as pool, pytest.raises(study.CellFailed):
        study.run(fails, {"log": str(tmp_path), "pause": 0.01}, seeds=200, block=1, executor=pool)
    assert len(list(tmp_path.iterdir())) < 150


def test_with_a_folder_the_others_are_finished_first(tmp_path):
    (tmp_path / "log").mkdir()
    grid = {"bad": [[3, 7]], "log": str(tmp_path / "log")}
    with pytest.raises(study.CellFailed, match="seed 3: Zero") as found:
        study.run(fails, grid, seeds=10, block=1, folder=tmp_path / "cells")
    assert "1 more of 10 cells failed" in found.value.__notes__[0]
    assert len(list((tmp_path / "cells").iterdir())) == 8


def test_a_process_that_ends_breaks_the_study_with_one_clear_error(tmp_path):
    with (
        ProcessPoolExecutor(1) as pool,
        pytest.raises(RuntimeError, match="the executor broke: a process ended"),
    ):
        study.run(ends_its_process, {"parent": os.getpid()}, seeds=4, block=1, executor=pool, folder=tmp_path)
    results = study.run(ends_its_process, {"parent": os.getpid()}, seeds=4, block=1, folder=tmp_path)
    assert results.measures["number"].tolist() == [[0, 1, 2, 3]]


def test_a_pool_that_is_broken_already_gives_the_same_error():
    with ProcessPoolExecutor(1) as pool:
        pool.submit(os._exit, 9).exception()
        with pytest.raises(RuntimeError, match="the executor broke: a process ended"):
            study.run(drawn, {}, seeds=4, executor=pool)


def interrupt_soon(path, count):
    """Ctrl-C for this process once the folder holds so many files."""

    def wait():
        while not path.is_dir() or len(list(path.glob("cell-*"))) < count:
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=wait, daemon=True).start()


def test_ctrl_c_keeps_what_is_finished_and_the_same_call_goes_on(tmp_path):
    interrupt_soon(tmp_path, 3)
    with pytest.raises(KeyboardInterrupt):
        study.run(slow, {"pause": [0.05]}, seeds=400, block=1, folder=tmp_path)
    kept = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("cell-*")}
    assert 3 <= len(kept) < 300
    time.sleep(0.3)
    assert len(list(tmp_path.iterdir())) == len(kept), "nobody goes on working"
    results = study.run(slow, {"pause": [0.05]}, seeds=30, block=1, folder=tmp_path)
    assert same(results, study.run(slow, {"pause": [0.05]}, seeds=30, block=30))
    assert all((tmp_path / name).stat().st_mtime_ns == time for name, time in kept.items())


def test_interrupted_threads_give_up_after_the_agent_they_are_at(tmp_path):
    for name in ("log", "cells"):
        (tmp_path / name).mkdir()

    def one(seed, log):
        (log_folder := tmp_path / log).joinpath(str(seed)).touch()
        if seed == 2:
            os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.05)
        return {"files": len(list(log_folder.iterdir()))}

    with pytest.raises(KeyboardInterrupt):
        study.run(one, {"log": "log"}, seeds=100, block=100)
    time.sleep(0.4)
    assert len(list((tmp_path / "log").iterdir())) < 10


def test_an_interrupted_study_does_not_wait_for_long_training():
    asked = []

    def interrupt():
        asked.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(0.5, interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        study.run(slow, {"pause": 4.0}, seeds=2, block=1)
    assert time.perf_counter() - asked[0] < 3


def test_it_shows_a_bar_when_asked(capsys):
    study.run(drawn, {}, seeds=4)
    assert capsys.readouterr().err == ""
    with ThreadPoolExecutor(1) as pool:
        study.run(slow, {"pause": 0.15}, seeds=4, block=1, executor=pool, progress=True)
    shown = capsys.readouterr().err
    assert "2/4" in shown
    assert "agent" in shown
