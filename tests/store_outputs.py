"""Run notebooks from a fresh kernel and store what they print: python tests/store_outputs.py [notebook …]

Run it after a change to a lesson, then look at what changed (`git diff`): the stored outputs are what nbval expects.
Without arguments it takes every notebook of the course.
"""

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

_KEPT = ("nbgrader", "tags", "deletable", "editable")
_WIDGET = "application/vnd.jupyter.widget-view+json"
NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"


def tidy(notebook):
    """Only what a reader needs: no editor's settings, no times, no machine."""
    kernel = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
    course = {"course": notebook.metadata.course} if "course" in notebook.metadata else {}  # what a template is made of
    notebook.metadata = {"kernelspec": kernel, "language_info": {"name": "python"}, **course}
    for cell in notebook.cells:
        cell.metadata = {key: value for key, value in cell.metadata.items() if key in _KEPT}
        for output in cell.get("outputs", []):
            output.get("data", {}).pop(_WIDGET, None)  # it lives in a kernel; what is stored is its still picture
    return notebook


def store(path):
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": path.parent}}
    ).execute()
    nbformat.validate(tidy(notebook))
    nbformat.write(notebook, path)


if __name__ == "__main__":
    chosen = [Path(name).resolve() for name in sys.argv[1:]] or sorted(NOTEBOOKS.rglob("[0-9]*.ipynb"))
    for notebook_path in chosen:
        store(notebook_path)
        print(f"stored {notebook_path.name}")
