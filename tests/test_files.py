"""Save files: read back whole, refused when anything is wrong with them, never run, never half written."""

import json
import os
import pickle
import re
import stat
import struct
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy

from course_lib import Maze, QAgent
from course_lib.files import load_arrays, save_arrays


@pytest.fixture
def saved(tmp_path):
    """The path of a trained agent's file."""
    agent = QAgent(Maze(slip=0.2))
    agent.train(10)
    agent.save(tmp_path / "agent")
    return tmp_path / "agent"


def refused(path, env=None):
    """The one error that loading `path` gives; the environment is as it was before."""
    env = env or Maze(slip=0.2)
    env.reset(seed=0)
    env.step(1)
    before = env.unwrapped._state, env.unwrapped.np_random.bit_generator.state
    with pytest.raises(ValueError, match=re.escape(str(path))) as error:
        QAgent.load(path, env)
    assert (env.unwrapped._state, env.unwrapped.np_random.bit_generator.state) == before
    assert error.value.__context__ is None or error.value.__suppress_context__, "one error, without the ones behind it"
    return str(error.value)


def write_safetensors(path, header, data=b""):
    """A file of that form from its parts, for headers that no library would write."""
    text = json.dumps(header).encode()
    path.write_bytes(struct.pack("<Q", len(text)) + text + data)


# --- whole files ------------------------------------------------------------------------------------------------------


def test_arrays_and_settings_come_back_as_they_were(tmp_path):
    arrays = {"a": np.random.default_rng(0).normal(size=(3, 4)), "b": np.arange(5), "none": np.zeros((0, 2))}
    settings = {"gamma": 0.1 + 0.2, "seed": 2**100, "names": ["x", None, True]}
    save_arrays(tmp_path / "file", arrays, settings, kind="thing")
    found, found_settings = load_arrays(tmp_path / "file", kind="thing")
    assert found_settings == settings
    assert {name: (array.dtype, array.tolist()) for name, array in found.items()} == {
        name: (array.dtype, array.tolist()) for name, array in arrays.items()
    }


def test_a_path_may_be_text(tmp_path):
    QAgent(Maze()).save(str(tmp_path / "agent"))
    assert QAgent.load(str(tmp_path / "agent"), Maze()).q_table.shape == (16, 4)


def test_saving_again_replaces_the_file(saved):
    agent = QAgent(Maze())
    agent.q_table[:] = 3.0
    agent.save(saved)
    assert (QAgent.load(saved, Maze()).q_table == 3.0).all()
    assert os.listdir(saved.parent) == ["agent"]


@pytest.mark.skipif(os.name != "posix", reason="permissions as POSIX has them")
def test_a_file_may_be_read_by_whoever_may_read_new_files(saved, tmp_path):
    (tmp_path / "plain").write_text("")
    assert stat.S_IMODE(saved.stat().st_mode) == stat.S_IMODE((tmp_path / "plain").stat().st_mode)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no file .*nowhere"):
        QAgent.load(tmp_path / "nowhere", Maze())


# --- damaged and foreign files ----------------------------------------------------------------------------------------


def test_a_file_cut_short_anywhere_is_refused(saved):
    content = saved.read_bytes()
    for length in [0, 1, 7, 8, 9, *range(50, len(content), 50), len(content) - 1]:
        saved.write_bytes(content[:length])
        assert "is not a saved QAgent" in refused(saved)


def test_a_file_with_something_at_its_end_is_refused(saved):
    saved.write_bytes(saved.read_bytes() + b"\0")
    assert "is not a saved QAgent" in refused(saved)


def test_a_changed_byte_in_the_head_is_refused_or_harmless(saved):
    content, rng = saved.read_bytes(), np.random.default_rng(0)
    head = 8 + struct.unpack("<Q", content[:8])[0]
    refusals = 0
    for place in [*range(8), *rng.integers(8, head, 400)]:
        damaged = bytearray(content)
        damaged[place] = rng.integers(256)
        saved.write_bytes(damaged)
        try:
            QAgent.load(saved, Maze(slip=0.2))
        except ValueError:
            refusals += 1
    assert refusals > 200


@pytest.mark.parametrize(
    "content", [b"", b"{}", b'{"q_table": [[0.0]]}', b"\x93NUMPY", b"PK\x03\x04", b"\0" * 1000, b"\xff" * 1000]
)
def test_a_file_of_another_format_is_refused(content, saved):
    saved.write_bytes(content)
    assert "damaged, cut short or of another format" in refused(saved)


class Trap:
    """Unpickled, it leaves a mark."""

    def __init__(self, mark):
        self.mark = mark

    def __reduce__(self):
        return Path.touch, (self.mark,)


def test_a_pickle_is_refused_and_not_run(saved, tmp_path):
    mark = tmp_path / "mark"
    trap = pickle.dumps(Trap(mark))
    pickle.loads(trap)  # noqa: S301 (the trap does work)
    assert mark.exists()
    mark.unlink()
    saved.write_bytes(trap)
    assert "is not a saved QAgent" in refused(saved)
    np.save(saved.with_suffix(".npy"), np.array([Trap(mark)]), allow_pickle=True)
    assert "is not a saved QAgent" in refused(saved.with_suffix(".npy"))
    assert not mark.exists()


