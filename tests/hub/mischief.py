"""What learners try in their own servers against others and against the teacher, as code for a kernel."""

_START = """
import datetime, os
from pathlib import Path
inbound = Path("/srv/course/exchange/demo/inbound")
now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M:%S.%f UTC")
def hand_in(name, notebook=None):
    folder = inbound / name
    folder.mkdir()
    (folder / "timestamp.txt").write_text(now)
    (folder / "submission_secret.txt").write_text("abc")
    if notebook:
        (folder / "small.ipynb").write_text(notebook)
    return folder
"""

MISCHIEF = {
    # Work in another's name, later than theirs.
    "in another's name": _START + 'hand_in("learner-00+small+2099-01-01 00:00:00.000000 UTC+x", "{}")',
    "names that are none": _START + 'hand_in("learner-03+small+never+x"); hand_in("x+small+y"); hand_in("+small+")',
    # The teacher may read what the link leads to, and would copy it for its learner, solution and hidden tests.
    "links": _START
    + """
folder = hand_in(f"learner-04+small+{now}+x")
(folder / "small.ipynb").symlink_to("/home/teacher/demo/source/small/small.ipynb")
(folder / "gradebook.txt").symlink_to("/home/teacher/demo/gradebook.db")
(folder / "others").symlink_to("/home/teacher/demo/submitted")
os.mkfifo(folder / "pipe.txt")
""",
    "a link for a folder": _START + '(inbound / f"learner-03+small+{now}+y").symlink_to("/home/teacher/demo/source")',
}
