"""The widget around a state: what it hears, what it shows, longer work, and its still picture."""

import base64
import re
import threading
import time

import pytest

from course_lib import explore
from course_lib.explore.controls import Button, Dials, Panel, Slider, View
from course_lib.explore.explorer import Explorer
from course_lib.maze import Action


class Counter:
    """A state of its own for these tests: it counts, quickly or slowly."""

    title = "Counter <1>"

    def __init__(self):
        self.count, self.steps, self.heard, self.going = 0, 0, [], threading.Event()
        self.dials = Dials({"size": ("size of a step", (1, 2, 3))}, size=2)
        self.going.set()

    def turn(self, name, at):
        self.dials.turn(name, at)

    def press(self, name):
        if name == "broken":
            raise RuntimeError("a fault of ours")
        if name == "slow":
            return self._slowly()
        self.count += self.dials.size

    def _slowly(self):
        for self.steps in range(1, 6):
            self.going.wait(10)
            self.count += 1
            yield

    def choose(self, cell):
        self.heard.append(("cell", cell))

    def arrow(self, action):
        self.heard.append(("arrow", action))

    def view(self):
        panel = Panel("count", f"The count is {self.count}.", f"<svg>{self.count}</svg>", board="the board")
        text = Panel("text", html=f"<p>{self.count}</p>")
        controls = (self.dials.slider("size"), Button("add", "add"))
        progress = self.steps / 5 if 0 < self.steps < 5 else None
        return View(controls, (panel, text), f"count {self.count} & more", progress)


@pytest.fixture
def explorer():
    return Explorer(Counter())


def hear(explorer, *do, number="1"):
    explorer._hear(explorer, {"do": list(do), "id": number}, [])


def shown(explorer):
    return explorer.panels[0]["svg"], explorer.message


def test_it_shows_the_state_from_the_first_moment(explorer):
    assert explorer.title == "Counter <1>"
    assert explorer.controls == [
        {"name": "size", "label": "size of a step", "texts": ("1", "2", "3"), "at": 1, "kind": "slider"},
        {"name": "add", "label": "add", "idle": False, "kind": "button"},
    ]
    assert shown(explorer) == ("<svg>0</svg>", "count 0 & more")
    assert explorer.panels[0]["words"] == "The count is 0."
    assert explorer.progress is None


def test_what_is_done_in_the_browser_is_done_to_the_state_and_answered(explorer):
    hear(explorer, "press", "add", number="7")
    assert shown(explorer) == ("<svg>2</svg>", "count 2 & more")
    assert explorer.answered == "7"
    hear(explorer, "turn", "size", 2, number="8")
    assert explorer.controls[0]["at"] == 2
    hear(explorer, "press", "add", number="9")
    assert shown(explorer)[0] == "<svg>5</svg>"
    hear(explorer, "choose", 3)
    hear(explorer, "arrow", "ArrowLeft")
    assert explorer.state.heard == [("cell", 3), ("arrow", Action.LEFT)]


def test_a_picture_comes_before_the_answer_to_its_wish(explorer):
    """The browser sends the next move at the answer, and would else draw an older picture over a newer slider."""
    seen = []
    explorer.observe(lambda change: seen.append(change.name), ["panels", "answered"])
    hear(explorer, "press", "add")
    assert seen == ["panels", "answered"]


@pytest.mark.parametrize(
    "do",
    [
        ("press", "broken"), ("press", "add", 1), ("jump", "up"), ("view", "x"), ("arrow", "Enter"),
        ("turn", "size", 3), ("turn", "size"), ("turn", "no", 0),
    ],
)  # fmt: skip
def test_a_fault_is_raised_and_the_browser_is_not_left_waiting(explorer, do):
    with pytest.raises((ValueError, RuntimeError)):
        hear(explorer, *do, number="3")
    assert explorer.answered == "3"
    assert shown(explorer)[0] == "<svg>0</svg>"
    assert explorer.message.startswith("That went wrong: ")


def test_an_explorer_without_a_board_says_so():
    explorer = Explorer(Counter())
    explorer.state = type("Boardless", (), {"view": Counter().view})()
    with pytest.raises(ValueError, match="no board to choose on"):
        explorer.do("choose", 3)