def test_arrays_that_somebody_else_saved_are_refused(saved):
    safetensors.numpy.save_file({"q_table": np.zeros((16, 4)), "visits": np.zeros((16, 4), np.int64)}, saved)
    assert "holds 'something else'" in refused(saved)


@pytest.mark.parametrize(
    "told", [{}, {"__metadata__": {"course_lib": "QAgent", "settings": "{}"}}], ids=["foreign", "ours"]
)
@pytest.mark.parametrize(("dtype", "size"), [("BF16", 2), ("F8_E4M3", 1)])
def test_arrays_that_numpy_has_no_kind_for_are_refused(dtype, size, told, saved):
    array = {"q_table": {"dtype": dtype, "shape": [3], "data_offsets": [0, 3 * size]}}
    write_safetensors(saved, told | array, b"\0" * 3 * size)
    assert "is not a saved QAgent" in refused(saved)


def test_an_agent_of_another_kind_is_refused_by_its_name(saved):
    save_arrays(saved, {"q_table": np.zeros((16, 4))}, {}, kind="DQNAgent")
    assert "holds 'DQNAgent'" in refused(saved)


def rewritten(path, *, arrays=None, settings=None):
    """The file at `path` with some of its arrays or settings replaced; None leaves one out."""
    old_arrays, old_settings = load_arrays(path, kind="QAgent")
    old_arrays |= arrays or {}
    old_settings |= settings or {}
    save_arrays(
        path,
        {name: array for name, array in old_arrays.items() if array is not None},
        {name: value for name, value in old_settings.items() if value is not None},
        kind="QAgent",
    )


PCG64 = {"bit_generator": "PCG64", "has_uint32": 0, "uinteger": 0}
AGENT = {"gamma": 0.9, "alpha": 0.1, "epsilon": 0.1, "epsilon_decay": 1.0, "alpha_power": 0.0, "seed": 0}


@pytest.mark.parametrize(
    "changes",
    [
        {"arrays": {"q_table": None}},
        {"arrays": {"visits": None}},
        {"arrays": {"q_table": np.full((16, 4), np.nan)}},
        {"arrays": {"visits": np.zeros((4, 16), np.int64)}},
        {"settings": {"agent": None}},
        {"settings": {"agent": {}}},
        {"settings": {"agent": [1, 2]}},
        {"settings": {"agent": "gamma"}},
        {"settings": {"rng": None}},
        {"settings": {"rng": 5}},
        {"settings": {"rng": {}}},
        {"settings": {"rng": {"bit_generator": "PCG64"}}},
        {"settings": {"env_rng": {"bit_generator": "MT19937", "state": {"key": [1, 2], "pos": 0}}}},
        {"settings": {"env_rng": PCG64 | {"state": {"state": "x", "inc": 1}}}},
        {"settings": {"env_rng": PCG64 | {"state": {"state": 2**1000, "inc": -1}}}},
    ],
)
def test_a_file_with_parts_missing_or_wrong_is_refused(changes, saved):
    rewritten(saved, **changes)
    refused(saved)


@pytest.mark.parametrize("name", ["gamma", "alpha", "epsilon", "epsilon_decay", "alpha_power", "seed"])
def test_a_file_with_a_setting_out_of_range_is_refused(name, saved):
    rewritten(saved, settings={"agent": AGENT | {name: -3}})
    with pytest.raises(ValueError, match=f"{name} must"):
        QAgent.load(saved, Maze(slip=0.2))


def test_settings_nested_without_end_are_refused(saved):
    write_safetensors(saved, {"__metadata__": {"course_lib": "QAgent", "settings": "[" * 100_000}})
    assert "is not a saved QAgent" in refused(saved)


def test_a_table_for_another_world_is_refused_with_both_shapes(saved):
    message = refused(saved, Maze.random(3, 5))
    assert "(16, 4)" in message
    assert "(15, 4)" in message


# --- writing ----------------------------------------------------------------------------------------------------------


def test_saving_into_a_folder_that_is_not_there_says_so_and_makes_none(tmp_path):
    with pytest.raises(ValueError, match=r"no folder .*nowhere"):
        QAgent(Maze()).save(tmp_path / "nowhere" / "agent")
    assert os.listdir(tmp_path) == []


def test_saving_to_a_folder_or_below_a_file_says_so_and_leaves_nothing(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(ValueError, match="is a folder"):
        QAgent(Maze()).save(tmp_path)
    with pytest.raises(ValueError, match=r"no folder .*file"):
        QAgent(Maze()).save(tmp_path / "file" / "agent")
    assert os.listdir(tmp_path) == ["file"]
    assert (tmp_path / "file").read_text() == "mine"


def interrupted_in_the_middle(path, content):
    with open(path, "wb") as file:
        file.write(content[: len(content) // 2])
    raise KeyboardInterrupt


def interrupted(*_):
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("place", "name", "stop"),
    [(Path, "write_bytes", interrupted_in_the_middle), (os, "replace", interrupted)],
    ids=["while writing", "before renaming"],
)
def test_an_interrupted_save_leaves_the_old_file_and_nothing_else(place, name, stop, saved, monkeypatch):
    before = saved.read_bytes()
    monkeypatch.setattr(place, name, stop)
    with pytest.raises(KeyboardInterrupt):
        QAgent(Maze()).save(saved)
    monkeypatch.undo()
    assert saved.read_bytes() == before
    assert os.listdir(saved.parent) == ["agent"]
