"""The folder of a hub: what is in it, and who may do what there; the hub itself is in tests/hub."""

import json
import os
from types import SimpleNamespace

import pytest
from traitlets.config.loader import PyFileConfigLoader

from course_lib.classroom.__main__ import main
from course_lib.classroom.hub import new_hub

pwd = pytest.importorskip("pwd", reason="a hub needs accounts, which Windows has none of")


def settings_in(path):
    return PyFileConfigLoader(path.name, path=str(path.parent)).load_config()


@pytest.fixture
def hub(tmp_path):
    """A hub made by somebody whose new files nobody else may read."""
    before = os.umask(0o077)
    try:
        return new_hub(tmp_path / "somewhere" / "hub")
    finally:
        os.umask(before)


def test_everybody_may_read_the_settings_and_nobody_the_state(hub):
    modes = {str(path.relative_to(hub)): oct(path.stat().st_mode & 0o7777) for path in hub.rglob("*")}
    assert modes == {
        "jupyterhub_config.py": "0o644",
        "state": "0o700",
        "exchange": "0o1777",
        "jupyter": "0o755",
        "jupyter/nbgrader_config.py": "0o644",
        "jupyter/jupyter_server_config.py": "0o644",
        "jupyter/labconfig": "0o755",
        "jupyter/labconfig/page_config.json": "0o644",
    }
    assert oct(hub.stat().st_mode & 0o7777) == "0o755"


def test_all_that_the_hub_keeps_is_in_its_state(hub):
    settings = settings_in(hub / "jupyterhub_config.py")
    assert settings.JupyterHub.db_url == f"sqlite:///{hub}/state/jupyterhub.sqlite"
    for kept in (settings.JupyterHub.cookie_secret_file, settings.ConfigurableHTTPProxy.pid_file):
        assert kept.startswith(f"{hub}/state/")


def test_learners_have_accounts_of_their_own_and_this_computer_only(hub):
    settings = settings_in(hub / "jupyterhub_config.py")
    assert settings.JupyterHub.bind_url.startswith("http://127.0.0.1:")
    assert settings.JupyterHub.authenticator_class == "pam"
    assert settings.LocalAuthenticator.allowed_groups == {"course"}
    assert settings.JupyterHub.spawner_class == "jupyterhub.spawner.LocalProcessSpawner"
    assert settings.Spawner.environment["JUPYTER_CONFIG_PATH"] == f"{hub}/jupyter"


def test_the_sockets_of_kernels_fit_where_a_socket_may_be(hub, monkeypatch):
    home = "/home/the-class-of-2026/somebody-with-a-long-name"
    monkeypatch.setattr(pwd, "getpwnam", lambda name: {"ann": SimpleNamespace(pw_dir=home)}[name])
    settings = settings_in(hub / "jupyterhub_config.py")
    folder = settings.Spawner.environment["JUPYTER_RUNTIME_DIR"](SimpleNamespace(user=SimpleNamespace(name="ann")))
    assert folder.startswith(f"{home}/")
    assert len(f"{folder}/kernel-85f3d40d-bab1-4e3a-9028-cf6ae38698e5-ipc-5") <= 107


def test_a_home_is_closed_before_its_server_starts(hub, tmp_path, monkeypatch):
    settings = settings_in(hub / "jupyterhub_config.py")
    home = tmp_path / "home"
    home.mkdir(mode=0o755)
    monkeypatch.setattr(pwd, "getpwnam", lambda name: {"ann": SimpleNamespace(pw_dir=str(home))}[name])
    settings.Spawner.pre_spawn_hook(SimpleNamespace(user=SimpleNamespace(name="ann")))
    assert home.stat().st_mode & 0o777 == 0o700


def test_learners_servers_have_the_exchange_and_no_open_ports(hub):
    nbgrader = settings_in(hub / "jupyter" / "nbgrader_config.py")
    assert nbgrader.Exchange.root == f"{hub}/exchange"
    assert nbgrader.ExchangeFactory.submit == "course_lib.classroom.submit.SubmitPrivately"
    assert settings_in(hub / "jupyter" / "jupyter_server_config.py").KernelManager.transport == "ipc"
    page = json.loads((hub / "jupyter" / "labconfig" / "page_config.json").read_text())
    assert page == {"disabledExtensions": {"@jupyterlab/debugger-extension": True}}


def test_what_is_there_is_never_written_over(hub, tmp_path):
    (tmp_path / "file").write_text("")
    for place in (hub, tmp_path / "file"):
        with pytest.raises(FileExistsError, match="not empty"):
            new_hub(place)


def test_on_the_command_line(tmp_path, capsys):
    assert main(["hub", str(tmp_path / "hub")]) == 0
    assert f"jupyterhub -f {tmp_path}/hub/jupyterhub_config.py" in capsys.readouterr().out
    assert main(["hub", str(tmp_path / "hub")]) == 1
    assert capsys.readouterr().err.count("\n") == 1
