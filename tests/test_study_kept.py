"""Finished cells on disk: what is read again, what is trained anew, and a study that is killed and goes on."""

import importlib
import json
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
from study_worlds import NETWORKS, TABLES, drawn, fails, of_sets, same, slow_tables

from course_lib import study
from course_lib.files import load_arrays, save_arrays

HERE = Path(__file__).parent


def files_in(folder):
    """{name: when it was written} of the finished cells."""
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("cell-*.safetensors")}


def counted(folder, **settings):
    """How many seeds a study of `fails` trains anew, seeds 0 to 5 by twos, and its results."""
    log = folder.parent / "log"
    log.mkdir(exist_ok=True)
    for path in log.iterdir():
        path.unlink()
    results = study.run(fails, {"bad": [[]], "log": str(log)} | settings, seeds=6, block=2, folder=folder)
    return len(list(log.iterdir())), results


# --- read again, or trained anew --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("train", "grid"), [(study.train_tables, TABLES), (study.train_networks, NETWORKS)])
def test_what_is_read_is_what_was_found(tmp_path, train, grid):
    first = study.run(train, grid, seeds=5, block=2, folder=tmp_path / "deep" / "cells")
    files = files_in(tmp_path / "deep" / "cells")
    again = study.run(train, grid, seeds=5, block=2, folder=str(tmp_path / "deep" / "cells"))
    assert same(first, again)
    assert list(again.measures) == list(first.measures)
    assert same(first, study.run(train, grid, seeds=5, block=2))
    assert files_in(tmp_path / "deep" / "cells") == files


def test_nothing_finished_is_trained_again(tmp_path):
    assert counted(tmp_path / "cells")[0] == 6
    assert counted(tmp_path / "cells")[0] == 0


def test_a_grid_may_grow(tmp_path):
    study.run(drawn, {"scale": [1, 2]}, seeds=4, block=2, folder=tmp_path)
    files = files_in(tmp_path)
    results = study.run(drawn, {"scale": [3, 2, 1]}, seeds=6, block=2, folder=tmp_path)
    assert {name: files_in(tmp_path)[name] for name in files} == files
    assert len(files_in(tmp_path)) == 9
    assert same(results, study.run(drawn, {"scale": [3, 2, 1]}, seeds=6))


@pytest.mark.parametrize("change", [{"scale": 2}, {"scale": 1.0}, {"scale": True}, {"size": 3}])
def test_other_settings_are_another_cell(tmp_path, change):
    study.run(drawn, {"scale": 1}, seeds=2, folder=tmp_path)
    results = study.run(drawn, {"scale": 1} | change, seeds=2, folder=tmp_path)
    assert len(files_in(tmp_path)) == 2
    assert same(results, study.run(drawn, {"scale": 1} | change, seeds=2))


def test_so_are_other_seeds_another_function_and_another_version(tmp_path, monkeypatch):
    def first(seed):
        return {"x": seed}

    old = first

    def first(seed):
        return {"x": seed + 1}

    assert old.__qualname__ == first.__qualname__
    assert study.run(old, {}, seeds=2, folder=tmp_path).measures["x"].tolist() == [[0, 1]]
    assert study.run(first, {}, seeds=2, folder=tmp_path).measures["x"].tolist() == [[1, 2]]
    assert study.run(first, {}, seeds=[1, 0], folder=tmp_path).measures["x"].tolist() == [[2, 1]]
    assert len(files_in(tmp_path)) == 3
    monkeypatch.setattr("course_lib.__version__", "0.0.0")
    study.run(first, {}, seeds=2, folder=tmp_path)
    monkeypatch.setattr("course_lib.study.kept._FORMAT", 2)
    study.run(first, {}, seeds=2, folder=tmp_path)
    assert len(files_in(tmp_path)) == 5


def test_a_function_without_its_text_is_known_by_what_it_does(tmp_path):
    functions = {}
    for name, body in (("a", "{'x': seed}"), ("b", "{'x': seed * 3}"), ("c", "{'x': seed}")):
        exec(f"def train(seed):\n    inner = lambda: 0\n    return {body}", functions)
        functions[name] = functions.pop("train")
    for name, expected in (("a", [0, 1]), ("b", [0, 3]), ("c", [0, 1])):
        assert study.run(functions[name], {}, seeds=2, folder=tmp_path).measures["x"].tolist() == [expected]
    assert len(files_in(tmp_path)) == 2


def of_a_factory(factor, inner=None):
    """Functions of one text."""

    def train(seed):
        return {"x": factor * seed, "y": sum(factor for _ in range(seed)) + bool(inner)}

    return train


