"""What learners do to check cells and others that are ours, by accident or not, and what is graded in the end."""

from copy import deepcopy

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_output

from course_lib.classroom.rebuild import Cell, rebuild

from .school import RIGHT, STUB, cell_of, filled_in, name_of, released_notebook, tag

RELEASE = released_notebook()
SOLVED = filled_in(RELEASE, RIGHT)
TITLE, IMPORTS, ABOUT_1, DOUBLE, TASK_1, ABOUT_2, SHOUT, TASK_2, SUMMARY = range(9)


def rebuilt(cells):
    """(what stands there, remarks), each cell as its name in nbgrader or else its text."""
    handed_in = [Cell(cell.cell_type, cell.source, cell.metadata.get("nbgrader", {})) for cell in cells]
    notebook, remarks = rebuild(handed_in, RELEASE)
    nbformat.validate(notebook)
    for ours in RELEASE.cells:
        if name_of(ours) and not ours.metadata.nbgrader.solution:
            for cell in notebook.cells:
                assert name_of(cell) != name_of(ours) or {**cell} == {**ours}, "in our words, with our metadata"
    return [name_of(cell) or cell.source.partition("\n")[0] for cell in notebook.cells], remarks


def own(source):
    return new_code_cell(source)


@pytest.fixture
def cells():
    return deepcopy(SOLVED).cells


AS_RELEASED = [
    "# Homework 1",
    "imports",
    "about_task_1",
    "double",
    "task_1",
    "about_task_2",
    "shout",
    "task_2",
    "## Summary",
]


def test_what_was_not_touched_stays(cells):
    assert rebuilt(cells) == (AS_RELEASED, [])


# --- check cells ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["task_1 = 4", "", "task_1 = 4.0\ntask_1", "# nothing"])
def test_a_changed_check_cell_is_restored(cells, text):
    cells[TASK_1].source = text
    assert rebuilt(cells) == (AS_RELEASED, ["The check cell task_1 had been changed; it was restored."])


@pytest.mark.parametrize(
    "changes", [{"points": 100}, {"grade": False}, {"solution": True}, {"locked": False}, {"points": None}]
)
def test_a_check_cell_with_other_flags_is_restored(cells, changes):
    cells[TASK_1].metadata.nbgrader.update(changes)
    assert rebuilt(cells) == (AS_RELEASED, ["The check cell task_1 had been changed; it was restored."])


def test_a_check_cell_of_another_type_is_restored(cells):
    cells[TASK_1] = new_markdown_cell(cells[TASK_1].source, metadata=cells[TASK_1].metadata)
    assert rebuilt(cells) == (AS_RELEASED, ["The check cell task_1 had been changed; it was restored."])


def test_blank_lines_at_the_end_are_no_change(cells):
    cells[TASK_1].source += "\n\n"
    assert rebuilt(cells) == (AS_RELEASED, [])


@pytest.mark.parametrize("at", [TASK_1, TASK_2])
def test_a_deleted_check_cell_is_put_back(cells, at):
    name = name_of(cells.pop(at))
    assert rebuilt(cells) == (AS_RELEASED, [f"The check cell {name} had been deleted; it was put back."])


def test_a_copied_check_cell_counts_once(cells):
    for at in (0, TASK_2, len(cells)):
        cells.insert(at, deepcopy(SOLVED.cells[TASK_1]))
    assert rebuilt(cells) == (AS_RELEASED, ["The check cell task_1 was there 4 times; it counts once."])


@pytest.mark.parametrize("to", range(9))
def test_a_moved_check_cell_goes_back_to_its_task(cells, to):
    cells.insert(to, cells.pop(TASK_1))
    assert rebuilt(cells) == (AS_RELEASED, [])


def test_check_cells_with_each_others_names_get_their_own_back(cells):
    cells[TASK_1].metadata, cells[TASK_2].metadata = cells[TASK_2].metadata, cells[TASK_1].metadata
    assert rebuilt(cells)[0] == AS_RELEASED


def test_cells_of_the_learners_own_that_pose_as_check_cells_are_dropped(cells):
    fake = new_code_cell("task_2 = 2.0", metadata=tag("task_2", grade=True, points=2, locked=True))
    cells.append(fake)
    order, remarks = rebuilt(cells)
    assert order == AS_RELEASED
    assert "The check cell task_2 had been changed; it was restored." in remarks


