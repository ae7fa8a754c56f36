"""JupyterHub's settings for a class on one Linux machine; `hub` copies this file to a folder, to be changed there.

Every learner has an account of the machine and is in the group `course`; their servers run under these accounts, so the
system keeps them apart. Start it as root: `jupyterhub -f jupyterhub_config.py`. What else can be set:
https://jupyterhub.readthedocs.io/en/stable/reference/config-reference.html
"""

import os
import pwd
import sys
from pathlib import Path

c = get_config()  # noqa: F821 (traitlets hands it in when it reads this file)

here = Path(__file__).resolve().parent

# Reached from this machine only, until you say where else; then with a certificate, or behind a server that has one.
c.JupyterHub.bind_url = "http://127.0.0.1:8000"

# What the hub keeps, for root alone.
c.JupyterHub.db_url = f"sqlite:///{here}/state/jupyterhub.sqlite"
c.JupyterHub.cookie_secret_file = f"{here}/state/cookie_secret"
c.ConfigurableHTTPProxy.pid_file = f"{here}/state/proxy.pid"

# Who comes in: accounts of the machine that are in the group, with their passwords.
c.JupyterHub.authenticator_class = "pam"
c.LocalAuthenticator.allowed_groups = {"course"}

# A process for each of them, under their own account. A spawner that runs all under one account (`simple`, or
# containers with one user id) keeps nobody's work from anybody.
c.JupyterHub.spawner_class = "jupyterhub.spawner.LocalProcessSpawner"
c.Spawner.cmd = [os.path.join(sys.prefix, "bin", "jupyterhub-singleuser")]
c.Spawner.default_url = "/lab"
# Their Jupyter and nbgrader read the settings in `jupyter` before any of their own. The sockets of their kernels lie in
# their home; a socket's whole path may have 107 characters only.
c.Spawner.environment = {
    "JUPYTER_CONFIG_PATH": str(here / "jupyter"),
    "JUPYTER_RUNTIME_DIR": lambda spawner: os.path.join(pwd.getpwnam(spawner.user.name).pw_dir, ".run"),
}
# A whole class that logs in at once waits in a line.
c.JupyterHub.concurrent_spawn_limit = 8
c.Spawner.start_timeout = c.Spawner.http_timeout = 180
# One that is interrupted in the midst of an answer may never end (https://github.com/jupyterlab/jupyterlab/issues/10442);
# so that nobody waits a minute for it, it is killed after these seconds.
c.LocalProcessSpawner.interrupt_timeout = 10
c.LocalProcessSpawner.term_timeout = 5


def keep_home_private(spawner):
    """On many systems the others may read a new home."""
    os.chmod(pwd.getpwnam(spawner.user.name).pw_dir, 0o700)


c.Spawner.pre_spawn_hook = keep_home_private
