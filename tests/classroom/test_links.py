"""Lessons where nothing is installed: links to Binder and Colab, and what Binder's builder makes of the repository."""

import re
import subprocess
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import parse_qs, unquote, urlsplit

import pytest
from needed import do_without

from course_lib.classroom.__main__ import main
from course_lib.classroom.links import links

REPOSITORY = Path(__file__).parents[2]
ADDRESS = "https://github.com/some-one/the.course"
LESSONS = {path.name for path in (REPOSITORY / "notebooks").glob("[0-9]*.ipynb")}


def addresses(text):
    return re.findall(r"\]\((https:[^)]+)\)", text)


@pytest.mark.parametrize("address", [ADDRESS, f"{ADDRESS}/", f"{ADDRESS}.git"])
def test_every_lesson_has_a_link_to_each_of_them(address):
    binder, colab = set(), set()
    for link in addresses(links(address, "v1.0")):
        parts = urlsplit(link)
        if parts.hostname == "mybinder.org":
            assert parts.path == "/v2/gh/some-one/the.course/v1.0"
            (opened,) = parse_qs(parts.query)["labpath"]
            binder.add(opened)
        else:
            assert parts.hostname == "colab.research.google.com"
            place, _, opened = parts.path.partition("/blob/v1.0/")
            assert place == "/github/some-one/the.course"
            colab.add(opened)
    assert binder == colab == {f"notebooks/{name}" for name in LESSONS}
    assert len(LESSONS) >= 8


def test_colab_installs_the_course_at_that_commit():
    said = links(ADDRESS, "v1.0")
    assert "\n    %pip install --quiet git+https://github.com/some-one/the.course@v1.0\n" in said


def test_a_tag_with_a_slash_stays_one_part_of_the_address():
    (first, *_) = addresses(links(ADDRESS, "release/1"))
    assert unquote(urlsplit(first).path.split("/")[-1]) == "release/1"


def test_without_a_commit_it_is_the_one_that_the_clone_is_at(tmp_path):
    (tmp_path / "notebooks").mkdir()
    (tmp_path / "notebooks" / "00_start.ipynb").write_text("{}")
    with pytest.raises(ValueError, match="--commit"):
        links(ADDRESS, repository=tmp_path)
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b"]
    for command in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "one"]):
        subprocess.run([*git, *command], check=True)
    commit = subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()
    assert links(ADDRESS, repository=tmp_path).count(commit) == 3


@pytest.mark.parametrize(
    ("address", "commit"),
    [
        ("github.com/a/b", "v1"),
        ("https://gitlab.com/a/b", "v1"),
        ("https://github.com/a", "v1"),
        ("https://github.com/a/b/tree/main", "v1"),
        (ADDRESS, ""),
        (ADDRESS, "two words"),
        (ADDRESS, "-x"),
    ],
)
def test_what_is_no_address_and_no_commit_is_refused(address, commit):
    with pytest.raises(ValueError, match="must be"):
        links(address, commit)


def test_an_installed_package_has_no_lessons_to_link_to(tmp_path):
    with pytest.raises(FileNotFoundError, match="clone"):
        links(ADDRESS, "v1", repository=tmp_path)


def test_on_the_command_line(capsys):
    assert main(["links", ADDRESS, "--commit", "v1.0"]) == 0
    assert capsys.readouterr().out == links(ADDRESS, "v1.0") + "\n"
    assert main(["links", "here"]) == 1
    assert capsys.readouterr().err.startswith("error: the address must be like")


# --- Binder -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def build_pack(monkeypatch):
    """What repo2docker takes this repository for."""
    if not find_spec("repo2docker"):
        do_without("needs repo2docker: pip install jupyter-repo2docker", "COURSE_REQUIRE_REPO2DOCKER")
    from repo2docker.app import Repo2Docker

    monkeypatch.chdir(REPOSITORY)
    packs = [kind("an-image") for kind in Repo2Docker().buildpacks]
    pack = next(pack for pack in packs if pack.detect())
    pack.platform = "linux/amd64"
    return pack


def test_binder_builds_the_python_that_the_versions_were_tried_with(build_pack):
    assert type(build_pack).__name__ == "PythonBuildPack"
    assert build_pack.python_version == "3.11"


def test_binder_installs_once_the_repository_is_there(build_pack):
    """`-e .` in the requirements is the repository itself, which is copied late where nothing needs it before."""
    dockerfile = build_pack.render()
    copied = dockerfile.index("COPY --chown")
    install = re.search(r"^RUN .*pip install --no-cache-dir -r \"\.binder/requirements\.txt\"$", dockerfile, re.M)
    assert install, dockerfile[-3000:]
    last_copy = dockerfile.rindex("COPY --chown", 0, install.start())
    assert "src/" in dockerfile[last_copy:].splitlines()[0]
    assert copied <= last_copy < install.start()


def test_what_binder_installs_is_what_the_readme_installs():
    wanted = [line for line in (REPOSITORY / ".binder" / "requirements.txt").read_text().splitlines() if line[0] != "#"]
    assert wanted == ["-r ../requirements.txt"]
