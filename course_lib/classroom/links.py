"""Links that open the lessons where nothing is installed: on Binder (https://mybinder.org) and on Google Colab."""

import re
import subprocess
from pathlib import Path
from urllib.parse import quote

REPOSITORY = Path(__file__).parents[2]
_ADDRESS = re.compile(r"https://github\.com/([A-Za-z0-9-]+)/([A-Za-z0-9._-]+?)(?:\.git)?/?")
_COMMIT = re.compile(r"[A-Za-z0-9][A-Za-z0-9._/-]*")


def links(address, commit=None, *, repository=REPOSITORY):
    """The links to all lessons in the public repository at `address`, as Markdown, with what Colab has to run first.

    `commit` (a commit or a tag) says which version they lead to; None: the commit that the clone `repository` is at.
    `ValueError` for an address that is not one of GitHub, which Colab needs.
    """
    found = _ADDRESS.fullmatch(address)
    if not found:
        raise ValueError(f"the address must be like https://github.com/OWNER/REPOSITORY, got {address!r}")
    commit = _commit_of(repository) if commit is None else commit
    if not _COMMIT.fullmatch(commit):
        raise ValueError(f"commit must be a commit or a tag, got {commit!r}")
    place = "/".join(found.groups())
    lessons = sorted(path.name for path in (Path(repository) / "notebooks").glob("[0-9]*.ipynb"))
    if not lessons:
        raise FileNotFoundError(f"there are no lessons in {repository}: this needs a clone of the course's repository")
    lines = [
        "Binder, with all that `requirements.txt` names:",
        "",
        *(f"- [{name}]({_on_binder(place, commit, name)})" for name in lessons),
        "",
        "Colab, where a new first cell has to install the course, over what is there:",
        "",
        f"    %pip install --quiet git+https://github.com/{place}@{commit}",
        "",
        *(
            f"- [{name}](https://colab.research.google.com/github/{place}/blob/{commit}/notebooks/{name})"
            for name in lessons
        ),
    ]
    return "\n".join(lines)


def _on_binder(place, commit, name):
    opened = quote(f"notebooks/{name}", safe="")
    return f"https://mybinder.org/v2/gh/{place}/{quote(commit, safe='')}?labpath={opened}"


def _commit_of(repository):
    asked = ["git", "-C", str(repository), "rev-parse", "HEAD"]
    try:
        return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        raise ValueError(f"{repository} is no clone whose commit git could name: give one with --commit") from None
