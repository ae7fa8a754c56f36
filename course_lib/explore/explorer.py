"""The widget that shows any explorer: it draws nothing and knows nothing of mazes or prices.

What is explored is a state, a plain object without a widget in it, with

    title           one line
    view()          a `View`: controls, panels, a message
    turn(name, at)  a slider, choice or switch was put to its stop number `at`
    press(name)     a button was pressed
    choose(cell)    a cell of its board was clicked; only states with a board
    arrow(action)   an arrow key was pressed on its board; only states with a board

What takes long is returned by `turn` or `press` as an iterator: between two of its steps the page is drawn anew and
whatever was moved meanwhile is heard. Newer work takes the place of older.
"""

import base64
import threading
import time
from contextlib import contextmanager, suppress
from html import escape
from pathlib import Path

import anywidget
import traitlets

from course_lib.maze import Action

_HERE = Path(__file__).parent
_DEEDS = ("turn", "press", "choose", "arrow")
_OVER = object()
_PAUSE = 0.005  # seconds between two steps of longer work, in which whoever waits for the lock gets it
_KEYS = {"ArrowUp": Action.UP, "ArrowDown": Action.DOWN, "ArrowLeft": Action.LEFT, "ArrowRight": Action.RIGHT}


class Explorer(anywidget.AnyWidget):
    """A state made visible and movable. As the last value of a cell it shows itself; on paper, a still picture.

    The browser sends what was done and waits for the answer before it sends more, so that nothing queues up: of many
    moves of one slider only the last counts, while every press of a button does.
    """

    _esm = _HERE / "explorer.js"
    _css = _HERE / "explorer.css"
    title = traitlets.Unicode().tag(sync=True)
    controls = traitlets.List().tag(sync=True)
    panels = traitlets.List().tag(sync=True)
    message = traitlets.Unicode().tag(sync=True)
    progress = traitlets.Float(None, allow_none=True).tag(sync=True)
    answered = traitlets.Unicode().tag(sync=True)

    def __init__(self, state):
        super().__init__(title=state.title, **state.view().plain())
        self.state, self._lock, self._worker = state, threading.RLock(), None
        self.on_msg(self._hear)

    def do(self, what, name, *at):
        """Do to the state what the browser asks for, and draw what came of it.

        what   "turn" (a name and the number of a stop), "press" (a name), "choose" (a cell) or "arrow" (a key's name).
        `ValueError` for what the state does not know. Longer work goes on in a thread; `wait` waits for its end.
        """
        if what not in _DEEDS or len(at) != (what == "turn"):
            raise ValueError(
                f"an explorer can {', '.join(_DEEDS)}, and only turn takes a stop, got {(what, name, *at)}"
            )
        if not hasattr(self.state, what):
            raise ValueError(f"this explorer has no board to {what} on")
        if what == "arrow":
            if name not in _KEYS:
                raise ValueError(f"the keys of a board are {', '.join(_KEYS)}, got {name!r}")
            name = _KEYS[name]
        with self._lock:
            work = getattr(self.state, what)(name, *at)
            if work is not None:
                self._worker = threading.Thread(target=self._labour, args=(work,), daemon=True)
                self._worker.start()
            self._draw()

    def wait(self, timeout=None):
        """Wait until the longer work under way is done, or for `timeout` seconds; whether it is done."""
        worker = self._worker
        if worker is not None:
            worker.join(timeout)
        return worker is None or not worker.is_alive()

    def still(self):
        """What is to be seen now, as HTML without anything in it that moves."""
        dials = [f"{c['label']}: {c['texts'][c['at']]}" for c in self.controls if "at" in c]
        pictures = "".join(_as_image(panel) if panel["svg"] else panel["html"] for panel in self.panels)
        line = f"<p><b>{escape(self.title)}</b> {escape(' · '.join(dials))}</p>"
        body = f"{line}{pictures}<p>{escape(self.message)}</p>"
        return f'<div style="background:#fdfdfb;color:#22262b;padding:8px">{body}</div>'

    def _repr_mimebundle_(self, **kwargs):
        shown = super()._repr_mimebundle_(**kwargs)
        bundle, *rest = shown if isinstance(shown, tuple) else (shown,)
        bundle = dict(bundle or {}) | {"text/html": self.still(), "text/plain": f"Explorer: {self.title}"}
        return (bundle, *rest)

    def _hear(self, _, content, buffers):  # noqa: ARG002 (ipywidgets' signature)
        with self._lock:  # a thread that draws would send what is set meanwhile, or lose it
            try:
                with self._faults_are_told():
                    self.do(*content["do"])
            finally:
                self.answered = content["id"]

    @contextmanager
    def _faults_are_told(self):
        """What goes wrong in a callback or a thread is written where no learner looks."""
        try:
            yield
        except Exception as error:
            with self._lock, suppress(Exception):  # if it cannot even be drawn, the old picture stays
                self._draw()
            with self._lock:
                self.message = f"That went wrong: {error}"
            raise

    def _draw(self):
        with self.hold_sync():
            for name, value in self.state.view().plain().items():
                setattr(self, name, value)

    def _labour(self, work):
        """Step by step, as long as nothing newer has come; what was moved meanwhile is heard between two steps."""
        with self._faults_are_told():
            for _ in self._while_wanted(work):
                self._draw()

    def _while_wanted(self, work):
        """The steps of `work`, and one time more after the last, under the lock, until something newer has come."""
        going_on = True
        while going_on:
            with self._lock:
                if self._worker is not threading.current_thread():
                    return
                going_on = next(work, _OVER) is not _OVER
                yield
            time.sleep(_PAUSE)


def _as_image(panel):
    data = base64.b64encode(panel["svg"].encode()).decode()
    look = 'width="360" style="max-width:100%;height:auto"'
    return f'<img alt="{escape(panel["words"])}" {look} src="data:image/svg+xml;base64,{data}">'
