"""A real JupyterHub, and learners who work through their own servers' REST API, as their browsers would."""

import asyncio
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import uuid
from contextlib import contextmanager
from pathlib import Path

import requests

from course_lib.classroom.hub import new_hub

# With two processors 40 servers take a minute and a half to start.
START_SECONDS, STEP_SECONDS = 300, 60
TOKEN = uuid.uuid4().hex

_FOR_TESTS = """
c = get_config()
load_subconfig({settings!r})
c.JupyterHub.bind_url = "http://127.0.0.1:{port}"
c.JupyterHub.hub_port = {hub_port}
c.ConfigurableHTTPProxy.api_url = "http://127.0.0.1:{proxy_port}"
c.JupyterHub.services = [{{"name": "the-tests", "api_token": {token!r}}}]
c.JupyterHub.load_roles = [
    {{"name": "tests", "scopes": ["admin:users", "admin:servers", "tokens"], "services": ["the-tests"]}}
]
"""


def why_not():
    """What is missing for a hub; empty where nothing is."""
    for module in ("jupyterhub", "nbgrader"):
        try:
            __import__(module)
        except ImportError:
            return f'needs {module}: pip install -e ".[teach,hub]"'
    if not shutil.which("configurable-http-proxy"):
        return "needs configurable-http-proxy: npm install -g configurable-http-proxy"
    return ""


def free_ports(number):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(number)]
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


@contextmanager
def running_hub(folder):
    """A hub with the settings that teachers get, on ports of its own."""
    settings = new_hub(folder) / "jupyterhub_config.py"
    port, hub_port, proxy_port = free_ports(3)
    ours = folder / "state" / "tests_config.py"
    ours.write_text(
        _FOR_TESTS.format(settings=str(settings), port=port, hub_port=hub_port, proxy_port=proxy_port, token=TOKEN)
    )
    log = folder / "state" / "log"
    with log.open("wb") as output:
        process = subprocess.Popen(
            [sys.executable, "-m", "jupyterhub", "-f", ours], stdout=output, stderr=output, cwd=folder / "state"
        )
    hub = Hub(f"http://127.0.0.1:{port}", folder, log)
    try:
        wait_until(lambda: process.poll() is not None or hub.is_up(), 60, log.read_text)
        yield hub
    finally:
        stop(process)


def stop(process):
    """End a hub as a system does; the longest it may take is what its settings give to a server that does not hear."""
    process.terminate()
    process.wait(40)


def wait_until(condition, seconds, words):
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(words()[-3000:])
        time.sleep(0.2)


class Hub:
    """The hub at `address`, asked with the rights of the one who runs it."""

    def __init__(self, address, folder, log):
        self.address, self.folder, self.log = address, folder, log

    def is_up(self):
        try:
            return requests.get(f"{self.address}/hub/health", timeout=5).ok
        except requests.ConnectionError:
            return False

    def ask(self, method, path, **arguments):
        answer = requests.request(
            method,
            f"{self.address}/hub/api{path}",
            headers={"Authorization": f"token {TOKEN}"},
            timeout=START_SECONDS,
            **arguments,
        )
        if not answer.ok:
            raise RuntimeError(f"{method} {path}: {answer.status_code} {answer.text[:300]}")
        return answer.json() if answer.content else None

    def servers(self):
        """The names of those whose server is up."""
        return {user["name"] for user in self.ask("GET", "/users?state=ready")}

    def learner(self, name):
        """A learner with a token of their own; their server is started by `start`."""
        if name not in {user["name"] for user in self.ask("GET", "/users")}:
            self.ask("POST", f"/users/{name}")
        token = self.ask("POST", f"/users/{name}/tokens", json={"expires_in": 7200})["token"]
        return Learner(self, name, token)


