"""Files that a learner may hand in: whatever they are, a notebook comes back that can be graded."""

import json
import os
import random

import nbformat
import pytest
from hypothesis import given
from hypothesis import strategies as st

from course_lib.classroom import submissions
from course_lib.classroom.submissions import LARGEST_FILE, LONGEST_WORDS, MOST_TEXT, read_submission

from .school import HIDDEN, NOTEBOOK, RIGHT, cell_of, filled_in, name_of, released_notebook

RELEASE = released_notebook()
SOLVED = filled_in(RELEASE, RIGHT)


def read(folder):
    submission = read_submission(folder, RELEASE, NOTEBOOK)
    nbformat.validate(submission.notebook)
    nbformat.writes(submission.notebook).encode()
    assert [name_of(cell) for cell in submission.notebook.cells if name_of(cell) in ("task_1", "task_2")] == [
        "task_1",
        "task_2",
    ]
    assert all(remark.endswith(".") and remark.isprintable() for remark in submission.remarks)
    return submission


def texts(notebook):
    return [cell.source for cell in notebook.cells]


def put(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else nbformat.writes(content).encode())
    return path


def is_untouched(submission):
    return texts(submission.notebook) == texts(RELEASE)


def is_solved(submission):
    return texts(submission.notebook) == texts(SOLVED)


# --- notebooks that are fine ------------------------------------------------------------------------------------------


def test_a_notebook_as_asked_for_comes_without_a_remark(tmp_path):
    put(tmp_path / NOTEBOOK, SOLVED)
    submission = read(tmp_path)
    assert is_solved(submission)
    assert submission.remarks == ()


def test_the_release_itself_comes_back_as_it_is(tmp_path):
    put(tmp_path / NOTEBOOK, RELEASE)
    assert is_untouched(read(tmp_path))
    assert read(tmp_path).remarks == ()


def test_outputs_are_never_looked_at(tmp_path):
    handed_in = json.loads(nbformat.writes(SOLVED))
    for outputs in (["x" * 10_000_000], "nonsense", 5, None, {"a": [[]]}):
        handed_in["cells"][3]["outputs"] = outputs
        put(tmp_path / NOTEBOOK, json.dumps(handed_in).encode())
        submission = read(tmp_path)
        assert is_solved(submission)
        assert submission.remarks == ()
        assert all(cell.outputs == [] for cell in submission.notebook.cells if cell.cell_type == "code")


def test_grading_twice_gives_the_same_cells_to_the_last_id(tmp_path):
    put(tmp_path / NOTEBOOK, filled_in(SOLVED, {"imports": "import cmath"}))
    assert read(tmp_path) == read(tmp_path)


def test_what_comes_back_can_be_handed_in_again(tmp_path):
    put(tmp_path / NOTEBOOK, filled_in(SOLVED, {"imports": "import cmath", "task_1": "task_1 = 4"}))
    first = read(tmp_path).notebook
    put(tmp_path / NOTEBOOK, first)
    assert read(tmp_path) == submissions.Submission(first, ())


@pytest.mark.parametrize("marks", ["\ufeff", ""])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_any_unicode_that_json_may_be_written_in_is_read(tmp_path, encoding, marks):
    solved = filled_in(SOLVED, {"shout": f"# größer\n{RIGHT['shout']}"})
    put(tmp_path / NOTEBOOK, (marks * (encoding == "utf-8") + nbformat.writes(solved)).encode(encoding))
    assert cell_of(read(tmp_path).notebook, "shout").source.startswith("# größer")
    assert read(tmp_path).remarks == ()


# --- older and newer formats ------------------------------------------------------------------------------------------


def test_format_3_is_read(tmp_path):
    old = {"nbformat": 3, "nbformat_minor": 0, "metadata": {}, "worksheets": [{"cells": []}]}
    for cell in SOLVED.cells:
        named = {"cell_type": cell.cell_type, "metadata": cell.metadata}
        key = "input" if cell.cell_type == "code" else "source"
        old["worksheets"][0]["cells"].append(named | {key: cell.source.splitlines(keepends=True)})
    old["worksheets"][0]["cells"].append({"cell_type": "heading", "level": 2, "source": "The end", "metadata": {}})
    put(tmp_path / NOTEBOOK, json.dumps(old).encode())
    submission = read(tmp_path)
    assert texts(submission.notebook) == [*texts(SOLVED), "The end"]
    assert submission.notebook.nbformat == 4


