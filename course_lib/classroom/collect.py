"""nbgrader's exchange on a machine that learners share, where anybody may have put anything into it.

nbgrader's own `collect` takes a folder for the work of whoever its name says, follows the links in it with the
teacher's rights, and stops for all learners at one bad name. This one does none of that.
"""

import os
import pwd
import shutil
import stat
import time
from datetime import UTC, datetime
from pathlib import Path

from nbgrader.exchange import ExchangeError
from nbgrader.exchange.default import ExchangeCollect

from course_lib.classroom.submissions import DEEPEST_FOLDER, MOST_FILES, printable

# What nbgrader's `submit` writes last: without them the learner's copying has not come to its end.
_LAST = ("timestamp.txt", "submission_secret.txt")
_LONGEST_DIFFERENCE = 3600  # seconds between the time that a submission claims and the time that the system noted


class CollectOwn(ExchangeCollect):
    """nbgrader's `collect`, with what is handed in taken from its owner only, file by file, following no link.

    Afterwards `collected` holds the learners whose work was brought in, and `notes` a sentence on everything that was
    refused or looks odd. No submission stops the others.
    """

    def init_src(self):
        """Find the newest submission of every learner."""
        self.collected, self.notes = [], []
        super().init_src()
        self.src_records = [record for record in self.src_records if record["owner"] is not None]

    def _path_to_record(self, path):
        name = os.path.basename(path)
        try:
            record = super()._path_to_record(path)
            status = os.lstat(path)
            if not stat.S_ISDIR(status.st_mode):
                raise ValueError("it is no folder")
            if _account(status.st_uid) != record["username"]:
                raise ValueError(f"it was put there by {_account(status.st_uid)}")
        except (ExchangeError, OSError, ValueError, OverflowError) as error:
            self.notes.append(f"{printable(name)} is not collected: {printable(error)}.")
            # Under a name that nobody has, so that it takes no one's place.
            return {"username": path, "filename": name, "timestamp": datetime.min, "owner": None}
        return record | {"owner": status.st_uid, "noted": status.st_ctime}

    def copy_files(self):
        """Bring in what is new, each submission whole or not at all."""
        for record in sorted(self.src_records, key=lambda record: record["username"]):
            learner = record["username"]
            place = Path(
                self.coursedir.format_path(self.coursedir.submitted_directory, learner, self.coursedir.assignment_id)
            )
            try:
                if not self._is_wanted(place, record["timestamp"]):
                    continue
                self._bring_in(Path(self.inbound_path, record["filename"]), place, record["owner"])
            except (ExchangeError, OSError, ValueError) as error:
                self.notes.append(f"{learner}'s submission is not collected: {printable(error)}.")
                continue
            self.collected.append(learner)
            claimed = record["timestamp"].replace(tzinfo=UTC).timestamp()
            if abs(claimed - record["noted"]) > _LONGEST_DIFFERENCE:
                noted = time.strftime("%Y-%m-%d %H:%M", time.gmtime(record["noted"]))
                self.notes.append(f"{learner}'s submission says {record['timestamp']:%Y-%m-%d %H:%M}, not {noted} UTC.")

    def _is_wanted(self, place, handed_in):
        if not place.is_dir():
            return True
        there = self.coursedir.get_existing_timestamp(str(place))
        newer = there is None or handed_in > there
        return (self.update and newer) or (self.before_duedate and handed_in != there)

    def _bring_in(self, source, place, owner):
        fresh, old = (place.with_name(f".{place.name}.{kind}") for kind in ("fresh", "old"))
        for folder in (fresh, old):
            shutil.rmtree(folder, ignore_errors=True)
        fresh.mkdir(parents=True)
        try:
            self.notes += copy_own_files(source, fresh, owner, 1000 * self.coursedir.max_dir_size)
            if not all((fresh / name).is_file() for name in _LAST):
                raise ValueError("it is not complete; collect again in a minute")
            if place.is_dir():
                place.rename(old)
            fresh.rename(place)
        finally:
            for folder in (fresh, old):
                shutil.rmtree(folder, ignore_errors=True)


def copy_own_files(source, target, owner, most_bytes):
    """Copy the regular files in `source` that belong to the user id `owner`; sentences on what was left out.

    Links are not followed, not even one that takes a folder's place in the meantime. `ValueError` for more than
    `most_bytes` or too many files.
    """
    notes, left, files_left = [], most_bytes, MOST_FILES
    for place, folders, files, descriptor in os.fwalk(source):
        inside = Path(place).relative_to(source)
        deep = len(inside.parts) >= DEEPEST_FOLDER
        folders[:] = [] if deep else sorted(name for name in folders if not name.startswith((".", "__")))
        (target / inside).mkdir(exist_ok=True)
        for name in sorted(files):
            content = _read_own(name, descriptor, owner, left)
            if content is None:
                notes.append(f"{printable(source.name)}: {printable(inside / name)} is a link or not its owner's.")
                continue
            left, files_left = left - len(content), files_left - 1
            if left < 0 or files_left < 0:
                raise ValueError(f"it is larger than {most_bytes // 1_000_000} MB or {MOST_FILES} files")
            (target / inside / name).write_bytes(content)
    return notes


def _read_own(name, folder, owner, most):
    """The first `most` + 1 bytes of a regular file of `owner`'s in the open `folder`; None for anything else."""
    if not stat.S_ISREG(os.lstat(name, dir_fd=folder).st_mode):
        return None
    with open(os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=folder), "rb") as file:
        status = os.fstat(file.fileno())
        return file.read(most + 1) if stat.S_ISREG(status.st_mode) and status.st_uid == owner else None


def _account(user_id):
    try:
        return pwd.getpwuid(user_id).pw_name
    except KeyError:
        return f"user {user_id}"
