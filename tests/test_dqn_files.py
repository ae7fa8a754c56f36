"""An agent's file is read back whole or refused in one sentence, never run, and takes no more memory than it holds."""

import contextlib
import json
import os
import pickle
import re
import struct
import sys

import numpy as np
import pytest
import safetensors.numpy
from dqn_worlds import SWITCHES, WORLDS, learned
from test_files import Trap, write_safetensors

from course_lib import DQNAgent, Maze, QAgent
from course_lib.files import load_arrays, save_arrays

KINDS = {"few states": "slippery maze", "many states": "large maze", "vectors": "cart pole"}


@pytest.fixture(scope="module")
def contents(tmp_path_factory):
    """The bytes of files of each kind: two agents in the middle of an episode, with half a memory and a full one."""
    folder, files = tmp_path_factory.mktemp("agents"), {}
    for kind, world in KINDS.items():
        for steps in (26, 90):
            agent = DQNAgent(WORLDS[world](), num_agents=2, **SWITCHES["everything"])
            agent.train(num_steps=steps)
            assert agent._underway.steps.max() > 0
            agent.save(folder / "agent")
            files[kind, steps] = (folder / "agent").read_bytes()
    return files


@pytest.fixture(params=KINDS)
def kind(request):
    return request.param


@pytest.fixture
def saved(contents, kind, tmp_path):
    """The path of trained agents' file."""
    (tmp_path / "agent").write_bytes(contents[kind, 90])
    return tmp_path / "agent"


@pytest.fixture
def maze_saved(contents, tmp_path):
    (tmp_path / "agent").write_bytes(contents["few states", 26])
    return tmp_path / "agent"


def refused(path, env=None):
    """The one error that loading `path` gives; it names the file, in one line."""
    with pytest.raises(ValueError, match=re.escape(str(path))) as error:
        DQNAgent.load(path, env or Maze(slip=0.2))
    assert error.value.__context__ is None or error.value.__suppress_context__, "one error, without the ones behind it"
    assert "\n" not in str(error.value)
    return str(error.value).replace(str(path), "")


def taken_or_refused(path, env):
    """The agent, or None where the file is refused as it should be."""
    with contextlib.suppress(ValueError):
        return DQNAgent.load(path, env)
    refused(path, env)
    return None


def rewritten(path, *, arrays=None, agent=None, **settings):
    """The file at `path` with some of its arrays, of its agent's settings or of its other settings replaced.

    None leaves one out; a function is asked what becomes of the old one.
    """
    old_arrays, old_settings = load_arrays(path, kind="DQNAgent")
    old_settings["agent"] = changed(old_settings["agent"], agent or {})
    save_arrays(path, changed(old_arrays, arrays or {}), changed(old_settings, settings), kind="DQNAgent")


def changed(old, new):
    asked = {name: value(old[name]) if callable(value) else value for name, value in new.items()}
    return {name: value for name, value in (old | asked).items() if value is not None}


# --- damaged and foreign files ----------------------------------------------------------------------------------------


def test_a_file_cut_short_anywhere_is_refused(saved, kind):
    content, env = saved.read_bytes(), WORLDS[KINDS[kind]]()
    for length in [0, 1, 7, 8, 9, *range(50, len(content), 250), len(content) - 1]:
        saved.write_bytes(content[:length])
        assert "is not a saved DQNAgent" in refused(saved, env)


def test_a_file_with_something_at_its_end_is_refused(saved, kind):
    saved.write_bytes(saved.read_bytes() + b"\0")
    assert "is not a saved DQNAgent" in refused(saved, WORLDS[KINDS[kind]]())


def test_a_changed_byte_in_the_head_is_refused_or_harmless(saved, kind):
    """What is taken all the same can be trained with."""
    content, rng, env = saved.read_bytes(), np.random.default_rng(0), WORLDS[KINDS[kind]]()
    head, refusals = 8 + struct.unpack("<Q", content[:8])[0], 0
    for place in [*range(8), *rng.integers(8, head, 250)]:
        damaged = bytearray(content)
        damaged[place] = rng.integers(256)
        saved.write_bytes(damaged)
        agent = taken_or_refused(saved, env)
        refusals += agent is None
        if agent is not None:
            agent.train(num_steps=2)
    assert refusals > 200