def test_an_unknown_name_makes_no_check_cell(cells):
    cells.append(new_code_cell("bonus = 100", metadata=tag("bonus", grade=True, points=100)))
    assert rebuilt(cells) == (
        [*AS_RELEASED, "bonus = 100"],
        ["Tags that are not of this homework were taken from cells: 1."],
    )


def test_a_solution_cell_cannot_be_given_points(cells):
    cells[DOUBLE].metadata.nbgrader.update(grade=True, points=100)
    handed_in = [Cell(cell.cell_type, cell.source, cell.metadata.get("nbgrader", {})) for cell in cells]
    assert cell_of(rebuild(handed_in, RELEASE)[0], "double").metadata == RELEASE.cells[DOUBLE].metadata


# --- where check cells go ---------------------------------------------------------------------------------------------


def test_own_cells_stay_where_they_are_and_a_check_comes_last_in_its_task(cells):
    cells[TASK_1:ABOUT_2] = [own("a"), cells[TASK_1], own("b")]
    cells.append(own("c"))
    order, remarks = rebuilt(cells)
    assert order == [*AS_RELEASED[:TASK_1], "a", "b", "task_1", *AS_RELEASED[ABOUT_2:], "c"]
    assert remarks == []


def test_a_solution_may_stand_in_another_cell(cells):
    cells[DOUBLE : TASK_1 + 1] = [own("def double"), cells[TASK_1]]
    order, remarks = rebuilt(cells)
    assert order == [*AS_RELEASED[:DOUBLE], "def double", *AS_RELEASED[TASK_1:]]
    assert remarks == []


def test_where_the_next_task_has_lost_its_text_its_solution_tells_where_it_begins(cells):
    del cells[ABOUT_2]
    cells.insert(ABOUT_2, own("a"))
    assert rebuilt(cells)[0] == [*AS_RELEASED[:TASK_1], "a", "task_1", "shout", "task_2", "## Summary"]


def test_where_nothing_else_is_left_of_a_task_its_check_cell_tells_where_it_is(cells):
    cells = [own("a"), cells[TASK_1], own("b"), cells[TASK_2], own("c")]
    order = rebuilt(cells)[0]
    assert [name for name in order if name != "imports"] == ["a", "b", "task_1", "c", "task_2"]


def test_a_learner_may_do_the_second_task_first(cells):
    first, second = cells[ABOUT_1 : TASK_1 + 1], cells[ABOUT_2 : TASK_2 + 1]
    order = rebuilt([*cells[:ABOUT_1], *second, *first])[0]
    assert order == ["# Homework 1", "imports", *AS_RELEASED[ABOUT_2:SUMMARY], *AS_RELEASED[ABOUT_1:ABOUT_2]]


def test_a_solution_that_moved_down_is_still_checked_after_it_ran(cells):
    cells.append(cells.pop(DOUBLE))
    order = rebuilt(cells)[0]
    assert order.index("task_1") > order.index("double")
    assert sorted(order) == sorted(AS_RELEASED)


def test_nothing_left_but_own_cells():
    order, remarks = rebuilt([own("a"), own("b")])
    assert order == ["imports", "a", "b", "task_1", "task_2"]
    assert len(remarks) == 3


def test_where_all_tags_were_lost_texts_tell_which_cell_is_which(cells):
    for cell in cells:
        cell.metadata = {}
    order, _ = rebuilt(cells)
    assert order == [
        *AS_RELEASED[:DOUBLE],
        "def double(number):",
        *AS_RELEASED[TASK_1:SHOUT],
        "def shout(words):",
        *AS_RELEASED[TASK_2:],
    ]


# --- other cells ------------------------------------------------------------------------------------------------------


def test_a_read_only_text_is_restored(cells):
    cells[ABOUT_1].source = "## Task 1\n\nDo nothing."
    assert rebuilt(cells) == (AS_RELEASED, ["The read-only cell about_task_1 had been changed; it was restored."])


def test_what_was_added_to_read_only_code_runs_after_it(cells):
    cells[IMPORTS].source = "import math, cmath"
    order, remarks = rebuilt(cells)
    assert order == [*AS_RELEASED[:ABOUT_1], "import math, cmath", *AS_RELEASED[ABOUT_1:]]
    assert remarks == ["The read-only cell imports had been changed; it was restored."]