class Learner:
    """Somebody with a server on the hub, asked with a token that is theirs and no one else's."""

    def __init__(self, hub, name, token):
        self.hub, self.name, self.token = hub, name, token

    # --- the server ---------------------------------------------------------------------------------------------------

    def start(self):
        self.hub.ask("POST", f"/users/{self.name}/server")
        wait_until(lambda: self.name in self.hub.servers(), START_SECONDS, self.hub.log.read_text)

    def stop(self):
        self.hub.ask("DELETE", f"/users/{self.name}/server")

    def server_process(self):
        """The process id of their server."""
        for number in filter(str.isdigit, os.listdir("/proc")):
            try:
                words = Path("/proc", number, "cmdline").read_bytes()
                owner = Path("/proc", number).owner()
            except (OSError, KeyError):
                continue
            if owner == self.name and b"jupyterhub-singleuser" in words:
                return int(number)
        raise RuntimeError(f"{self.name} has no server")

    def ask(self, method, path, *, of=None, **arguments):
        """The answer of their server, or of that `of` another, to a request with their token."""
        return requests.request(
            method,
            f"{self.hub.address}/user/{of or self.name}/{path}",
            headers=self._headers(),
            timeout=STEP_SECONDS,
            **arguments,
        )

    def _headers(self, path=""):  # noqa: ARG002 (cookies depend on it)
        return {"Authorization": f"token {self.token}"}

    def asked(self, method, path, **arguments):
        """The same, where it has to go well."""
        answer = self.ask(method, path, **arguments)
        if not answer.ok:
            raise RuntimeError(f"{self.name}: {method} {path}: {answer.status_code} {answer.text[:300]}")
        return answer.json() if answer.content else None

    # --- homework -----------------------------------------------------------------------------------------------------

    def assignments(self, course):
        said = self.asked("GET", f"assignments?course_id={course}")
        if not said["success"]:
            raise RuntimeError(said["value"])
        return said["value"]

    def act(self, action, course, homework):
        """What a click on Fetch, Submit or Fetch Feedback in the list of assignments does."""
        said = self.asked("POST", f"assignments/{action}", json={"course_id": course, "assignment_id": homework})
        if not said["success"]:
            raise RuntimeError(f"{self.name}: {action}: {said['value']}")
        return said["value"]

    def read(self, path):
        """The notebook, or the text, at a path in their home."""
        return self.asked("GET", f"api/contents/{path}")["content"]

    def save(self, path, notebook):
        self.asked("PUT", f"api/contents/{path}", json={"type": "notebook", "format": "json", "content": notebook})

    # --- code ---------------------------------------------------------------------------------------------------------

    def run(self, code):
        """What the code prints in a kernel of their server."""
        kernel = self.asked("POST", "api/kernels", json={"name": "python3"})["id"]
        try:
            return asyncio.run(asyncio.wait_for(self._run(kernel, code), STEP_SECONDS))
        finally:
            self.asked("DELETE", f"api/kernels/{kernel}")

    async def _run(self, kernel, code):
        from tornado.httpclient import HTTPRequest
        from tornado.websocket import websocket_connect

        address = f"{self.hub.address}/user/{self.name}/api/kernels/{kernel}/channels".replace("http", "ws", 1)
        connection = await websocket_connect(HTTPRequest(address, headers=self._headers(f"/user/{self.name}/")))
        header = {"msg_id": uuid.uuid4().hex, "username": self.name, "session": uuid.uuid4().hex, "version": "5.3"}
        await connection.write_message(
            json.dumps(
                {
                    "header": header | {"msg_type": "execute_request", "date": ""},
                    "parent_header": {},
                    "metadata": {},
                    "content": {"code": code, "silent": False, "store_history": False},
                    "channel": "shell",
                    "buffers": [],
                }
            )
        )
        printed = []
        while True:
            said = json.loads(await connection.read_message())
            if said["parent_header"].get("msg_id") != header["msg_id"]:
                continue
            match said["msg_type"], said["content"]:
                case "stream", {"text": text}:
                    printed.append(text)
                case "error", {"traceback": lines}:
                    raise RuntimeError("\n".join(lines))
                case "status", {"execution_state": "idle"}:
                    connection.close()
                    return "".join(printed)


class Visitor(Learner):
    """Somebody who has logged in with a name and a password, and has what a browser has then: cookies."""

    def __init__(self, address, name, password):
        super().__init__(Hub(address, None, None), name, None)
        self._browser = requests.Session()
        page = self._browser.get(f"{address}/hub/login", timeout=STEP_SECONDS)
        form = {"username": name, "password": password, "_xsrf": self._xsrf("/hub/")}
        answer = self._browser.post(page.url, data=form, timeout=STEP_SECONDS)
        answer.raise_for_status()

    @staticmethod
    def answers(address):
        return Hub(address, None, None).is_up()

    def _xsrf(self, path):
        return next(
            (cookie.value for cookie in self._browser.cookies if (cookie.name, cookie.path) == ("_xsrf", path)), ""
        )

    def start(self):
        """Open the page that starts the server, and wait until it is there."""
        self._browser.get(f"{self.hub.address}/hub/spawn", timeout=STEP_SECONDS)
        home = f"{self.hub.address}/user/{self.name}/lab"
        wait_until(
            lambda: "/lab" in self._browser.get(home, timeout=STEP_SECONDS).url and self.ask("GET", "api/status").ok,
            START_SECONDS,
            lambda: f"the server of {self.name} does not start",
        )

    def ask(self, method, path, *, of=None, **arguments):
        place = f"/user/{of or self.name}/"
        headers = {"X-XSRFToken": self._xsrf(place)}
        address = f"{self.hub.address}{place}{path}"
        return self._browser.request(method, address, headers=headers, timeout=STEP_SECONDS, **arguments)

    def _headers(self, path=""):
        sent = [f"{cookie.name}={cookie.value}" for cookie in self._browser.cookies if cookie.path in ("/", path)]
        return {"Cookie": "; ".join(sent), "Origin": self.hub.address, "X-XSRFToken": self._xsrf(path)}

    def run_in_terminal(self, commands):
        """Run shell commands in their home, as they would in a terminal of their server."""
        code = (
            f"import subprocess, sys\nd = subprocess.run(['bash', '-ec', {commands!r}], capture_output=True, text=True)"
        )
        said = self.run(f"{code}\nprint(d.returncode, d.stdout, d.stderr)")
        if not said.startswith("0 "):
            raise RuntimeError(said)
        return said