def test_a_changed_byte_in_the_numbers_is_refused_or_harmless(saved, kind):
    content, rng, env = saved.read_bytes(), np.random.default_rng(1), WORLDS[KINDS[kind]]()
    head, refusals = 8 + struct.unpack("<Q", content[:8])[0], 0
    for place in rng.integers(head, len(content), 150):
        damaged = bytearray(content)
        damaged[place] ^= 1 << rng.integers(8)
        saved.write_bytes(damaged)
        agent = taken_or_refused(saved, env)
        refusals += agent is None
        if agent is not None:
            agent.train(num_steps=2)
    assert 0 < refusals < 150


@pytest.mark.parametrize(
    "content", [b"", b"{}", b'{"weights": [[0.0]]}', b"\x93NUMPY", b"PK\x03\x04", b"\0" * 1000, b"\xff" * 1000]
)
def test_a_file_of_another_format_is_refused(content, tmp_path):
    (tmp_path / "agent").write_bytes(content)
    assert "damaged, cut short or of another format" in refused(tmp_path / "agent")


def test_a_pickle_is_refused_and_not_run(maze_saved, tmp_path):
    mark = tmp_path / "mark"
    trap = pickle.dumps(Trap(mark))
    pickle.loads(trap)  # noqa: S301 (the trap does work)
    assert mark.exists()
    mark.unlink()
    (tmp_path / "pickled").write_bytes(trap)
    np.save(tmp_path / "pickled.npy", np.array([Trap(mark)]), allow_pickle=True)
    rewritten(maze_saved, agent={"hidden": trap.hex()}, generators=[trap.hex()] * 2)
    for path in (tmp_path / "pickled", tmp_path / "pickled.npy", maze_saved):
        refused(path)
    assert not mark.exists()


def test_arrays_that_somebody_else_saved_are_refused(maze_saved):
    arrays = load_arrays(maze_saved, kind="DQNAgent")[0]
    safetensors.numpy.save_file(arrays, maze_saved)
    assert "holds 'something else'" in refused(maze_saved)


@pytest.mark.parametrize(("dtype", "size"), [("BF16", 2), ("F8_E4M3", 1)])
def test_arrays_that_numpy_has_no_kind_for_are_refused(dtype, size, tmp_path):
    head = {"__metadata__": {"course_lib": "DQNAgent", "settings": "{}"}}
    head |= {"weights": {"dtype": dtype, "shape": [3], "data_offsets": [0, 3 * size]}}
    write_safetensors(tmp_path / "agent", head, b"\0" * 3 * size)
    assert "is not a saved DQNAgent" in refused(tmp_path / "agent")


def test_an_agent_of_another_kind_is_refused_by_its_name(tmp_path):
    QAgent(Maze()).save(tmp_path / "agent")
    assert "holds 'QAgent'" in refused(tmp_path / "agent")


def test_settings_nested_without_end_are_refused(tmp_path):
    head = {"__metadata__": {"course_lib": "DQNAgent", "settings": "[" * 100_000}}
    write_safetensors(tmp_path / "agent", head)
    assert "is not a saved DQNAgent" in refused(tmp_path / "agent")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no file .*nowhere"):
        DQNAgent.load(tmp_path / "nowhere", Maze())


def test_saving_where_nothing_can_be_saved_says_so_and_leaves_nothing(tmp_path):
    (tmp_path / "file").write_text("mine")
    for path, words in ((tmp_path, "is a folder"), (tmp_path / "file" / "agent", "no folder .*file")):
        with pytest.raises(ValueError, match=words):
            DQNAgent(Maze()).save(path)
    assert os.listdir(tmp_path) == ["file"]


# --- arrays -----------------------------------------------------------------------------------------------------------


def with_first(value):
    """A damage: the first number of an array is another."""

    def damage(array):
        damaged = array.copy()
        damaged.reshape(-1)[0] = value
        return damaged

    return damage


