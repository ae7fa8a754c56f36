"""Files that cannot run code: arrays and plain JSON settings in one safetensors file, written whole or not at all."""

import json
import os
import tempfile
from pathlib import Path


def save_arrays(path, arrays, settings, *, kind):
    """Write `arrays` {name: array} and `settings` (plain JSON) to `path`, beside it first and then renamed into place."""
    from safetensors.numpy import save

    path = Path(path)
    content = save(arrays, metadata={"course_lib": kind, "settings": json.dumps(settings)})
    try:
        handle, beside = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".part")
    except FileNotFoundError:
        raise ValueError(f"cannot save to {path}: there is no folder {path.parent}") from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(beside, path)
    except BaseException:
        os.unlink(beside)
        raise


def load_arrays(path, *, kind):
    """(arrays, settings) as `save_arrays` wrote them; `ValueError` for a file that is damaged, cut short or of another kind.

    Nothing is unpickled or run. A file that is not there raises `FileNotFoundError`.
    """
    from safetensors import SafetensorError, safe_open

    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        with safe_open(path, framework="numpy") as file:
            metadata = file.metadata() or {}
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 (not a dict)
        settings = json.loads(metadata.get("settings", "null"))
    except (SafetensorError, OSError, ValueError) as error:
        raise ValueError(f"{path} is not a saved {kind}: the file is damaged, cut short or of another format ({error})") from None
    if metadata.get("course_lib") != kind:
        raise ValueError(f"{path} is not a saved {kind}: it holds {metadata.get('course_lib', 'something else')!r}")
    return arrays, settings
