"""From the press of a key to the new picture in the browser: explorers that compute or learn anew at every move.

    python tests/benchmarks/explorers.py

A real JupyterLab in headless Chromium. The clock starts at the key's own time stamp and stops when the first frame with
a changed picture has been drawn; the next key is pressed when all is quiet. Every slider of lessons 2 and 3 is moved,
and the first button of each explorer pressed. Beside them, in the same notebook server: the limit, a slider of
ipywidgets that writes its number into a label and computes nothing, and the usual way, `interact` with a figure of
matplotlib.
"""

import statistics
import sys
from pathlib import Path

import nbformat
from measure import show
from nbformat.v4 import new_code_cell

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent))
from tests.browser.hands import as_notebook, only_explorers
from tests.browser.lab import NOTEBOOKS, find_browser, jupyter_lab, open_browser, open_lab

MOVES = 30
LESSONS = ("02_bellman.ipynb", "03_q_table.ipynb")
LIMIT = """
import ipywidgets
slider, label = ipywidgets.IntSlider(0, 0, 40), ipywidgets.HTML("0")
slider.observe(lambda change: setattr(label, "value", str(change.new)), "value")
ipywidgets.VBox([slider, label], layout={"width": "400px"})
"""
USUAL = """
import matplotlib.pyplot as plt
from ipywidgets import interact

def draw(k):
    plt.plot([0, k])
    plt.show()

_ = interact(draw, k=(0, 40))
"""
WATCH = """picture => {
    window.waited = null;
    window.watching?.disconnect();
    let pressed = null;
    document.addEventListener("keydown", (event) => (pressed = event.timeStamp), { capture: true, once: true });
    window.watching = new MutationObserver(() => {
        if (pressed === null) return;
        window.watching.disconnect();
        requestAnimationFrame(() => setTimeout(() => (window.waited = performance.now() - pressed))); // painted by then
    });
    window.watching.observe(picture, { childList: true, subtree: true, characterData: true });
}"""
# A move that changes no picture in two seconds is not counted: the rates of a mouse that stands still change none.
SEEN = """() => new Promise((done) => {
    const end = Date.now() + 2000;
    const look = () => (window.waited !== null || Date.now() > end ? done(window.waited) : setTimeout(look, 5));
    look();
})"""


def one_move(page, place, picture, key):
    """Milliseconds from the key to the first frame with a new picture; None where no picture changes."""
    place.focus()
    page.evaluate(WATCH, picture)
    page.keyboard.press(key)
    taken = page.evaluate(SEEN)
    page.wait_for_timeout(60)
    return taken


def moves(page, place, picture, at, last, number):
    """Up the slider and down again, `number` moves in all; those that changed a picture."""
    taken, key = [], "ArrowRight"
    for _ in range(number):
        if at in (0, last):
            key = "ArrowRight" if at == 0 else "ArrowLeft"
        at += 1 if key == "ArrowRight" else -1
        taken.append(one_move(page, place, picture, key))
    return [milliseconds for milliseconds in taken if milliseconds is not None]


def explorers_of(lab, name, number):
    """{what is moved: milliseconds of every move} for the sliders and the first button of a lesson's explorers."""
    nbformat.write(only_explorers(NOTEBOOKS / name), lab.server.folder / "measured.ipynb")
    taken = {}
    with lab.open("measured.ipynb") as notebook:
        notebook.run_all()
        for explorer in lab.page.locator(".course-explorer").all():
            title = f"{name[:2]} {explorer.get_attribute('aria-label')}"
            picture = explorer.locator(".ce-panels").element_handle()
            for switch in explorer.locator("input[type=checkbox]:not(:checked)").all():
                switch.check()  # "solve at once": then every move is answered by a whole solution
            button = explorer.locator(".ce-button").first
            presses = [one_move(lab.page, button, picture, "Enter") for _ in range(number)]
            taken[f"{title}: {button.inner_text()}"] = [one for one in presses if one is not None]
            for slider in explorer.locator("input[type=range]").all():
                at, last = int(slider.input_value()), int(slider.get_attribute("max"))
                what = f"{title}: {slider.locator('xpath=../span').first.inner_text()}"
                taken[what] = moves(lab.page, slider, picture, at, last, number)
    return {what: numbers for what, numbers in taken.items() if len(numbers) > number / 2}


def peers(lab, number):
    """The same for the two that this is measured against."""
    nbformat.write(as_notebook([new_code_cell(LIMIT), new_code_cell(USUAL)]), lab.server.folder / "peers.ipynb")
    with lab.open("peers.ipynb") as notebook:
        notebook.run_all()
        limit, usual = lab.page.locator(".noUi-handle").all()
        label = lab.page.locator(".widget-html-content").first.element_handle()
        figure = lab.page.locator(".widget-output, .jupyter-widget-output-area").first.element_handle()
        return {
            "limit: a slider and a label": moves(lab.page, limit, label, 0, 40, number),
            "usual: interact with matplotlib": moves(lab.page, usual, figure, 20, 40, number),
        }


def measure(number=MOVES, lessons=LESSONS):
    """{what is moved: milliseconds}, peers first."""
    program = find_browser() or sys.exit("needs a browser")
    with jupyter_lab() as server, open_browser(program) as browser, open_lab(browser, server) as lab:
        taken = peers(lab, number)
        for name in lessons:
            taken |= explorers_of(lab, name, number)
    return taken


def p95(numbers):
    return statistics.quantiles(numbers, n=20, method="inclusive")[-1]


def main():
    taken = measure()
    limit = statistics.median(next(iter(taken.values())))
    rows = [("what is moved", "median ms", "p95 ms", "median over the limit")]
    for what, numbers in taken.items():
        middle = statistics.median(numbers)
        rows.append((what, f"{middle:.0f}", f"{p95(numbers):.0f}", f"{middle / limit:.2f}"))
    show(f"From the key to the picture, {MOVES} moves each", rows)


if __name__ == "__main__":
    main()