@pytest.mark.parametrize("version", [1, 5, 99, "four", None, [4]])
def test_a_wrong_version_number_harms_nothing(tmp_path, version):
    handed_in = json.loads(nbformat.writes(SOLVED)) | {"nbformat": version}
    put(tmp_path / NOTEBOOK, json.dumps(handed_in).encode())
    assert is_solved(read(tmp_path))


# --- files that are no notebook ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty"),
        (b" \n\t", "is empty"),
        (b"{", "is not JSON"),
        (nbformat.writes(SOLVED)[:900].encode(), "is not JSON"),
        (b"PK\x03\x04\xff\xfe\x00", "is not JSON"),
        (bytes(range(256)), "is not JSON"),
        (b"[" * 200_000, "is not JSON"),
        (b'{"cells": [' + b"9" * 10_000 + b"]}", "is not JSON"),
        (b"[]", "is not a notebook"),
        (b"null", "is not a notebook"),
        (b'"cells"', "is not a notebook"),
        (b"NaN", "is not a notebook"),
        (b'{"cells": 5}', "is not a notebook"),
        (b'{"worksheets": {}}', "is not a notebook"),
        (b"[" * 3_000_001, "holds far more than a notebook does"),
    ],
    ids=range(15),
)
def test_a_file_that_is_no_notebook_leaves_the_release(tmp_path, content, said):
    put(tmp_path / NOTEBOOK, content)
    submission = read(tmp_path)
    assert is_untouched(submission)
    assert f"{NOTEBOOK} {said}" in submission.remarks[0]
    assert submission.remarks[-1].startswith("Nothing to grade")


@pytest.mark.parametrize("notebook", [{"cells": []}, {"worksheets": []}, {"worksheets": [5, {"cells": 3}]}])
def test_a_notebook_without_cells_has_check_cells_all_the_same(tmp_path, notebook):
    put(tmp_path / NOTEBOOK, json.dumps(notebook).encode())
    submission = read(tmp_path)
    assert [name_of(cell) for cell in submission.notebook.cells] == ["imports", "task_1", "task_2"]
    assert "No cell of it has a tag of this homework." in submission.remarks


def test_a_file_too_large_is_not_even_read(tmp_path):
    with open(tmp_path / NOTEBOOK, "wb") as file:
        file.truncate(1_000_000_000)
    submission = read(tmp_path)
    assert is_untouched(submission)
    assert f"is larger than {LARGEST_FILE // 1_000_000} MB" in submission.remarks[0]


BAD_CELLS = [
    {"cell_type": "code", "metadata": {}},
    {"cell_type": "code", "source": 5, "metadata": {}},
    {"cell_type": "code", "source": ["a", 5], "metadata": {}},
    {"cell_type": "code", "source": None, "metadata": {}},
    {"cell_type": "code", "source": {"a": 1}, "metadata": {}},
    {"cell_type": "spell", "source": "abracadabra"},
    {"cell_type": ["code"], "source": "x = 1"},
    {"source": "x = 1"},
    {},
    [],
    5,
    "cell",
    None,
]


@pytest.mark.parametrize("bad", BAD_CELLS, ids=range(len(BAD_CELLS)))
def test_a_cell_that_is_not_valid_is_left_out(tmp_path, bad):
    handed_in = json.loads(nbformat.writes(SOLVED))
    handed_in["cells"].insert(4, bad)
    put(tmp_path / NOTEBOOK, json.dumps(handed_in).encode())
    submission = read(tmp_path)
    assert is_solved(submission)
    assert submission.remarks == ("1 of its cells were not valid and are left out.",)


@pytest.mark.parametrize("metadata", [5, [], None, {"nbgrader": 5}, {"nbgrader": {"grade_id": ["double"]}}])
def test_metadata_that_are_not_valid_make_an_ordinary_cell(tmp_path, metadata):
    handed_in = json.loads(nbformat.writes(SOLVED))
    handed_in["cells"][3]["metadata"] = metadata
    put(tmp_path / NOTEBOOK, json.dumps(handed_in).encode())
    assert is_solved(read(tmp_path))


def test_half_a_character_does_not_stop_the_file_from_being_written(tmp_path):
    content = nbformat.writes(filled_in(SOLVED, {"double": "x = 'HALF'"})).replace("HALF", "\\ud800")
    put(tmp_path / NOTEBOOK, content.encode())
    assert cell_of(read(tmp_path).notebook, "double").source == "x = '?'"


