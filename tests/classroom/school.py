"""A small homework, a class for it, and ways to fill it in and hand it in."""

from copy import deepcopy
from pathlib import Path

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from course_lib.classroom.course import Course

HOMEWORK, NOTEBOOK = "homework_1", "04_homework_1.ipynb"
JUDGE, STAND_IN = "course_lib.classroom.judge.JudgePreprocessor", f"{__package__}.stand_in.StandIn"

RIGHT = {
    "double": "def double(number):\n    return 2 * number",
    "shout": "def shout(words):\n    return words.upper() + '!'",
}
# What a learner writes who looked at the public checks only.
NEARLY = {"double": "def double(number):\n    return {2: 4, 3: 6}[number]", "shout": RIGHT["shout"]}
HIDDEN = ("secret_number = 123456", "secret_words = 'quiet please'")
STUB = "raise NotImplementedError  # your code here"

FORMULA = "=cmd|' !A0"
ODD_NAMES = [
    "dö müller",
    ".eve",
    " spaced ",
    "a+b__c",
    "100%",
    "wild*[?]",
    "back\\slash",
    FORMULA,
    "{student_id}",
    "-x",
]


def tag(name, **flags):
    """The metadata of a cell that nbgrader knows as `name`."""
    kind = {"schema_version": 3, "grade_id": name, "grade": False, "solution": False, "locked": False, "task": False}
    return {"nbgrader": kind | flags}


def source_notebook():
    """A homework of two tasks with public and hidden tests, as its author writes it."""
    check = {"grade": True, "locked": True}
    cells = [
        new_markdown_cell("# Homework 1\n\nAfter [the table](../03_q_table.ipynb) ![maze](../pictures/maze.png)"),
        new_code_cell("import math", metadata=tag("imports", locked=True)),
        new_markdown_cell("## Task 1\n\nDouble a number.", metadata=tag("about_task_1", locked=True)),
        new_code_cell(
            "def double(number):\n    ### BEGIN SOLUTION\n    return 2 * number\n    ### END SOLUTION",
            metadata=tag("double", solution=True),
        ),
        new_code_cell(
            "task_1 = (double(2) == 4) + (double(3) == 6)\ntask_1\n\n"
            f"### BEGIN HIDDEN TESTS\n{HIDDEN[0]}\ntask_1 += 2 * (double(secret_number) == 246912)\n"
            "### END HIDDEN TESTS\n",
            metadata=tag("task_1", points=4, **check),
        ),
        new_markdown_cell("## Task 2\n\nShout.", metadata=tag("about_task_2", locked=True)),
        new_code_cell(f"### BEGIN SOLUTION\n{RIGHT['shout']}\n### END SOLUTION", metadata=tag("shout", solution=True)),
        new_code_cell(
            "task_2 = float(shout('hey') == 'HEY!')\ntask_2\n"
            f"### BEGIN HIDDEN TESTS\n{HIDDEN[1]}\ntask_2 += shout(secret_words) == 'QUIET PLEASE!'\n"
            "### END HIDDEN TESTS",
            metadata=tag("task_2", points=2, **check),
        ),
        new_markdown_cell("## Summary\n\nThat was it."),
    ]
    for number, cell in enumerate(cells):
        cell.id = f"cell-{number}"
    kernel = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
    return new_notebook(cells=cells, metadata={"kernelspec": kernel, "language_info": {"name": "python"}})


def released_notebook():
    """What learners get of it, but for checksums and locks; written down here, so that it needs no nbgrader."""
    notebook = source_notebook()
    notebook.cells[0].source = "# Homework 1\n\nAfter [the table](03_q_table.ipynb) ![maze](pictures/maze.png)"
    notebook.cells[3].source = f"def double(number):\n    {STUB}"
    notebook.cells[4].source = "task_1 = (double(2) == 4) + (double(3) == 6)\ntask_1"
    notebook.cells[6].source = STUB
    notebook.cells[7].source = "task_2 = float(shout('hey') == 'HEY!')\ntask_2"
    return notebook


def name_of(cell):
    """The name of a cell in nbgrader, or None."""
    return cell.metadata.get("nbgrader", {}).get("grade_id")


def cell_of(notebook, name):
    """The first cell that nbgrader knows as `name`."""
    return next(cell for cell in notebook.cells if name_of(cell) == name)


def filled_in(release, answers):
    """A copy of a released notebook with the text of cells replaced: `answers` {grade_id: source}."""
    notebook = deepcopy(release)
    for name, source in answers.items():
        cell_of(notebook, name).source = source
    return notebook


def with_tricks(release):
    """A nearly right homework in which check cells are gone, faked and copied, and nbgrader's own marks are misused."""
    notebook = filled_in(release, NEARLY)
    fake = deepcopy(cell_of(notebook, "task_1"))
    fake.source, fake.metadata.nbgrader["points"] = "task_1 = 4.0", 100
    notebook.cells.remove(cell_of(notebook, "task_1"))
    fake.id, again = "fake", deepcopy(fake)
    again.id = "fake-again"
    notebook.cells += [fake, again, new_code_cell("### BEGIN HIDDEN TESTS\nx = 1")]
    notebook.cells.append(new_markdown_cell("### BEGIN MARK SCHEME\n<b>mine</b>"))
    return notebook


def hand_in(course, learner, homework, notebook_or_bytes, name=None):
    """Put a notebook, or any bytes in its place, where a teacher collects it; returns the path."""
    folder = Path(course.folder) / "submitted" / learner / homework
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / (name or next((course.folder / "source" / homework).glob("*.ipynb")).name)
    if isinstance(notebook_or_bytes, bytes):
        path.write_bytes(notebook_or_bytes)
    else:
        nbformat.write(notebook_or_bytes, path)
    return path


def new_class(folder, *, judge=STAND_IN):
    """A class in `folder`/class with the small homework, graded by `judge`, and nothing released yet."""
    source = folder / NOTEBOOK
    nbformat.write(source_notebook(), source)
    course = Course.new(folder / "class", {HOMEWORK: source})
    settings = course.folder / "nbgrader_config.py"
    text = settings.read_text()
    assert JUDGE in text
    settings.write_text(text.replace(JUDGE, judge))
    return course
