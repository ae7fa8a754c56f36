"""The package as it is installed away from its repository, as on Colab or for a whole hub: a wheel."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
READ_ON_GITHUB = {"course_lib/classroom/GUIDE.md"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel that pip makes of what lies in the repository."""
    folder = tmp_path_factory.mktemp("wheel")
    copy = folder / "copy"
    ignored = shutil.ignore_patterns("__pycache__", "*.egg-info")
    shutil.copytree(REPOSITORY / "course_lib", copy / "course_lib", ignore=ignored)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(REPOSITORY / name, copy)
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, copy]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode and "No matching distribution found for setuptools" in done.stderr:
        pytest.skip("pip cannot fetch what it builds with")
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """An environment in which the course is what the wheel holds, and a folder far from the repository."""
    place, away = tmp_path_factory.mktemp("installed"), tmp_path_factory.mktemp("away")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    return away, os.environ | {"PYTHONPATH": str(place)}


def test_everything_is_in_it(wheel):
    package = REPOSITORY / "course_lib"
    there = {path.relative_to(REPOSITORY).as_posix() for path in package.rglob("*") if path.is_file()}
    there = {name for name in there if "__pycache__" not in name} - READ_ON_GITHUB
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if name.startswith("course_lib/")}
    assert packed - READ_ON_GITHUB == there


def test_no_solution_is_in_it(wheel):
    with zipfile.ZipFile(wheel) as archive:
        assert not [name for name in archive.namelist() if name.endswith(".ipynb")]


def test_it_is_the_one_that_is_imported(installed):
    away, environment = installed
    code = "import course_lib; print(course_lib.__file__)"
    done = subprocess.run([sys.executable, "-c", code], cwd=away, env=environment, capture_output=True, text=True)
    assert done.stdout.startswith(environment["PYTHONPATH"])


def test_a_lesson_runs_with_nothing_but_its_notebook(installed):
    away, environment = installed
    notebook = json.loads((REPOSITORY / "notebooks" / "00_start_here.ipynb").read_text(encoding="utf-8"))
    where = {"cell_type": "code", "id": "where", "metadata": {}, "source": "", "outputs": [], "execution_count": None}
    where["source"] = f"import course_lib\nassert course_lib.__file__.startswith({environment['PYTHONPATH']!r})"
    notebook["cells"].append(where)
    (away / "lesson.ipynb").write_text(json.dumps(notebook))
    command = [sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--stdout", "lesson.ipynb"]
    done = subprocess.run(command, cwd=away, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
