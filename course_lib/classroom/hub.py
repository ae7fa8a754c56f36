"""The folder of a JupyterHub for a class: its settings, those of the learners' servers, and the exchange."""

import os
import shutil
from pathlib import Path

SETTINGS = Path(__file__).with_name("jupyterhub_config.py")

_NBGRADER = '''"""nbgrader's settings in the learners' servers."""

from pathlib import Path

c = get_config()
c.Exchange.root = str(Path(__file__).resolve().parents[1] / "exchange")
c.ExchangeFactory.submit = "course_lib.classroom.submit.SubmitPrivately"
'''

# A kernel that speaks over TCP tells every account of the machine what is run in it: its messages are signed, and not
# encrypted. Sockets in the learner's own folder are closed to others.
_SERVER = '''"""Jupyter's settings in the learners' servers."""

c = get_config()
c.KernelManager.transport = "ipc"
'''

# The debugger opens a port without a password, through which any account could run code as the learner.
_PAGE = '{"disabledExtensions": {"@jupyterlab/debugger-extension": true}}\n'


def new_hub(folder):
    """Make the folder of a hub, new or empty, and return its path; `FileExistsError` where there is something.

    All accounts may read it, for what is secret is in `state`, and write in `exchange`, where each may remove only
    what is its own.
    """
    folder = Path(folder).resolve()
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise FileExistsError(f"{folder} is there already and not empty")
    texts = {
        "jupyter/nbgrader_config.py": _NBGRADER,
        "jupyter/jupyter_server_config.py": _SERVER,
        "jupyter/labconfig/page_config.json": _PAGE,
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, mode in (("state", 0o700), ("exchange", 0o1777), ("jupyter", 0o755), ("jupyter/labconfig", 0o755)):
        (folder / name).mkdir()
        os.chmod(folder / name, mode)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
        os.chmod(folder / name, 0o644)
    shutil.copyfile(SETTINGS, folder / SETTINGS.name)
    for path in (folder, folder / SETTINGS.name):
        os.chmod(path, 0o755 if path.is_dir() else 0o644)
    return folder
