"""A homework half done, opened in a real JupyterLab: what the checks have to say can be read."""

import nbformat
import pytest

from .lab import NOTEBOOKS, THEMES, WIDTHS

HOMEWORK = "04_homework_1.ipynb"
# Goes back to the start after a bump; crashes with words that only look like HTML.
ANSWERS = {
    "task_1": "def play_on(maze, q_table, rng):\n"
    "    steps, over = 0, False\n"
    "    state, info = maze.reset()\n"
    "    while not over:\n"
    "        next_state, reward, terminated, truncated, info = maze.step(choose(q_table, state, rng))\n"
    "        update(q_table, state, 0, reward, next_state, terminated)\n"
    "        state, steps, over = next_state, steps + 1, terminated or truncated\n"
    "        if info['bumped']:\n"
    "            state, info = maze.reset()\n"
    "    return steps",
    "task_2": "def play_remembering(maze, q_table, rng):\n    raise ValueError('<script>alert(1)</script>')",
}


@pytest.fixture(scope="module")
def notebook(lab):
    """The homework with two wrong answers and a hint asked for, run to its end."""
    page = nbformat.read(NOTEBOOKS / HOMEWORK, as_version=4)
    for cell in page.cells:
        cell.source = ANSWERS.get(cell.metadata.get("nbgrader", {}).get("grade_id"), cell.source)
    page.cells.append(nbformat.v4.new_code_cell("checks.goes_on_after_a_bump.hint()"))
    nbformat.write(page, lab.server.folder / "half_done.ipynb")
    with lab.open("half_done.ipynb") as opened:
        opened.run_all()
        yield opened


def texts(notebook):
    return notebook.lab.page.locator(".jp-OutputArea-output").all_inner_texts()


def test_the_outcome_of_every_task_can_be_read(notebook):
    said = "\n".join(texts(notebook))
    assert "Task 1, a bump is not the end: not yet" in said
    assert "sends your mouse back to the start" in said
    assert "Task 3, training that stops by itself: not started" in said
    assert "Hint 1 of 4." in said


def test_words_of_the_learners_are_words(notebook):
    assert "<script>alert(1)</script>" in "\n".join(texts(notebook))


def test_no_cell_ends_in_an_error(notebook):
    assert [cell["errors"] for cell in notebook.look()["cells"] if cell["errors"]] == []
    assert notebook.complaints == []


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("width", WIDTHS)
def test_nothing_needs_scrolling_sideways(notebook, theme, width):
    notebook.dress(theme, width)
    assert notebook.too_wide() == []
