"""Make the moving picture of README.md from the real thing: python -m tests.browser.readme_animation

The Q-learning explorer of lesson 3 in a real JupyterLab, its sliders moved by key; what is seen after each move becomes
one picture of a GIF.
"""

import io
import sys

import nbformat
from PIL import Image

from .hands import only_explorers
from .lab import NOTEBOOKS, find_browser, jupyter_lab, open_browser, open_lab

PLACE = NOTEBOOKS / "pictures" / "explorer.gif"
LESSON, EXPLORER = NOTEBOOKS / "03_q_table.ipynb", "The Q-learning explorer"
# (slider, key, how often): more exploring and less, a slippery floor, larger steps of learning
STORY = (
    ("exploring ε", "ArrowRight", 4),
    ("exploring ε", "ArrowLeft", 4),
    ("slip", "ArrowRight", 3),
    ("learning rate α", "ArrowRight", 3),
)
SHOWN, LINGER = 450, 1800  # milliseconds of a picture, and of the last one of each part of the story
COLOURS = 96


def taken(explorer):
    """What the explorer looks like now."""
    return Image.open(io.BytesIO(explorer.screenshot())).convert("RGB")


def answered(page, explorer):
    page.wait_for_function("root => root.dataset.idle === 'true'", arg=explorer.element_handle())


def tell(page, explorer):
    """(picture, milliseconds) after every move of the story."""
    yield taken(explorer), LINGER
    for label, key, times in STORY:
        slider = explorer.locator("label", has_text=label).locator("input")
        slider.focus()
        for move in range(times):
            page.keyboard.press(key)
            answered(page, explorer)
            yield taken(explorer), LINGER if move == times - 1 else SHOWN


def main():
    program = find_browser() or sys.exit("needs a browser")
    with jupyter_lab() as server, open_browser(program) as browser, open_lab(browser, server) as lab:
        nbformat.write(only_explorers(LESSON), server.folder / "told.ipynb")
        with lab.open("told.ipynb") as notebook:
            notebook.run_all()
            pictures, shown = zip(*tell(lab.page, lab.page.get_by_label(EXPLORER)), strict=True)
    # one palette for all, so that only what changes is stored anew
    palette = pictures[-1].quantize(colors=COLOURS, dither=Image.Dither.NONE)
    first, *others = [one.quantize(palette=palette, dither=Image.Dither.NONE) for one in pictures]
    first.save(PLACE, save_all=True, append_images=others, duration=list(shown), loop=0, optimize=True)
    print(f"{PLACE.name}: {len(pictures)} pictures, {PLACE.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