def test_two_functions_of_one_factory_are_two(tmp_path):
    for factor in (1, 3, 1.0, 1):
        results = study.run(of_a_factory(factor), {}, seeds=3, folder=tmp_path)
        assert results.measures["x"].tolist() == [[0, factor, 2 * factor]]
    assert len(files_in(tmp_path)) == 3
    for _ in range(2):  # an object has no text but its address, by which it would never be found again
        study.run(of_a_factory(1, inner=object()), {}, seeds=3, folder=tmp_path)
        assert len(files_in(tmp_path)) == 4


FACTOR, PARTS = 2, {"a": [1]}


def of_globals(seed):
    return {"x": FACTOR * seed + sum(part for part in PARTS["a"])}


def test_what_a_function_reads_outside_is_noticed(tmp_path, monkeypatch):
    def found():
        return study.run(of_globals, {}, seeds=2, folder=tmp_path).measures["x"].tolist()

    assert found() == [[1, 3]]
    monkeypatch.setitem(globals(), "FACTOR", 5)
    assert found() == [[1, 6]]
    monkeypatch.setitem(PARTS, "a", [2, 3])
    assert found() == [[5, 10]]
    monkeypatch.setitem(globals(), "HERE", Path("elsewhere"))
    assert found() == [[5, 10]]
    assert len(files_in(tmp_path)) == 3


def test_a_changed_default_is_noticed(tmp_path):
    def train(seed, a=1, *, b=1):
        return {"x": a + b + seed}

    found = []
    for train.__defaults__, train.__kwdefaults__ in (((1,), {"b": 1}), ((2,), {"b": 1}), ((2,), {"b": 9})):
        found.append(study.run(train, {}, seeds=[0], folder=tmp_path).measures["x"].item())
    assert found == [2, 3, 11]


def test_a_file_that_was_edited_but_not_loaded_again_does_not_lend_its_text(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    path = tmp_path / "edited_training.py"
    path.write_text("def train(seed):\n    return {'x': seed}\n")
    module = importlib.import_module("edited_training")
    path.write_text("def train(seed):\n    return {'x': 100 * seed}\n")
    assert study.run(module.train, {}, seeds=2, folder=tmp_path / "cells").measures["x"].tolist() == [[0, 1]]
    importlib.reload(module)
    assert study.run(module.train, {}, seeds=2, folder=tmp_path / "cells").measures["x"].tolist() == [[0, 100]]
    del sys.modules["edited_training"]


def test_a_function_is_known_again_in_another_process_and_after_use(tmp_path):
    """Sets have another order in each process, and code that is warm is optimised by Python itself."""
    code = "import sys; sys.path.insert(0, {!r}); from study_worlds import *; study.run(of_sets, {{}}, folder={!r})"
    for seed in "123":
        done = [sys.executable, "-c", code.format(str(HERE), str(tmp_path))]
        subprocess.run(done, env=os.environ | {"PYTHONHASHSEED": seed}, check=True, timeout=60)
    assert len(files_in(tmp_path)) == 1
    for i in range(2000):
        of_sets(i)
    study.run(of_sets, {}, folder=tmp_path)
    assert len(files_in(tmp_path)) == 1


# --- damaged and foreign files ----------------------------------------------------------------------------------------


def cut(path):
    path.write_bytes(path.read_bytes()[:-9])


def flip(path):
    content = bytearray(path.read_bytes())
    content[12] ^= 255
    path.write_bytes(content)


def another_cell(path):
    others = [other for other in path.parent.iterdir() if other != path]
    path.write_bytes(others[0].read_bytes())


def pickled(path):
    path.write_bytes(pickle.dumps({"x": 1}))


def rewrite(change):
    """A damage: the file's arrays and settings, changed, in its own format."""

    def damage(path):
        arrays, told = load_arrays(path, kind="study cell")
        arrays, told = change(arrays, told)
        save_arrays(path, arrays, told, kind="study cell")

    return damage


def read(path):
    """What a cell's file says, for comparison; None where it cannot be read."""
    try:
        arrays, told = load_arrays(path, kind="study cell")
    except ValueError:
        return None
    return {name: (str(array.dtype), array.tolist()) for name, array in arrays.items()}, told


DAMAGES = {
    "empty": lambda path: path.write_bytes(b""),
    "cut": cut,
    "flipped": flip,
    "another cell": another_cell,
    "pickled": pickled,
    "foreign": lambda path: path.write_bytes(safetensors.numpy.save({"number": np.zeros(2)})),
    "another kind": lambda path: save_arrays(path, {"number": np.zeros(2)}, {}, kind="QAgent"),
    "an agent fewer": rewrite(lambda arrays, told: ({"number": arrays["number"][:1]}, told)),
    "whole numbers": rewrite(lambda arrays, told: ({"number": arrays["number"].astype(int)}, told)),
    "no arrays": rewrite(lambda _, told: ({}, told)),
    "another array": rewrite(lambda arrays, told: (arrays | {"more": arrays["number"]}, told)),
    "other names": rewrite(lambda arrays, told: (arrays, told | {"names": ["numbers"]})),
    "no names": rewrite(lambda arrays, told: (arrays, {"cell": told["cell"]})),
    "a list": rewrite(lambda arrays, told: (arrays, [told])),
    "nothing told": rewrite(lambda arrays, _: (arrays, None)),
    "other seeds told": rewrite(lambda arrays, told: (arrays, told | {"cell": told["cell"] | {"seeds": [8, 9]}})),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES.keys())
def test_a_damaged_or_foreign_file_is_trained_anew_and_replaced(tmp_path, damage):
    _, first = counted(tmp_path / "cells")
    path = sorted((tmp_path / "cells").iterdir())[1]
    content = read(path)
    damage(path)
    assert read(path) != content
    trained, again = counted(tmp_path / "cells")
    assert trained == 2
    assert same(first, again)
    assert read(path) == content


def test_files_that_are_not_ours_are_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "cell-1.safetensors").write_text("mine too")
    (tmp_path / "cell-2.safetensors.0a1b2c3d.part").write_text("left by a process that was killed")
    study.run(drawn, {}, seeds=2, folder=tmp_path)
    assert sorted(path.read_text() for path in tmp_path.iterdir() if path.stat().st_size < 50) == [
        "left by a process that was killed", "mine", "mine too"
    ]  # fmt: skip


