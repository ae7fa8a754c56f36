"""Every lesson, opened in a real JupyterLab as a learner opens it: first as it comes, then run from top to bottom."""

import re
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import nbformat
import pytest

from .lab import LESSONS, NOTEBOOKS, ROOT, THEMES, WIDGET_WORDS, WIDTHS, jupyter_lab, listen


@dataclass(repr=False)
class Lesson:
    """What was seen of one lesson."""

    path: Path
    stored: dict  # before it was run
    run: dict  # after
    cramped: list[str]
    too_wide: list[str]
    complaints: list[str]


@pytest.fixture(scope="module", params=LESSONS, ids=lambda path: path.stem)
def lesson(request, lab):
    """One lesson, opened and run once for all tests."""
    with lab.open(request.param.name) as notebook:
        notebook.dress("light", WIDTHS[0])
        stored = notebook.look()
        notebook.run_all()
        cramped = notebook.cramped()
        run = notebook.look()
        too_wide = []
        for theme in THEMES:
            for width in WIDTHS:
                notebook.dress(theme, width)
                too_wide += [f"{theme} {width}: {fault}" for fault in notebook.too_wide()]
        return Lesson(request.param, stored, run, cramped, too_wide, notebook.complaints)


def none(faults):
    """For assertions: that there are no faults, and a list of them where there are."""
    assert not faults, "\n".join(faults)


def code_cells(look):
    return [cell for cell in look["cells"] if cell["type"] == "code"]


def test_every_cell_runs_without_an_error(lesson):
    faults = {cell["index"]: cell["errors"] + cell["warnings"] for cell in code_cells(lesson.run)}
    none([f"cell {index}: {fault}" for index in faults for fault in faults[index]])
    assert [cell["count"] for cell in code_cells(lesson.run)] == list(range(1, len(code_cells(lesson.run)) + 1))


def test_the_browser_does_not_complain(lesson):
    none(lesson.complaints)


def test_every_picture_is_drawn_and_has_words(lesson):
    for image in lesson.run["images"]:
        assert image["width"] > 0, f"not loaded: {image}"
        assert image["alt"], f"without words: {image}"


def test_formulas_are_set(lesson):
    none(lesson.run["badFormulas"])


def test_links_lead_to_files(lesson):
    """As JupyterLab resolves them: it is started in the notebooks' folder and serves nothing above it."""
    links = lesson.run["links"]
    none(links["dead"])
    for link in links["files"]:
        assert (NOTEBOOKS / link.removeprefix("/files/")).is_file(), f"a dead link to {link}"


def test_nothing_is_too_wide(lesson):
    none(lesson.too_wide)


def test_code_and_printed_tables_fit_a_laptop(lesson):
    none(lesson.cramped)


def test_lesson_is_whole_before_it_is_run(lesson):
    """A learner's first look: a file from elsewhere, so JupyterLab does not trust it, and no cell was run."""
    assert not any(cell["trusted"] for cell in code_cells(lesson.stored))
    promised = [pictures_in(cell) for cell in nbformat.read(lesson.path, as_version=4).cells]
    shown = [cell["pictures"] if cell["type"] == "code" else 0 for cell in lesson.stored["cells"]]
    assert shown == promised
    assert all(image["width"] > 0 for image in lesson.stored["images"])
    none([cell["text"] for cell in lesson.stored["cells"] if WIDGET_WORDS.search(cell["text"])])


def pictures_in(cell):
    """How many pictures the stored outputs of a cell hold."""
    bundles = [output.data for output in cell.get("outputs", []) if "data" in output]
    tags = [len(re.findall("<img|<svg", bundle.get("text/html", ""))) for bundle in bundles]
    images = [any(kind.startswith("image/") for kind in bundle) for bundle in bundles]
    return sum(tag or image for tag, image in zip(tags, images, strict=True))


@pytest.fixture(scope="module")
def front_page(browser):
    """What a learner sees after the command of README.md, in a JupyterLab that nobody has set up."""
    command = re.search(r"&& (jupyter lab \S+)", (ROOT / "README.md").read_text()).group(1)
    with jupyter_lab(command.split(), settings={}) as server:
        page = browser.new_page(viewport={"width": WIDTHS[0], "height": 800})
        complaints = listen(page, server)
        page.goto(server.first_page())
        page.wait_for_selector(".jp-NotebookPanel .jp-Cell img")
        yield SimpleNamespace(page=page, complaints=complaints)
        page.close()


def current_tab(page):
    return page.locator("#jp-main-dock-panel .lm-mod-current .lm-TabBar-tabLabel").all_inner_texts()


def test_readme_command_opens_the_first_lesson_with_the_files_beside_it(front_page):
    page = front_page.page
    assert current_tab(page) == [LESSONS[0].name]
    files = page.locator(".jp-DirListing-item")
    files.first.wait_for()
    assert {path.name for path in LESSONS} <= set(page.locator(".jp-DirListing-itemName").all_inner_texts())
    beside, lesson = files.first.bounding_box(), page.locator(".jp-NotebookPanel").bounding_box()
    assert beside["x"] + beside["width"] <= lesson["x"]
    assert lesson["width"] > WIDTHS[0] / 2
    none(front_page.complaints)


def test_link_to_the_next_lesson_opens_it_here(front_page):
    page = front_page.page
    page.locator('.jp-RenderedMarkdown a[href*=".ipynb"]').last.click()
    page.wait_for_function("document.querySelectorAll('.jp-NotebookPanel').length === 2")
    assert current_tab(page) == [LESSONS[1].name]
    none(front_page.complaints)