ANY = {
    "missing": lambda array: None,  # noqa: ARG005
    "of another shape": lambda array: array[..., None],
    "with an agent too few": lambda array: array[:1],
    "with an agent too many": lambda array: np.concatenate([array, array[:1]]),
    "of another kind": lambda array: array.astype(np.float16 if array.dtype == np.float32 else np.float32),
    "as text would be": lambda array: array.view(np.uint8),
}


def test_an_array_of_any_wrong_form_is_refused(saved, kind):
    """Every array that is in the file, none forgotten; and NaN or infinity in those that could hold it."""
    content, env = saved.read_bytes(), WORLDS[KINDS[kind]]()
    arrays, _ = load_arrays(saved, kind="DQNAgent")
    assert len(arrays) == len(learned(DQNAgent.load(saved, env))) - 1, "all but the generators"
    for name, array in arrays.items():
        damages = dict(ANY)
        if array.dtype.kind == "f":
            damages |= {str(value): with_first(value) for value in (np.nan, np.inf, -np.inf)}
        for words, damage in damages.items():
            saved.write_bytes(content)
            rewritten(saved, arrays={name: damage})
            assert name in refused(saved, env), words


OUT_OF_RANGE = [
    ("epsilon", -0.1), ("epsilon", 1.1), ("updates", -1), ("episode", -1), ("steps", -1), ("count", -1),
    ("second", -1e-9), ("actions", -1), ("discount", -0.1), ("discount", 1.1),
]  # fmt: skip
OF_KIND = {
    "few states": [("actions", 4), ("entry", -1), ("entry", 64), ("next_state", -1), ("next_state", 16)],
    "many states": [
        ("actions", 4), ("action", 4), ("observation", 72), ("next_observation", 72), ("observation", -1),
    ],
    "vectors": [("actions", 2), ("action", 2), ("action", -1)],
}  # fmt: skip


@pytest.mark.parametrize(("name", "value", "words"), [("steps", 10**12, "actions"), ("count", 1, "reward")])
def test_a_count_that_does_not_go_with_what_was_counted_is_refused(name, value, words, maze_saved):
    rewritten(maze_saved, arrays={name: lambda array: np.full_like(array, value)})
    assert f"{words} must be" in refused(maze_saved)


def test_a_number_out_of_range_is_refused(contents, kind, tmp_path):
    env, path = WORLDS[KINDS[kind]](), tmp_path / "agent"
    for name, value in OUT_OF_RANGE + OF_KIND[kind]:
        path.write_bytes(contents[kind, 26])
        rewritten(path, arrays={name: lambda array, value=value: np.full_like(array, value)})
        assert f"{name} must be from" in refused(path, env)


def test_a_file_that_says_it_holds_more_than_it_does_is_refused(saved, kind):
    """Shapes and places in the head that go beyond the file, or beyond any memory."""
    content, env = saved.read_bytes(), WORLDS[KINDS[kind]]()
    size = struct.unpack("<Q", content[:8])[0]
    head, data = json.loads(content[8 : 8 + size]), content[8 + size :]
    for name in head.keys() - {"__metadata__"}:
        for change in (
            {"shape": [2, 2**60]},
            {"shape": [2**33, 2**33]},
            {"data_offsets": [0, 2**60]},
            {"shape": [2, 2**40], "data_offsets": [0, 2**43]},
            {"shape": [0]},
        ):
            write_safetensors(saved, head | {name: head[name] | change}, data)
            assert "is not a saved DQNAgent" in refused(saved, env)


# --- settings ---------------------------------------------------------------------------------------------------------

WRONG = [None, -1, 2.5, float("nan"), float("inf"), 10**30, "x", [], [[]], {}, {"a": 1}, [-1], [2.5], ["x"]]
FITTING = {  # what can be meant, and sizes, which come below
    "seed": [10**30], "learning_rate": [2.5, 10**30], "learning_starts": [None, 10**30],
    "double": WRONG[1:], "mask_terminal": WRONG[1:], "mask_actions": WRONG, "replay": [10**30], "batch_size": [10**30],
}  # fmt: skip


