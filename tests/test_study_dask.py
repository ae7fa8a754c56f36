"""Studies on a cluster: two worker processes of Dask's, one of them killed on the way. Needs the `scale` extra."""

import os
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec

import pytest
from needed import do_without
from study_worlds import NETWORKS, TABLES, drawn, ends_its_process, fails, fails_once, same, slow_tables

from course_lib import study


@pytest.fixture(scope="module")
def cluster():
    """Two workers with a thread each. Without Dask skip; where it is promised (CI), its absence is a failure."""
    if not find_spec("distributed"):
        do_without('needs Dask: pip install -e ".[scale]"', "COURSE_REQUIRE_DASK")
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, scheduler_port=0, silence_logs=50
    ) as cluster:
        yield cluster


@pytest.fixture
def client(cluster):
    from distributed import Client

    with Client(cluster, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
        yield client


@pytest.mark.parametrize(("train", "grid"), [(study.train_tables, TABLES), (study.train_networks, NETWORKS)])
def test_two_worker_processes_find_what_one_thread_finds(client, train, grid):
    with ThreadPoolExecutor(1) as pool:
        here = study.run(train, grid, seeds=9, block=2, executor=pool)
    there = study.run(train, grid, seeds=9, block=2, executor=client.get_executor())
    assert same(here, there)


def test_both_workers_work(client):
    results = study.run(process_at_work, {}, seeds=40, block=1, executor=client.get_executor())
    assert set(results.measures["process"].ravel()) == set(client.run(os.getpid).values())


def process_at_work(seed):
    time.sleep(0.01 + 0 * seed)
    return {"process": os.getpid()}


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is POSIX's")
def test_a_worker_killed_on_the_way_changes_nothing(client, tmp_path):
    victim, other = client.run(os.getpid).values()
    killed_at = []

    def kill():
        while len(list(tmp_path.glob("cell-*"))) < 10:
            time.sleep(0.01)
        os.kill(victim, signal.SIGKILL)
        killed_at.append(len(list(tmp_path.glob("cell-*"))))

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    grid = TABLES | {"pause": 0.05}
    there = study.run(slow_tables, grid, seeds=40, block=2, executor=client.get_executor(), folder=tmp_path)
    killer.join()
    assert 10 <= killed_at[0] < 75, "it was killed in the middle"
    client.wait_for_workers(2, timeout=60)
    after = set(client.run(os.getpid).values())
    assert victim not in after
    assert other in after
    here = study.run(slow_tables, grid, seeds=40, block=20)
    assert same(here, there)


def test_a_failing_cell_is_named_there_too(client):
    with pytest.raises(study.CellFailed, match="seed 3: ZeroDivisionError: one division too many"):
        study.run(fails, {}, seeds=6, block=1, executor=client.get_executor())


@pytest.mark.skipif(os.name != "posix", reason="as processes end there")
def test_a_cell_that_ends_every_worker_is_named_and_the_others_are_kept(client, tmp_path):
    """Dask cannot know which task ended a worker, and may give up one that always stood beside it: then call again."""
    for attempt in range(10):
        with pytest.raises(study.CellFailed, match=r"seed \d: KilledWorker"):
            study.run(ends_its_process, {}, seeds=6, block=1, executor=client.get_executor(pure=False), folder=tmp_path)
        if len(list(tmp_path.glob("cell-*"))) == 5:
            break
    with pytest.raises(study.CellFailed, match="seed 2: KilledWorker"):
        study.run(ends_its_process, {}, seeds=6, block=1, executor=client.get_executor(pure=False), folder=tmp_path)
    assert len(list(tmp_path.glob("cell-*"))) == 5
    client.wait_for_workers(2, timeout=60)


def test_a_function_of_a_notebook_is_refused(client):
    def mine(seed):
        return {"x": seed}

    with pytest.raises(ValueError, match="Put it into a file of its own"):
        study.run(mine, {}, executor=client.get_executor())


def test_a_client_is_no_executor_and_the_error_says_what_is(client):
    with pytest.raises(ValueError, match="executor must be a concurrent"):
        study.run(drawn, {}, executor=client)


def test_an_address_is_the_one_change(cluster):
    with study.workers(cluster.scheduler_address) as there, study.workers() as here:
        assert same(study.run(drawn, {}, executor=there), study.run(drawn, {}, executor=here))


def test_what_failed_once_is_tried_again(cluster, tmp_path):
    grid = {"mark": str(tmp_path / "mark")}
    with study.workers(cluster.scheduler_address) as there:
        with pytest.raises(study.CellFailed, match="seed 4: OSError: not now") as failed:
            study.run(fails_once, grid, seeds=[4], executor=there)
        assert study.run(fails_once, grid, seeds=[4], executor=there).measures["number"].tolist() == [[4]]
        assert failed.value.__cause__


def test_an_address_of_nobody_is_refused():
    dask = pytest.importorskip("dask")
    pytest.importorskip("distributed")

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
        pytest.raises(ValueError, match="address must be that of a Dask scheduler"),
        study.workers("tcp://127.0.0.1:1"),
    ):
        pass
    with pytest.raises(ValueError, match="address must be"), study.workers("nowhere://at all"):
        pass


def test_without_dask_an_address_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ValueError, match=r'needs Dask: pip install -e "\.\[scale\]"'), study.workers("tcp://x:1"):
        pass
