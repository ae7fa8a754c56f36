"""Pictures of whole lessons, to be looked at by people: python -m tests.browser.screenshots OUT_FOLDER [notebook …]

Every notebook is run, then taken in light and dark, wide and narrow, in pages of about 2,000 pixels. Without notebooks,
every lesson. What the tests would complain about is printed too.
"""

import shutil
import sys
from pathlib import Path

from .lab import BROWSERS, LESSONS, NOTEBOOKS, THEMES, WIDTHS, find_browser, jupyter_lab, open_browser, open_lab


def name_in(server, path):
    """Where the server finds a notebook: those from elsewhere are copied beside the lessons."""
    path = Path(path).resolve()
    if path.is_relative_to(NOTEBOOKS):
        return path.relative_to(NOTEBOOKS).as_posix()
    shutil.copy(path, server.folder / path.name)
    return path.name


def take(notebook, folder):
    """Run a notebook and write its pictures. Gives their number, and what there is to complain about."""
    notebook.run_all()
    complaints = [f"cell {cell['index']}: {error}" for cell in notebook.look()["cells"] for error in cell["errors"]]
    written = 0
    for theme in THEMES:
        for width in WIDTHS:
            notebook.dress(theme, width, height=2200)
            complaints += [f"{theme} {width}: {fault}" for fault in notebook.too_wide()]
            written += notebook.screenshots(folder, f"{Path(notebook.name).stem}_{theme}_{width}")
    return written, complaints + notebook.complaints


def main(folder, *paths):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    program = find_browser() or sys.exit(f"needs one of {', '.join(BROWSERS)}")
    with jupyter_lab() as server, open_browser(program) as browser, open_lab(browser, server) as lab:
        for path in paths or LESSONS:
            with lab.open(name_in(server, path)) as notebook:
                written, complaints = take(notebook, folder)
            print(f"{notebook.name}: {written} pictures", *complaints, sep="\n    ")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(*sys.argv[1:])
