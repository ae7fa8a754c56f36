"""A real JupyterLab, private and short-lived, and a browser that opens lessons in it as a learner would.

Nothing is written outside one temporary folder: the lessons are copies, and Jupyter's own folders lie beside them.
"""

import json
import os
import re
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parent.parent.parent
NOTEBOOKS = ROOT / "notebooks"
LESSONS = sorted(NOTEBOOKS.glob("[0-9][0-9]_*.ipynb"))
THEMES = {"light": "JupyterLab Light", "dark": "JupyterLab Dark"}
WIDTHS = (1280, 800)  # a small laptop, and half a large screen
HEIGHT = 1000

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
BROWSER_FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]

# A wrong guess here hides a real fault, so every entry is one exact message and says why it is no fault of a lesson.
HARMLESS: dict[str, str] = {}

# What JupyterLab writes where a widget should be and is not.
WIDGET_WORDS = re.compile(r"\(children=|Loading widget|Error displaying widget|A Jupyter Widget")

FOLDERS = {
    "JUPYTER_CONFIG_DIR": "config",
    "JUPYTER_DATA_DIR": "data",
    "JUPYTER_RUNTIME_DIR": "runtime",
    "JUPYTERLAB_SETTINGS_DIR": "settings",
    "JUPYTERLAB_WORKSPACES_DIR": "workspaces",
    "IPYTHONDIR": "ipython",
}
# Should the tests be killed outright, the server they leave behind ends itself.
SERVER_CONFIG = {
    "ServerApp": {"shutdown_no_activity_timeout": 900},
    "MappingKernelManager": {"cull_idle_timeout": 900},
}
LAB_SETTINGS = {
    "@jupyterlab/apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
    # All cells are in the page at once; else those out of sight could not be looked at.
    "@jupyterlab/notebook-extension/tracker": {"windowingMode": "none"},
}


def find_browser():
    """Where the browser's program lies, or None."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


@contextmanager
def open_browser(program):
    """Chromium, without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=BROWSER_FLAGS)
        try:
            yield browser
        finally:
            browser.close()


@dataclass
class Server:
    """A running JupyterLab: its port, and the folders it serves and works in."""

    port: int
    token: str
    folder: Path
    place: Path

    def url(self, page):
        return f"http://127.0.0.1:{self.port}/{page}?token={self.token}"

    def first_page(self):
        """The address that the command `jupyter lab FILE` would have opened in the learner's browser."""
        redirect = next((self.place / "runtime").glob("jpserver-file-to-run-*-open.html")).read_text()
        return redirect.split('href="')[1].split('"')[0]


@contextmanager
def jupyter_lab(command=None, settings=LAB_SETTINGS):
    """Run JupyterLab over a copy of the notebooks until the block ends. `command` replaces our own command line."""
    command = command or [sys.executable, "-m", "jupyterlab", "notebooks", "--LabApp.expose_app_in_browser=True"]
    command = [*command, "--no-browser", *(["--allow-root"] if is_root() else [])]
    with tempfile.TemporaryDirectory(prefix="course-", ignore_cleanup_errors=True) as name:
        place = Path(name)
        folder = place / "course" / "notebooks"
        shutil.copytree(NOTEBOOKS, folder, ignore=shutil.ignore_patterns(".ipynb_checkpoints"))
        port, token = free_port(), secrets.token_hex(16)
        write_settings(place, settings)
        with (place / "server.log").open("w") as log:
            process = subprocess.Popen(
                command,
                cwd=place / "course",
                env=private_environment(place, port, token),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C is for the tests, which then end the server
            )
        try:
            server = Server(port, token, folder, place)
            wait_until_up(process, server)
            yield server
        finally:
            stop(process)


