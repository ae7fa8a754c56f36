"""What a learner can move, and what they then see: plain descriptions, without any widget in them."""

from dataclasses import asdict, dataclass

from course_lib.validate import whole_number


@dataclass(frozen=True)
class Slider:
    """One of several `stops`, in their order; `at` is the place of the chosen one. `texts`: how they are written."""

    name: str
    label: str
    texts: tuple[str, ...]
    at: int
    kind: str = "slider"


@dataclass(frozen=True)
class Choice:
    """One of a few `texts`; `at` is the place of the chosen one."""

    name: str
    label: str
    texts: tuple[str, ...]
    at: int
    kind: str = "choice"


@dataclass(frozen=True)
class Switch:
    """On (`at` is 1) or off (0)."""

    name: str
    label: str
    at: int
    texts: tuple[str, ...] = ("off", "on")
    kind: str = "switch"


@dataclass(frozen=True)
class Button:
    """Something to press. `idle`: it has nothing to do just now, and pressing it does nothing."""

    name: str
    label: str
    idle: bool = False
    kind: str = "button"


@dataclass(frozen=True)
class Panel:
    """One picture (`svg`) with its `words` for those who cannot see it, or a text (`html`).

    board   what the arrow keys and clicks on its cells do; "" for a picture that does nothing
    """

    name: str
    words: str = ""
    svg: str = ""
    html: str = ""
    board: str = ""


@dataclass(frozen=True)
class View:
    """All there is to see: controls and panels in their order, and one line of what just happened.

    progress   how much of some longer work is done, from 0 to 1; None where there is none
    """

    controls: tuple
    panels: tuple
    message: str = ""
    progress: float | None = None

    def plain(self):
        """The same in lists and dictionaries, as it travels to the browser."""
        return {
            "controls": [asdict(control) for control in self.controls],
            "panels": [asdict(panel) for panel in self.panels],
            "message": self.message,
            "progress": self.progress,
        }

    def control(self, name):
        """The control of that name; `ValueError` if there is none."""
        for control in self.controls:
            if control.name == name:
                return control
        raise ValueError(f"there is no control {name!r}; there are {', '.join(c.name for c in self.controls)}")


class Dials:
    """The values of an explorer's sliders, choices and switches, each one of its stops.

    stops: {name: (label, values)} or, with a way to write them, {name: (label, values, write)}; at: {name: the first
    value}. A value is looked up as an attribute: `dials.gamma`.
    """

    def __init__(self, stops, **at):
        self._stops = {name: (*stop, str)[:3] for name, stop in stops.items()}
        self._at = {name: list(self._stops[name][1]).index(at[name]) for name in self._stops}
        self._first = dict(self._at)

    def __getattr__(self, name):
        at = self.__dict__.get("_at", {})
        if name not in at:
            raise AttributeError(name)
        return self._stops[name][1][at[name]]

    def turn(self, name, at):
        """Put the dial `name` to its stop number `at`; `ValueError` for what there is not."""
        if name not in self._at:
            raise ValueError(f"there is no control {name!r}; there are {', '.join(self._at)}")
        self._at[name] = whole_number(name, at, below=len(self._stops[name][1]))

    def start_over(self, *names):
        """Put these dials back to where they stood at first."""
        self._at |= {name: self._first[name] for name in names}

    def _parts(self, name):
        label, values, write = self._stops[name]
        return {"name": name, "label": label, "texts": tuple(write(value) for value in values), "at": self._at[name]}

    def slider(self, name):
        """The dial as a `Slider`."""
        return Slider(**self._parts(name))

    def choice(self, name):
        """The dial as a `Choice`."""
        return Choice(**self._parts(name))

    def switch(self, name):
        """The dial as a `Switch`: its stops are False and True."""
        return Switch(name, self._stops[name][0], self._at[name])
