"""A learner's hands on an explorer in the page, and its twin: the same explorer here, without a browser.

Whatever is done in the page is done to the twin as well; both must then show the same, which compares states, not
pixels. The twin is made by the very cells of the lesson.
"""

import os
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import nbformat
from nbformat.v4 import new_code_cell, new_notebook

from .lab import LESSONS

KEY_OF = {"slider": "ArrowRight", "choice": "ArrowDown", "switch": "Space", "button": "Enter"}
ARROWS = ("ArrowDown", "ArrowRight", "ArrowUp", "ArrowLeft")


def code_cells(path):
    return [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]


def shows_an_explorer(cell):
    last = cell.source.strip().splitlines()[-1]
    return last.startswith("explore.") and last.endswith(")")


def only_explorers(path):
    """A lesson's imports and its explorers, in its own cells."""
    first, *others = code_cells(path)
    first.source = "\n".join(line for line in first.source.splitlines() if line.startswith(("import ", "from ")))
    return as_notebook([first, *filter(shows_an_explorer, others)])


def as_notebook(cells):
    kernel = {"name": "python3", "display_name": "Python 3 (ipykernel)", "language": "python"}
    return new_notebook(cells=cells, metadata={"kernelspec": kernel})


# The trading floor as it stands at the end of both homeworks, where the learner's own traders come to it
OWN_TRADERS = (
    "import numpy as np\nfrom course_lib import explore, market",
    """explore.trading_floor(
    part := market.split(market.real_prices("IBM")).test,
    {"coin": np.random.default_rng(0).integers(-1, 2, (20, len(part.close))), "long": np.ones(len(part.close), int)},
)""",
)


def notebooks_with_explorers():
    """{name: notebook} of the explorers of every lesson."""
    lessons = [path for path in LESSONS if any(map(shows_an_explorer, code_cells(path)))]
    return {path.stem: only_explorers(path) for path in lessons} | {
        "own_traders": as_notebook([new_code_cell(source) for source in OWN_TRADERS])
    }


def twins(notebook):
    """The explorers of such a notebook, made here."""
    imports, *cells = [cell.source for cell in notebook.cells]
    names = {}
    exec(imports, names)
    return [eval(cell, names) for cell in cells]


@contextmanager
def working_in(folder):
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


@contextmanager
def open_explorers(lab, name, notebook, folder):
    """The notebook's explorers in the page, each with its twin, which does its work in `folder`."""
    name = f"explorers_{name}.ipynb"
    nbformat.write(notebook, lab.server.folder / name)
    with lab.open(name) as opened, working_in(folder):
        opened.dress("light", 1280)
        opened.run_all()
        made = twins(notebook)
        lab.page.wait_for_function("n => document.querySelectorAll('.course-explorer').length === n", arg=len(made))
        yield opened, [Hands(opened, i, twin) for i, twin in enumerate(made)]


@dataclass
class Hands:
    """One explorer in the page, `number` from 0, and its `twin`."""

    notebook: object
    number: int
    twin: object

    @property
    def page(self):
        return self.notebook.lab.page

    @property
    def root(self):
        return self.page.locator(".course-explorer").nth(self.number)

    def control(self, name):
        """The input, or the button, of a control."""
        number = [control["name"] for control in self.twin.controls].index(name)
        return (
            self.root.locator(".ce-controls > *")
            .nth(number)
            .locator("xpath=descendant-or-self::*[self::input or self::select or self::button]")
        )

    @property
    def board(self):
        return self.root.locator(".ce-board")

    def do(self, what, name, *at):
        """To the twin only."""
        self.twin.do(what, name, *at)
        assert self.twin.wait(120), "work without end"

    def wait(self, limit=120):
        """Till the kernel has answered everything and no work is under way."""
        done = """number => {
            const root = document.querySelectorAll(".course-explorer")[number];
            return root.dataset.idle === "true" && root.querySelector("progress").hidden;
        }"""
        self.page.wait_for_function(done, arg=self.number, timeout=limit * 1000)

    def seen(self):
        """What the page shows: the controls, every panel's markup and words, the message."""
        return self.root.evaluate(
            """root => ({
                dials: [...root.querySelectorAll(".ce-controls > *")].map((node) => {
                    const input = node.matches("button") ? node : node.querySelector("input, select");
                    if (input.type === "range") return Number(input.value);
                    if (input.type === "checkbox") return Number(input.checked);
                    return input.localName === "select" ? input.selectedIndex : input.textContent;
                }),
                panels: [...root.querySelectorAll(".ce-panel")].map((panel) => ({
                    markup: panel.firstElementChild.innerHTML.replaceAll(
                        `${root.dataset.ids}-${panel.dataset.panel}-`, ""),
                    words: (panel.querySelector("[hidden]") || {}).textContent
                        ?? panel.firstElementChild.getAttribute("aria-label"),
                })),
                message: root.querySelector(".ce-message").textContent,
            })"""
        )

    def expected(self):
        """What the twin has to show, as this browser writes it."""
        parse = """markup => {
            const place = document.createElement("div");
            place.innerHTML = markup;
            return place.innerHTML;
        }"""
        return {
            "dials": [control["at"] if "at" in control else control["label"] for control in self.twin.controls],
            "panels": [
                {
                    "markup": self.page.evaluate(parse, panel["svg"] or panel["html"]),
                    "words": panel["words"] if panel["svg"] else None,
                }
                for panel in self.twin.panels
            ],
            "message": self.twin.message,
        }

    def assert_alike(self, after):
        self.wait()
        seen, expected = self.seen(), self.expected()
        assert seen["dials"] == expected["dials"], f"controls after {after}"
        assert seen["message"] == expected["message"], f"message after {after}"
        for panel, there, here in zip(self.twin.panels, seen["panels"], expected["panels"], strict=True):
            assert there == here, f"{panel['name']} after {after}"