def is_root():
    return hasattr(os, "geteuid") and os.geteuid() == 0


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def private_environment(place, port, token):
    """This environment, but with Jupyter's folders, port and token our own."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("JUPYTER", "JPY_"))}
    environment |= {name: str(place / folder) for name, folder in FOLDERS.items()}
    environment |= {"JUPYTER_PORT": str(port), "JUPYTER_PORT_RETRIES": "0", "JUPYTER_TOKEN": token}
    environment["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return environment


def write_settings(place, settings):
    for folder in FOLDERS.values():
        (place / folder).mkdir()
    (place / "config" / "jupyter_server_config.json").write_text(json.dumps(SERVER_CONFIG))
    for name, values in settings.items():
        file = place / "settings" / f"{name}.jupyterlab-settings"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(values))


def wait_until_up(process, server, limit=90):
    end = time.monotonic() + limit
    while time.monotonic() < end:
        if process.poll() is not None:
            break
        try:
            urllib.request.urlopen(server.url("api/status"), timeout=5).close()
            return
        except OSError:
            time.sleep(0.1)
    raise RuntimeError(f"JupyterLab did not start:\n{(server.place / 'server.log').read_text()[-3000:]}")


def stop(process):
    """End the server and its kernels, kindly first. Kernels lead sessions of their own, so they are noted before."""
    try:
        family = psutil.Process(process.pid).children(recursive=True)
    except psutil.NoSuchProcess:
        family = []
    process.terminate()
    try:
        process.wait(timeout=15)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    _, alive = psutil.wait_procs(family, timeout=3)
    for kernel in alive:
        kernel.kill()


@contextmanager
def open_lab(browser, server):
    """JupyterLab in a browser tab of its own. It is loaded once, since that takes longer than most lessons."""
    page = browser.new_page(viewport={"width": WIDTHS[0], "height": HEIGHT})
    try:
        lab = Lab(page, server, listen(page, server))
        page.add_init_script(path=Path(__file__).with_name("in_page.js"))
        page.goto(server.url("lab"))
        page.wait_for_selector(".jp-DirListing-item")
        yield lab
    finally:
        page.close()


def listen(page, server):
    """Collect errors in the browser's console, in its scripts, and every wish for another machine's page."""
    complaints = []

    def note(message):
        if message not in HARMLESS:
            complaints.append(message)

    page.on("console", lambda message: note(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: note(f"uncaught: {error}"))
    page.on("request", lambda request: note(f"asks for {request.url[:200]}") if is_outside(request, server) else None)
    return complaints


def is_outside(request, server):
    own = tuple(f"http://{host}:{server.port}/" for host in ("127.0.0.1", "localhost"))
    return request.url.startswith("http") and not request.url.startswith(own)


@dataclass
class Lab:
    """A browser tab with JupyterLab in it, and what went wrong there so far."""

    page: object
    server: Server
    complaints: list[str]

    @contextmanager
    def open(self, name, patience=20):
        """Open a fresh copy of a notebook, with a fresh kernel; both are gone afterwards.

        Pictures and formulas that are not drawn after `patience` seconds are left for the checks to report.
        """
        if (NOTEBOOKS / name).exists():
            shutil.copy(NOTEBOOKS / name, self.server.folder / name)
        notebook = Notebook(self, name, len(self.complaints), patience)
        try:
            notebook.dress("light", WIDTHS[0])  # whatever the one before has left
            notebook.ask("open", name)
            notebook.wait_for_kernel()
            notebook.settle()
            yield notebook
        finally:
            notebook.ask("close")


@dataclass
class Notebook:
    """The notebook that is open. What the browser sees in it is found by the functions of in_page.js."""

    lab: Lab
    name: str
    heard: int
    patience: float

    @property
    def complaints(self):
        """Errors in the browser since this notebook was opened."""
        return self.lab.complaints[self.heard :]

    def ask(self, function, *arguments):
        return self.lab.page.evaluate("([name, values]) => course[name](...values)", [function, arguments])

    def wait_for_kernel(self, limit=60):
        state = self.ask("waitForKernel", limit)
        if state != "idle":
            raise RuntimeError(f"{self.name}: {state}")

    def run_all(self, limit=600):
        """Run all cells from a fresh kernel. A cell that fails stops the run, as it does for a learner."""
        state = self.ask("runAll", limit)
        if state != "done":
            raise RuntimeError(f"{self.name}: {state}")
        self.settle()

    def settle(self):
        """Wait till pictures and formulas are drawn."""
        self.ask("settle", self.patience)

    def look(self):
        """What there is to see: cells, pictures, formulas, links. See `look` in in_page.js."""
        return self.ask("look")

    def dress(self, theme, width, height=HEIGHT):
        """Light or dark, wide or narrow; the file browser stays beside the notebook, as the course opens."""
        self.lab.page.set_viewport_size({"width": width, "height": height})
        self.ask("setTheme", THEMES[theme])

    def too_wide(self):
        """What sticks out of its place or would have to be scrolled sideways, in outputs and texts."""
        return self.ask("tooWide")

    def cramped(self):
        """Code that would have to be scrolled sideways, and printed lines that had to be broken."""
        return self.ask("cramped")

    def screenshots(self, folder, label, height=2000):
        """Write the whole notebook as pages of about `height` pixels that end where a cell ends, if they can."""
        self.ask("openFolds")
        pages = self.ask("cutIntoPages", height)
        for number, page in enumerate(pages, 1):
            clip = self.ask("scrollTo", page)
            self.lab.page.screenshot(path=folder / f"{label}_{number:02}.png", clip=clip)
        return len(pages)
