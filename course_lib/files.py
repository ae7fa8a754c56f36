"""Files that cannot run code, written whole or not at all: arrays and plain JSON settings in one safetensors file."""

import json
import os
import secrets
from pathlib import Path

import numpy as np


def save_arrays(path, arrays, settings, *, kind):
    """Write `arrays` {name: array} and `settings` (plain JSON) to `path`, beside it first and then renamed into place.

    `ValueError` where `path` is a folder or in none.
    """
    from safetensors.numpy import save

    write_whole(path, save(arrays, metadata={"course_lib": kind, "settings": json.dumps(settings)}))


def write_whole(path, content):
    """Write the bytes `content` beside `path` and rename them into place: whole or not at all.

    `ValueError` where `path` is a folder or in none.
    """
    path = Path(path)
    if path.is_dir():
        raise ValueError(f"cannot save to {path}: it is a folder")
    if not path.parent.is_dir():
        raise ValueError(f"cannot save to {path}: there is no folder {path.parent}")
    beside = path.with_name(f"{path.name}.{secrets.token_hex(4)}.part")
    try:
        beside.write_bytes(content)
        os.replace(beside, path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


def load_arrays(path, *, kind):
    """(arrays, settings) as `save_arrays` wrote them; `ValueError` for a damaged file or one of another kind.

    Nothing is unpickled or run. A file that is not there raises `FileNotFoundError`.
    """
    from safetensors import SafetensorError, safe_open

    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        with safe_open(path, framework="numpy") as file:
            metadata = file.metadata() or {}
            ours = metadata.get("course_lib") == kind
            arrays = {name: file.get_tensor(name) for name in file.keys()} if ours else {}  # noqa: SIM118 (not a dict)
        settings = json.loads(metadata.get("settings", "null"))
    except (SafetensorError, OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(
            f"{path} is not a saved {kind}: the file is damaged, cut short or of another format ({error})"
        ) from None
    if not ours:
        raise ValueError(f"{path} is not a saved {kind}: it holds {metadata.get('course_lib', 'something else')!r}")
    return arrays, settings


def generator_in(state):
    """The generator in that state, as `bit_generator.state` gave it; `ValueError`, `TypeError`, `KeyError` if wrong."""
    bits = np.random.PCG64()
    bits.state = state
    return np.random.Generator(bits)
