"""The judge in nbgrader's pipeline: the learner's cells run in a process of their own, the check cells run here.

A check cell is taken from the gradebook, never from the submission. Where it names a function of the learner's it gets
a `There`, which calls that function in the learner's process; the worlds it plays in and the verdict never leave here.
"""

import ast
import builtins

from nbformat.v4 import new_output
from nbgrader.api import Gradebook, MissingEntry
from nbgrader.preprocessors import NbGraderPreprocessor
from nbgrader.utils import is_grade
from traitlets import Float, Integer

from course_lib.checks.verdict import Verdict
from course_lib.classroom.process import Limits, There
from course_lib.classroom.session import Session


class JudgePreprocessor(NbGraderPreprocessor):
    """Stands where nbgrader's `Execute` would: fills the outputs of all cells up to the last check."""

    time_limit = Float(30.0, help="seconds that a cell, or a call of a learner's function, may take").tag(config=True)
    total_time_limit = Float(300.0, help="seconds that a whole submission may take").tag(config=True)
    memory_limit = Integer(4_000_000_000, help="bytes of memory").tag(config=True)
    output_limit = Integer(10_000_000, help="bytes of prints").tag(config=True)

    def preprocess(self, nb, resources):
        """Run the learner's cells, judge the check cells; never raises for what a learner has written."""
        limits = Limits(self.time_limit, self.memory_limit, self.output_limit)
        trusted, imports = self._trusted_cells(resources["nbgrader"])
        checks = [i for i, cell in enumerate(nb.cells) if _grade_id(cell) in trusted]
        with Session(resources["metadata"]["path"], limits, self.total_time_limit) as session:
            for i, cell in enumerate(nb.cells[: checks[-1] + 1] if checks else []):
                if i in checks:
                    points, source = trusted[_grade_id(cell)]
                    cell.outputs = [judged(source, imports, session, points)]
                elif cell.cell_type == "code":
                    cell.outputs = _outputs(*session.run(cell.source))
        return nb, resources

    def _trusted_cells(self, names):
        """{grade_id: (points, source)} of the check cells, and the imports of checks, as the gradebook has them."""
        with Gradebook(names["db_url"]) as gradebook:
            notebook = gradebook.find_notebook(names["notebook"], names["assignment"])
            sources = {cell.name: cell.source for cell in notebook.source_cells if cell.cell_type == "code"}
            trusted = {}
            for name, source in sources.items():
                try:
                    cell = gradebook.find_grade_cell(name, names["notebook"], names["assignment"])
                except MissingEntry:
                    continue
                trusted[name] = cell.max_score, source
            read_only = [cell.source for cell in notebook.source_cells if cell.cell_type == "code" and cell.locked]
        return trusted, [line for source in read_only for line in imports_of_checks(source)]


def _grade_id(cell):
    return cell.metadata.nbgrader.get("grade_id") if cell.cell_type == "code" and is_grade(cell) else None


def imports_of_checks(source):
    """The lines of a cell that import from `course_lib.checks`: what its check cells need to be run elsewhere."""
    for node in ast.parse(source).body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("course_lib.checks"):
            yield ast.unparse(node)


def judged(source, imports, session, points):
    """The output of a check cell worth `points`: nbgrader reads the score from its plain text; an error is worth 0."""
    names = _Names(session)
    for line in imports:
        exec(line, names.builtins, names)
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    try:
        exec(compile(tree, "check", "exec"), names.builtins, names)
        value = eval(compile(ast.Expression(last.value), "check", "eval"), names.builtins, names) if last else None
    except Exception as error:  # an assertion of the teacher's, or a value that it did not expect
        return _outputs("", f"{type(error).__name__}: {error}")[0]
    if isinstance(value, Verdict):
        score = points * value.points / value.max_points
        return new_output("execute_result", {"text/plain": repr(score), "text/html": value.html()}, execution_count=1)
    if isinstance(value, There):
        return _outputs("", f"NameError: {value.name} is neither defined by this check cell nor called")[0]
    score = points  # as in nbgrader: a cell that raises nothing, and ends in no number, has passed
    if isinstance(value, bool):
        score = points * value
    elif isinstance(value, (int, float)):
        score = min(max(0.0, float(value)), points)
    return new_output("execute_result", {"text/plain": repr(score)}, execution_count=1)


def _outputs(printed, error):
    """As a notebook keeps them."""
    outputs = [new_output("stream", name="stdout", text=printed)] if printed else []
    if error:
        name, _, words = error.partition(": ")
        outputs.append(new_output("error", ename=name, evalue=words, traceback=[error]))
    return outputs


class _Names(dict):
    """What a check cell may name: what it has defined itself, and else functions of the learner's."""

    def __init__(self, session):
        super().__init__()
        self.builtins, self._session = {"__builtins__": builtins}, session

    def __missing__(self, name):
        if hasattr(builtins, name):
            raise KeyError(name)
        return There(name, self._session.process)