def test_a_setting_that_is_missing_or_cannot_be_meant_is_refused(maze_saved):
    content = maze_saved.read_bytes()
    names = load_arrays(maze_saved, kind="DQNAgent")[1]["agent"].keys()
    assert len(names) == 13
    for name in names:
        for value in WRONG:
            if value not in FITTING.get(name, []):
                maze_saved.write_bytes(content)
                rewritten(maze_saved, agent={name: value})
                assert name in refused(maze_saved) or name in ("num_agents", "hidden"), value


@pytest.mark.parametrize("wrong", [None, 5, "x", [], {}, [1, 2], [[], []], [{}, {}], {"agent": 1}], ids=repr)
@pytest.mark.parametrize("name", ["agent", "sizes", "generators"])
def test_a_part_of_the_settings_that_is_missing_or_of_another_form_is_refused(name, wrong, maze_saved):
    settings = load_arrays(maze_saved, kind="DQNAgent")[1] | {name: wrong}
    arrays = load_arrays(maze_saved, kind="DQNAgent")[0]
    for left in (settings, {key: value for key, value in settings.items() if key != name}, wrong):
        save_arrays(maze_saved, arrays, left, kind="DQNAgent")
        refused(maze_saved)


GENERATOR = {"bit_generator": "PCG64", "state": {"state": 1, "inc": 1}, "has_uint32": 0, "uinteger": 0}


@pytest.mark.parametrize(
    "wrong",
    [
        None, 5, "PCG64", {}, {"bit_generator": "PCG64"}, GENERATOR | {"bit_generator": "MT19937"},
        GENERATOR | {"state": None}, GENERATOR | {"state": 5}, GENERATOR | {"state": {}},
        GENERATOR | {"state": {"state": "x", "inc": 1}},
        GENERATOR | {"state": {"state": 2**1000, "inc": -1}}, GENERATOR | {"has_uint32": "x"},
        GENERATOR | {"uinteger": 2**100}, {"bit_generator": "MT19937", "state": {"key": [1, 2], "pos": 0}},
    ],
    ids=str,
)  # fmt: skip
def test_a_generator_in_a_state_there_is_none_of_is_refused(wrong, maze_saved):
    rewritten(maze_saved, generators=lambda states: [states[0], wrong])
    refused(maze_saved)


@pytest.mark.parametrize("name", ["num_agents", "hidden", "replay", "batch_size", "sizes"])
@pytest.mark.parametrize("size", [10**7, 10**12, 2**62, 2**63, 10**30])
@pytest.mark.skipif(sys.platform != "linux", reason="a process's largest size as Linux tells it")
def test_a_size_beyond_all_memory_is_refused_or_takes_none(name, size, maze_saved):
    """A large memory may well be meant, with little in it: then there is room for it, and it is not yet filled."""
    import resource

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    agent = {"hidden": [size] if name == "hidden" else [12, 9], "num_agents": size if name == "num_agents" else 2}
    agent |= {"replay": size} if name in ("replay", "batch_size") else {}
    agent |= {"batch_size": size} if name == "batch_size" else {}
    sizes = [16, size, 4] if name in ("hidden", "sizes") else [16, 12, 9, 4]
    rewritten(maze_saved, agent=agent, sizes=sizes)
    loaded = taken_or_refused(maze_saved, Maze(slip=0.2))
    assert loaded is None or (loaded.replay == size <= 10**12 and name in ("replay", "batch_size"))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000, "KiB"


def test_networks_for_another_world_are_refused_with_both_shapes(contents, tmp_path):
    path = tmp_path / "agent"
    for kind, own in (("few states", 16), ("many states", 72), ("vectors", 4)):
        path.write_bytes(contents[kind, 90])
        message = refused(path, Maze.random(3, 5))
        assert f"({own}, 12, 9, {2 if kind == 'vectors' else 4})" in message
        assert "(15, 12, 9, 4)" in message


def test_a_world_or_a_device_that_no_agent_could_have_is_refused_too(maze_saved):
    for env in (None, "nope-v0", "Pendulum-v1", "Blackjack-v1"):
        with pytest.raises(ValueError, match=r"^[^\n]+$"):
            DQNAgent.load(maze_saved, env)
    with pytest.raises(ValueError, match="device must be one"):
        DQNAgent.load(maze_saved, Maze(), device="nonsense")
