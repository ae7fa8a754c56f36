"""Every notebook looks as a page of this course should, and its stored outputs are those of one run from the top.

That the outputs are *true* is checked by running them: pytest does so with nbval.
"""

import re
from itertools import pairwise
from pathlib import Path
from statistics import quantiles

import nbformat
import pytest

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS = ROOT / "notebooks"
LESSONS = sorted(NOTEBOOKS.glob("[0-9][0-9]_*.ipynb"))
PAGES = [*LESSONS, *sorted(NOTEBOOKS.glob("solutions/[0-9][0-9]_*.ipynb"))]


@pytest.fixture(params=PAGES, ids=lambda path: str(path.relative_to(NOTEBOOKS)))
def path(request):
    return request.param


@pytest.fixture
def page(path):
    return nbformat.read(path, as_version=4)


def code_cells(page):
    return [cell for cell in page.cells if cell.cell_type == "code"]


def code_lines(cell):
    return [line for line in cell.source.splitlines() if line.strip() and not line.strip().startswith("### ")]


def prose(page):
    return "\n".join(cell.source for cell in page.cells if cell.cell_type == "markdown")


def html_outputs(page):
    return [
        "".join(output.data["text/html"])
        for cell in code_cells(page)
        for output in cell.outputs
        if "text/html" in output.get("data", {})
    ]


def test_there_are_lessons():
    names = "00_start_here 01_mdp 02_bellman 03_q_table 04_homework_1 05_homework_2 06_dqn 07_homework_3 08_at_scale"
    assert [path.stem for path in LESSONS[:9]] == names.split()


def test_file_is_valid_and_tidy(page, path):
    nbformat.validate(page)
    assert page.metadata.kernelspec.name == "python3"
    assert path.stat().st_size < 1_000_000
    assert len({cell.id for cell in page.cells}) == len(page.cells)


def test_every_code_cell_was_run_once_in_order(page):
    assert [cell.execution_count for cell in code_cells(page)] == list(range(1, len(code_cells(page)) + 1))


def test_no_stored_output_is_an_error_or_a_warning(page):
    outputs = [output for cell in code_cells(page) for output in cell.outputs]
    assert [output for output in outputs if output.output_type == "error" or output.get("name") == "stderr"] == []


def test_cells_fit_the_eye(page):
    lengths = sorted(len(code_lines(cell)) for cell in code_cells(page))
    assert lengths[len(lengths) // 2] <= 8
    assert quantiles(lengths, n=10)[-1] <= 20
    assert lengths[-1] <= 40
    assert max(len(line) for cell in code_cells(page) for line in cell.source.splitlines()) <= 90


def test_no_cell_is_empty(page):
    assert all(cell.source.strip() for cell in page.cells)


def test_words_outweigh_code(page):
    words = len(prose(page).split())
    lines = sum(len(code_lines(cell)) for cell in code_cells(page))
    assert words / lines >= 8


def test_headings_are_in_order(page):
    levels = [len(marks) for marks in re.findall(r"^(#{1,6}) ", prose(page), flags=re.MULTILINE)]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_page_opens_and_closes_as_promised(page):
    opening = page.cells[0].source
    assert "**After this lesson you can**" in opening
    assert "minutes" in opening
    assert html_outputs(page)[0].startswith("<img"), "a picture comes first"
    for part in ("## Summary", "## Test yourself", "<details><summary>Answers</summary>", "**Next:**"):
        assert part in prose(page)


def test_every_picture_has_words(page):
    for output in (output for cell in code_cells(page) for output in cell.outputs if "data" in output):
        assert "image/png" not in output.data, "show a Picture, which carries its words, not a bare figure"
    for tag in re.findall(r"<img[^>]*>", " ".join(html_outputs(page))):
        alt = re.search(r'alt="([^"]*)"', tag)
        assert alt, "a picture without words"
        assert len(alt.group(1)) > 20
    assert re.findall(r"!\[\s*\]\(", prose(page)) == []


def test_a_sentence_follows_every_picture(page):
    for cell, following in pairwise(page.cells):
        shows = [output for output in cell.get("outputs", []) if "text/html" in output.get("data", {})]
        if shows:
            assert following.cell_type == "markdown" or following.outputs, f"nothing is said after {cell.source!r}"


def test_nothing_is_hidden(page):
    for cell in page.cells:
        assert not cell.metadata.get("jupyter", {}), "hidden source or output"
        assert not {"hide-input", "hide-cell", "remove-cell", "nbval-ignore-output"} & set(
            cell.metadata.get("tags", [])
        )
    for cell in code_cells(page):
        assert not re.search(
            r"import \*|^\s*[%!]|NBVAL|urlopen|requests\.|filterwarnings|;\s*$", cell.source, re.MULTILINE
        )


def test_links_lead_somewhere(page, path):
    for target in re.findall(r"\]\(([^)#\s]+)", prose(page)):
        if not target.startswith(("http://", "https://", "attachment:")):
            assert (path.parent / target).exists(), f"a dead link to {target}"


def test_page_is_about_the_course_alone(path):
    everything = path.read_text()
    for foreign in ("/home/", "/root/", "/tmp/", "Traceback"):
        assert foreign not in everything


def test_readme_holds_the_two_commands():
    readme = (ROOT / "README.md").read_text()
    assert "\npip install -r requirements.txt && jupyter lab notebooks/00_start_here.ipynb\n" in readme
    assert "\npip install -r requirements.txt && pytest\n" in readme
    for target in re.findall(r"\]\(([^)#\s]+)", readme):
        assert target.startswith("http") or (ROOT / target).exists(), f"a dead link to {target}"
