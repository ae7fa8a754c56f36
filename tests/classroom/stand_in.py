"""A judge for tests of what surrounds a judge: it runs everything in this process, with no defence at all."""

import contextlib
import io

from nbformat.v4 import new_output
from nbgrader.preprocessors import NbGraderPreprocessor


class StandIn(NbGraderPreprocessor):
    """Gives each check cell the points that a variable of its name holds after it ran; 0 where it does not come so far.

    A notebook with the words "break the judge" breaks it.
    """

    def preprocess(self, notebook, resources):
        names = {}
        for cell in (cell for cell in notebook.cells if cell.cell_type == "code"):
            if "break the judge" in cell.source:
                raise RuntimeError("the judge is broken")
            with contextlib.suppress(Exception), contextlib.redirect_stdout(io.StringIO()):
                exec(cell.source, names)
            tag = cell.metadata.get("nbgrader", {})
            if tag.get("grade"):
                points = float(names.get(tag["grade_id"], 0.0))
                cell.outputs = [new_output("execute_result", {"text/plain": repr(points), "text/html": "a table"})]
        return notebook, resources