def test_bytes_that_are_no_utf_8_are_replaced_and_the_rest_is_graded(tmp_path):
    content = nbformat.writes(filled_in(SOLVED, {"double": f"# naïve\n{RIGHT['double']}"}))
    put(tmp_path / NOTEBOOK, content.encode("latin-1", errors="replace"))
    submission = read(tmp_path)
    assert cell_of(submission.notebook, "double").source == f"# na�ve\n{RIGHT['double']}"
    assert "bytes that are no text" in submission.remarks[0]


def test_a_notebook_far_too_long_is_cut(tmp_path):
    handed_in = json.loads(nbformat.writes(SOLVED))
    many = [{"cell_type": "code", "source": "x = 1", "metadata": {}}] * 100_000
    for cells in (many, [{"cell_type": "code", "source": "x" * (MOST_TEXT + 1), "metadata": {}}]):
        put(tmp_path / NOTEBOOK, json.dumps(handed_in | {"cells": handed_in["cells"] + cells}).encode())
        submission = read(tmp_path)
        assert len(submission.notebook.cells) <= 510
        assert cell_of(submission.notebook, "double").source == RIGHT["double"]
        assert "far longer than a homework" in submission.remarks[-1]


def test_a_long_text_is_cut_and_what_follows_it_is_kept(tmp_path):
    handed_in = json.loads(nbformat.writes(SOLVED))
    handed_in["cells"].insert(1, {"cell_type": "markdown", "source": "[" * (MOST_TEXT + 1), "metadata": {}})
    put(tmp_path / NOTEBOOK, json.dumps(handed_in).encode())
    submission = read(tmp_path)
    assert texts(submission.notebook) == [SOLVED.cells[0].source, "[" * LONGEST_WORDS, *texts(SOLVED)[1:]]
    assert submission.remarks == (f"A text of it is cut after {LONGEST_WORDS} characters.",)


# --- which file it is -------------------------------------------------------------------------------------------------


def test_the_file_may_be_named_otherwise(tmp_path):
    put(tmp_path / "ann's homework (1).IPYNB", SOLVED)
    submission = read(tmp_path)
    assert is_solved(submission)
    assert "ann's homework (1).IPYNB was graded" in submission.remarks[0]


def test_a_name_in_another_case_will_do(tmp_path):
    put(tmp_path / NOTEBOOK.upper(), b'{"cells": []}')
    submission = read(tmp_path)
    assert not is_untouched(submission)
    assert f"{NOTEBOOK.upper()} was graded" in submission.remarks[0]


def test_a_folder_in_the_folder_is_looked_into(tmp_path):
    put(tmp_path / "homework_1" / "mine" / NOTEBOOK, SOLVED)
    assert is_solved(read(tmp_path))


def test_folders_are_not_looked_into_for_ever(tmp_path):
    put(tmp_path.joinpath(*"abcdef") / NOTEBOOK, SOLVED)
    assert is_untouched(read(tmp_path))


@pytest.mark.parametrize("folder", [".ipynb_checkpoints", "__MACOSX"])
def test_what_programs_leave_behind_is_not_handed_in(tmp_path, folder):
    put(tmp_path / folder / NOTEBOOK, SOLVED)
    put(tmp_path / f"._{NOTEBOOK}", SOLVED)
    assert is_untouched(read(tmp_path))


def test_of_several_the_one_with_the_expected_name_is_graded(tmp_path):
    put(tmp_path / NOTEBOOK, SOLVED)
    put(tmp_path / "04_homework_1-Copy1.ipynb", RELEASE)
    submission = read(tmp_path)
    assert is_solved(submission)
    assert submission.remarks == ("Other notebooks were handed in as well and not graded: 04_homework_1-Copy1.ipynb.",)


def test_of_several_with_other_names_the_one_with_most_of_our_cells_is_graded(tmp_path):
    less = nbformat.from_dict({**RELEASE, "cells": RELEASE.cells[:4]})
    put(tmp_path / "a.ipynb", less)
    put(tmp_path / "b.ipynb", SOLVED)
    put(tmp_path / "c.ipynb", less)
    assert is_solved(read(tmp_path))