def test_a_fault_shows_the_state_as_it_is(explorer):
    """What was half done is seen, and not a picture from before."""

    def half(_):
        explorer.state.count = 7
        raise RuntimeError("half done")

    explorer.state.press = half
    with pytest.raises(RuntimeError):
        hear(explorer, "press", "add")
    assert shown(explorer) == ("<svg>7</svg>", "That went wrong: half done")


def test_longer_work_goes_on_step_by_step_and_the_page_is_heard_meanwhile(explorer):
    explorer.state.going.clear()
    seen = []
    explorer.observe(lambda change: seen.append(change.new), "progress")
    hear(explorer, "press", "slow")
    assert not explorer.wait(0.05)
    explorer.state.going.set()
    assert explorer.wait(10)
    assert shown(explorer)[0] == "<svg>5</svg>"
    assert [share for share in seen if share is not None] == [0.2, 0.4, 0.6, 0.8]
    assert explorer.progress is None


def test_newer_work_takes_the_place_of_older():
    explorer = Explorer(Counter())

    def endless():
        while True:
            time.sleep(0.001)
            yield

    explorer.state.press = lambda name: endless() if name == "endless" else explorer.state._slowly()
    explorer.do("press", "endless")
    first = explorer._worker
    explorer.do("press", "slow")
    assert explorer.wait(10)
    first.join(10)
    assert not first.is_alive()
    assert explorer.state.count == 5


def test_a_step_that_fails_ends_the_work_and_says_so(explorer, monkeypatch):
    def faulty():
        yield
        raise RuntimeError("the network is gone")

    failed = []
    monkeypatch.setattr(threading, "excepthook", lambda told: failed.append(told.exc_value))
    explorer.state.press = lambda _: faulty()
    explorer.do("press", "anything")
    assert explorer.wait(10)
    assert "the network is gone" in explorer.message
    assert len(failed) == 1


def test_still_picture_holds_what_is_seen(explorer):
    still = explorer.still()
    assert "Counter &lt;1&gt;" in still
    assert "size of a step: 2" in still
    assert "count 0 &amp; more" in still
    assert "<p>0</p>" in still
    image = re.search(r'<img alt="([^"]*)"[^>]* src="data:image/svg\+xml;base64,([^"]*)"', still)
    assert image.group(1) == "The count is 0."
    assert base64.b64decode(image.group(2)) == b"<svg>0</svg>"


def test_as_the_last_value_of_a_cell_it_is_a_widget_and_a_still_picture(explorer):
    bundle = explorer._repr_mimebundle_()
    bundle = bundle[0] if isinstance(bundle, tuple) else bundle
    assert bundle["text/html"] == explorer.still()
    assert bundle["text/plain"] == "Explorer: Counter <1>"
    assert bundle["application/vnd.jupyter.widget-view+json"]["model_id"] == explorer.model_id


def test_dials_stand_on_their_stops():
    dials = Dials(
        {"gamma": ("discount γ", (0.5, 0.9), "{:.2f}".format), "mask": ("mask", (False, True))}, gamma=0.9, mask=True
    )
    assert dials.gamma == 0.9
    assert dials.slider("gamma") == Slider("gamma", "discount γ", ("0.50", "0.90"), 1)
    assert dials.switch("mask").at == 1
    dials.turn("gamma", 0)
    assert dials.gamma == 0.5
    for name, at in (("gamma", 2), ("gamma", -1), ("gamma", 0.5), ("delta", 0)):
        with pytest.raises(ValueError, match=r"gamma must be|no control"):
            dials.turn(name, at)
    assert dials.gamma == 0.5
    assert not hasattr(dials, "delta")
    with pytest.raises(ValueError, match=r"0\.7"):
        Dials({"gamma": ("discount γ", (0.5, 0.9))}, gamma=0.7)


def test_a_view_knows_its_controls():
    view = Counter().view()
    assert view.control("add").label == "add"
    with pytest.raises(ValueError, match="no control 'sub'; there are size, add"):
        view.control("sub")


def test_everything_that_is_offered_is_an_explorer():
    for name in explore.__all__:
        assert hasattr(explore, name)
        assert getattr(explore, name).__doc__
