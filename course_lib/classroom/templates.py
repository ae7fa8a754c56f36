"""Homework as learners get it, made from its source: solutions and hidden tests out, cells locked, links set right.

It is made with nbgrader's own steps and the settings of `nbgrader_config.py`, so that a template is cell by cell what
`nbgrader generate_assignment` would release. Whether a template is stale can be asked without nbgrader.
"""

import hashlib
import json
import os
from copy import deepcopy
from pathlib import Path

from course_lib.classroom import require_nbgrader

SETTINGS = Path(__file__).with_name("nbgrader_config.py")


def template(source, *, made_from=""):
    """The learner's notebook made from the notebook `source`; its metadata record the source (`made_from` names it)."""
    require_nbgrader()
    from nbgrader.nbgraderformat import ValidationError
    from traitlets.config.loader import PyFileConfigLoader
    from traitlets.utils.importstring import import_item

    settings = PyFileConfigLoader(SETTINGS.name, path=str(SETTINGS.parent)).load_config()
    notebook, resources = deepcopy(source), {}  # the steps change what they get
    for name in settings.GenerateAssignment.preprocessors:
        if name.endswith(".SaveCells"):  # there is no gradebook here
            continue
        try:
            notebook, resources = import_item(name)(config=settings)(notebook, resources)
        except ValidationError as error:
            cause = error.__context__ or error  # the one in which nbgrader names the cell
            raise ValueError(f"not a source that nbgrader can take: {cause.message}") from None
    notebook.metadata["course"] = {"made_from": made_from, "sha256": fingerprint(source)}
    return notebook


def write_template(source_path, target_path):
    """Write the template of the notebook at `source_path` to `target_path`, without outputs."""
    require_nbgrader()
    import nbformat

    source_path, target_path = Path(source_path), Path(target_path)
    made_from = Path(os.path.relpath(source_path, target_path.parent)).as_posix()
    notebook = template(nbformat.read(source_path, as_version=4), made_from=made_from)
    nbformat.validate(notebook)
    nbformat.write(notebook, target_path)


def fingerprint(source):
    """A hash of everything in a source that its template is made of: types, texts and nbgrader metadata of its cells.

    Outputs do not count, so running a source changes nothing.
    """
    cells = [
        [cell["cell_type"], "".join(cell["source"]), cell["metadata"].get("nbgrader", {})] for cell in source["cells"]
    ]
    return hashlib.sha256(json.dumps(cells, sort_keys=True).encode()).hexdigest()


def is_stale(template, source):
    """Whether `source` has changed since `template` was made from it; both as notebooks or as parsed JSON."""
    return template["metadata"].get("course", {}).get("sha256") != fingerprint(source)