@pytest.mark.parametrize("before", [[], [TITLE]])
def test_deleted_read_only_code_is_put_back_before_what_may_need_it(cells, before):
    order, remarks = rebuilt([*(cells[at] for at in before), own("a"), *cells[ABOUT_1:]])
    assert order == [*AS_RELEASED[: len(before)], "imports", "a", *AS_RELEASED[ABOUT_1:]]
    assert remarks == ["The cell imports had been deleted; it was put back."]


def test_a_deleted_text_is_not_missed(cells):
    del cells[ABOUT_2]
    assert rebuilt(cells) == ([name for name in AS_RELEASED if name != "about_task_2"], [])


def test_a_copy_of_read_only_code_runs_again(cells):
    cells.insert(TASK_1, deepcopy(cells[IMPORTS]))
    assert rebuilt(cells)[0] == [*AS_RELEASED[:TASK_1], "import math", *AS_RELEASED[TASK_1:]]


def test_a_deleted_stub_is_not_put_back_where_it_would_undo_the_solution(cells):
    cells[DOUBLE] = own(RIGHT["double"])
    handed_in = [Cell(cell.cell_type, cell.source, cell.metadata.get("nbgrader", {})) for cell in cells]
    assert STUB not in "".join(cell.source for cell in rebuild(handed_in, RELEASE)[0].cells)


def test_of_a_solution_cell_that_was_copied_all_run_and_the_last_has_the_name(cells):
    again = deepcopy(cells[DOUBLE])
    again.source = "def double(number): return 0"
    cells.insert(DOUBLE, again)
    order, remarks = rebuilt(cells)
    assert order == [*AS_RELEASED[:DOUBLE], "def double(number): return 0", *AS_RELEASED[DOUBLE:]]
    assert remarks == ["The solution cell double was there 2 times; all ran, in their order."]


def test_a_solution_that_became_a_text_is_code_again(cells):
    cells[DOUBLE] = new_markdown_cell(cells[DOUBLE].source, metadata=cells[DOUBLE].metadata)
    handed_in = [Cell(cell.cell_type, cell.source, cell.metadata.get("nbgrader", {})) for cell in cells]
    assert cell_of(rebuild(handed_in, RELEASE)[0], "double").cell_type == "code"


def test_a_graded_answer_that_was_deleted_is_put_back_so_that_it_has_a_grade():
    release = deepcopy(RELEASE)
    answer = new_markdown_cell("*Your answer here.*", metadata=tag("why", grade=True, solution=True, points=3))
    release.cells.insert(ABOUT_2 + 1, answer)
    handed_in = [Cell(cell.cell_type, cell.source, cell.metadata.get("nbgrader", {})) for cell in SOLVED.cells]
    notebook, remarks = rebuild(handed_in, release)
    assert [name_of(cell) for cell in notebook.cells][ABOUT_2 : TASK_2 + 1] == ["about_task_2", "why", "shout"]
    assert remarks == ["The cell why had been deleted; it was put back."]
    handed_in.insert(ABOUT_2 + 1, Cell("markdown", "Because.", answer.metadata.nbgrader))
    assert cell_of(rebuild(handed_in, release)[0], "why").source == "Because."


def test_two_check_cells_of_a_task_stay_together():
    release = deepcopy(RELEASE)
    release.cells.insert(ABOUT_2, new_code_cell("task_1b", metadata=tag("task_1b", grade=True, points=1, locked=True)))
    handed_in = [Cell(cell.cell_type, cell.source, cell.metadata.get("nbgrader", {})) for cell in SOLVED.cells]
    handed_in.insert(ABOUT_2, Cell("code", "a", {}))
    notebook, _ = rebuild(handed_in, release)
    assert [name_of(cell) for cell in notebook.cells][TASK_1 : ABOUT_2 + 3] == [
        None,
        "task_1",
        "task_1b",
        "about_task_2",
    ]


def test_a_release_with_outputs_lends_none():
    release = deepcopy(RELEASE)
    release.cells[IMPORTS].outputs, release.cells[IMPORTS].execution_count = [new_output("stream", text="7")], 7
    for cells in (None, [Cell("code", "import math", release.cells[IMPORTS].metadata.nbgrader)]):
        cell = cell_of(rebuild(cells, release)[0], "imports")
        assert (cell.outputs, cell.execution_count) == ([], None)


def test_the_release_itself_is_never_changed(cells):
    before = deepcopy(RELEASE)
    notebook, _ = rebuild([], RELEASE)
    for cell in notebook.cells:
        cell.source = "changed"
    rebuilt(cells)
    assert before == RELEASE
