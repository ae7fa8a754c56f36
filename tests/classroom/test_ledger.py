"""Names, tables and files that hold what is known about a class."""

import csv
import os

import pytest

from course_lib.classroom.ledger import learner_of, student_id, write_csv

from .school import ODD_NAMES


@pytest.mark.parametrize("name", [*ODD_NAMES, "\udcff", "ann", "a%2Ab", "line\nbreak", "tab\t", "~", "…"])
def test_a_learner_is_found_again_by_the_name_in_nbgrader(name):
    assert learner_of(student_id(name)) == name
    assert not set(student_id(name)) & set("*?[]\\\n\t\udcff")
    assert student_id(name) == student_id(name).strip()
    assert not student_id(name).startswith(".")


def test_ordinary_names_stay_as_they_are():
    for name in ("ann", "dö müller", "a+b__c", "o'neill, p. (2)", "m.mustermann@example.org"):
        assert student_id(name) == name


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@sum", "\t=1", "\r=1", "\n=1"])
def test_no_text_is_a_formula(tmp_path, text):
    write_csv(tmp_path / "a.csv", [{"learner": text, "homework": "h", "score": -1.5, "remarks": text}])
    with open(tmp_path / "a.csv", encoding="utf-8-sig", newline="") as file:
        row = next(csv.DictReader(file))
    assert row["learner"] == row["remarks"] == f"'{text}"
    assert row["score"] == "-1.5"


def test_homeworks_of_different_cells_share_a_table(tmp_path):
    rows = [
        {"learner": "ann", "homework": "h1", "a": 1.0, "score": 1.0},
        {"learner": "ann", "homework": "h2", "b": 2.0},
    ]
    write_csv(tmp_path / "a.csv", rows)
    assert (tmp_path / "a.csv").read_text(encoding="utf-8-sig").splitlines() == [
        "learner,homework,a,b,score,max_score,remarks",
        "ann,h1,1.0,,1.0,,",
        "ann,h2,,2.0,,,",
    ]


def test_a_table_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("the disk is full")

    write_csv(tmp_path / "a.csv", [{"learner": "ann"}])
    before = (tmp_path / "a.csv").read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", fail)
        with pytest.raises(OSError, match="full"):
            write_csv(tmp_path / "a.csv", [{"learner": "bob"}])
    assert (tmp_path / "a.csv").read_bytes() == before
    assert len(list(tmp_path.iterdir())) == 1