def test_files_hold_arrays_and_json_alone(tmp_path):
    study.run(drawn, {"scale": 2.5}, seeds=3, folder=tmp_path)
    (path,) = tmp_path.iterdir()
    arrays, told = load_arrays(path, kind="study cell")
    assert {name: array.shape for name, array in arrays.items()} == {"number": (3,), "curve": (3, 3)}
    assert told["cell"]["settings"] == {"scale": 2.5}
    assert told["cell"]["seeds"] == [0, 1, 2]
    assert told["cell"]["function"] == "study_worlds.drawn"
    assert json.loads(json.dumps(told)) == told


def test_a_folder_that_cannot_be_made_is_refused_before_anything_is_trained(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "cells"):
        with pytest.raises(ValueError, match="folder must be one that can be made"):
            study.run(fails, {"log": "/nowhere"}, folder=folder)


# --- killed, and gone on ----------------------------------------------------------------------------------------------

PROGRAM = """
import sys
sys.path.insert(0, {tests!r})
from study_worlds import TABLES, slow_tables
from course_lib import study
study.run(slow_tables, TABLES | {{"pause": {pause}}}, seeds=40, block=2, folder={folder!r})
"""


def start(folder, pause):
    """A study in a process of its own: 80 cells."""
    code = PROGRAM.format(tests=str(HERE), folder=str(folder), pause=pause)
    return subprocess.Popen([sys.executable, "-c", code])


def wait_for(folder, count, process):
    deadline = time.monotonic() + 60
    while not folder.is_dir() or len(files_in(folder)) < count:
        assert process.poll() is None, "it ended by itself"
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.fixture(scope="module")
def undisturbed():
    with ThreadPoolExecutor(1) as pool:
        return study.run(slow_tables, TABLES | {"pause": 0.0}, seeds=40, block=2, executor=pool)


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is POSIX's")
def test_after_a_kill_the_same_call_goes_on_to_the_same_result(tmp_path, undisturbed):
    process = start(tmp_path / "cells", pause=0.1)
    wait_for(tmp_path / "cells", 12, process)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    kept = files_in(tmp_path / "cells")
    assert 12 <= len(kept) < 80
    results = study.run(slow_tables, TABLES | {"pause": 0.1}, seeds=40, block=2, folder=tmp_path / "cells")
    assert {name: files_in(tmp_path / "cells")[name] for name in kept} == kept
    assert len(files_in(tmp_path / "cells")) == 80
    assert results.measures.keys() == undisturbed.measures.keys()
    for name, found in results.measures.items():
        assert found.tobytes() == undisturbed.measures[name].tobytes()
    for label, runs in results.curves["episode_return"].items():
        assert runs.tobytes() == undisturbed.curves["episode_return"][label].tobytes()


def test_two_processes_in_one_folder_do_not_disturb_each_other(tmp_path, undisturbed):
    processes = [start(tmp_path / "cells", pause=0.01) for _ in range(2)]
    assert [process.wait(timeout=120) for process in processes] == [0, 0]
    files = files_in(tmp_path / "cells")
    assert len(files) == len(list((tmp_path / "cells").iterdir())) == 80
    results = study.run(slow_tables, TABLES | {"pause": 0.01}, seeds=40, block=2, folder=tmp_path / "cells")
    assert files_in(tmp_path / "cells") == files
    for name, found in results.measures.items():
        assert found.tobytes() == undisturbed.measures[name].tobytes()