def test_another_notebook_of_which_no_cell_is_ours_is_not_taken(tmp_path):
    put(tmp_path / "shopping.ipynb", nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("milk")]))
    submission = read(tmp_path)
    assert is_untouched(submission)
    assert submission.remarks == ("Nothing to grade: no notebook of this homework can be read.",)


def test_where_the_expected_file_is_damaged_another_is_taken(tmp_path):
    put(tmp_path / NOTEBOOK, b"{")
    put(tmp_path / "04_homework_1 (2).ipynb", SOLVED)
    assert is_solved(read(tmp_path))


# --- what is no file --------------------------------------------------------------------------------------------------


def test_nothing_is_nothing(tmp_path):
    for folder in (tmp_path, tmp_path / "missing", put(tmp_path / "file", b"text")):
        submission = read(folder)
        assert is_untouched(submission)
        assert submission.remarks == ("Nothing to grade: the submission's folder holds no notebook.",)


def test_a_folder_with_the_notebooks_name_is_none(tmp_path):
    (tmp_path / NOTEBOOK).mkdir()
    submission = read(tmp_path)
    assert is_untouched(submission)
    assert submission.remarks[0] == f"{NOTEBOOK} is a folder."


def test_links_are_not_followed(tmp_path):
    target = put(tmp_path / "secret" / "solution.ipynb", SOLVED)
    for number, (name, points_at) in enumerate(
        [(NOTEBOOK, target), ("other.ipynb", target), ("folder", target.parent), (NOTEBOOK, tmp_path / "nowhere")]
    ):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / name).symlink_to(points_at)
        submission = read(folder)
        assert is_untouched(submission)
        if name == NOTEBOOK:
            assert submission.remarks[0] == f"{NOTEBOOK} is a link, and links are not followed."
    (tmp_path / "door").symlink_to(target.parent)
    submission = read_submission(tmp_path / "door", RELEASE, target.name)
    assert is_untouched(submission)
    assert "links are not followed" in submission.remarks[0]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names here")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / NOTEBOOK)
    submission = read(tmp_path)
    assert is_untouched(submission)
    assert "is not a regular file" in submission.remarks[0]


def test_a_file_that_may_not_be_opened_is_not_read(tmp_path, monkeypatch):
    """Permissions stop no root, so the system's answer is made up."""
    put(tmp_path / NOTEBOOK, SOLVED)

    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(submissions.os, "open", refuse)
    submission = read(tmp_path)
    assert is_untouched(submission)
    assert submission.remarks[0] == f"{NOTEBOOK} cannot be opened (Permission denied)."


def test_a_name_cannot_write_on_the_teachers_screen(tmp_path):
    put(tmp_path / f"\x1b[31m{'long' * 40}\n.ipynb", SOLVED)
    remark = read(tmp_path).remarks[0]
    assert "?[31mlong" in remark
    assert len(remark) < 200


# --- anything at all --------------------------------------------------------------------------------------------------

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)
tags = st.fixed_dictionaries(
    {}, optional={"grade_id": st.sampled_from([*map(name_of, RELEASE.cells), "x"]) | json_values, "grade": json_values}
)
cells = st.fixed_dictionaries(
    {},
    optional={
        "cell_type": st.sampled_from(["code", "markdown", "raw", "heading"]) | json_values,
        "source": st.sampled_from(texts(RELEASE)) | json_values,
        "metadata": st.fixed_dictionaries({"nbgrader": tags}) | json_values,
        "id": json_values,
    },
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("handed_in")


@given(st.lists(cells | json_values, max_size=12), st.dictionaries(st.text(max_size=5), json_values, max_size=3))
def test_no_json_breaks_it(folder, cells, more):
    put(folder / NOTEBOOK, json.dumps(more | {"cells": cells}).encode())
    submission = read(folder)
    assert all(hidden not in text for hidden in HIDDEN for text in texts(submission.notebook))


def test_no_damage_to_a_file_breaks_it(tmp_path):
    content, chance = nbformat.writes(SOLVED).encode(), random.Random(0)
    for _ in range(150):
        damaged = bytearray(content)
        for _ in range(chance.randrange(1, 6)):
            damaged[chance.randrange(len(damaged))] = chance.randrange(256)
        put(tmp_path / NOTEBOOK, bytes(damaged[: chance.randrange(len(damaged) // 2, len(damaged) + 1)]))
        read(tmp_path)
