"""A teacher's folder: homework released, handed in, graded and given back, on nbgrader's layout and its gradebook."""

import os
import re
import shutil
import sysconfig
import warnings
from contextlib import contextmanager, suppress
from functools import cached_property
from pathlib import Path

from course_lib.classroom import require_nbgrader
from course_lib.classroom.ledger import NOTHING, Grade, Ledger, student_id, write_csv
from course_lib.classroom.submissions import Unreadable, printable, read_bytes, read_submission, regular_files
from course_lib.classroom.templates import SETTINGS

SOLUTIONS = Path(__file__).parents[2] / "notebooks" / "solutions"
# Between `submitted`, which is never changed, and nbgrader: every submission rebuilt against its release.
CHECKED = "checked"
# Files beside a notebook: data that it may read. Modules are code that no check has seen, and the judge's process
# would not import them.
LARGEST_DATA, MOST_DATA = 10_000_000, 100
NO_DATA = {".ipynb", ".py", ".pyc", ".pyd", ".pyi", ".pth", ".so", ".dll", ".dylib"}
# What nbgrader's `submit` adds, so that the feedback finds its way back.
FOR_EXCHANGE = "timestamp.txt", "submission_secret.txt"
NO_PAGE = "No feedback page could be made"
EXCHANGE = """
# The exchange with learners on this machine, and the name under which they find this class there.
c.Exchange.root = {root!r}
c.CourseDirectory.course_id = {course_id!r}
"""

__all__ = ["Course", "Grade", "homeworks_of_the_course"]


def homeworks_of_the_course():
    """{name: path of its source} of the homeworks in the repository that this package lies in."""
    sources = sorted(SOLUTIONS.glob("[0-9]*_homework_*.ipynb"))
    if not sources:
        raise FileNotFoundError(f"there is no homework in {SOLUTIONS}: this needs a clone of the course's repository")
    return {re.sub(r"^\d+_", "", path.stem): path for path in sources}


class Course:
    """The class in `folder`, made by `Course.new`: `release` homework, `autograde` it, give `feedback` and `grades`."""

    def __init__(self, folder):
        require_nbgrader()
        self.folder = Path(folder).resolve()
        if set(str(self.folder)) & set("*?["):
            raise ValueError(f"nbgrader cannot work in {self.folder}: its path holds one of * ? [")
        if not (self.folder / SETTINGS.name).is_file():
            raise FileNotFoundError(f"{self.folder} is not the folder of a class: it has no {SETTINGS.name}")

    @classmethod
    def new(cls, folder, homeworks=None, *, exchange=None):
        """Make a class in `folder`, new or empty, with `homeworks` {name: path of its source}; None: the course's.

        The folder is closed to all other accounts of the machine. With an `exchange` (a folder) the class hands out
        and collects there, under the folder's name.
        """
        require_nbgrader()
        folder = Path(folder).resolve()
        if exchange is not None and not Path(exchange).is_dir():
            raise FileNotFoundError(f"there is no folder {exchange} for the exchange")
        if exchange is not None and not re.fullmatch(r"\w[\w-]*", folder.name, re.ASCII):
            raise ValueError(f"on an exchange a class is called by letters, digits, _ and -, not {folder.name!r}")
        homeworks = homeworks_of_the_course() if homeworks is None else homeworks
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise FileExistsError(f"{folder} is there already and not empty")
        for source in homeworks.values():
            if not Path(source).is_file():
                raise FileNotFoundError(f"there is no notebook {source}")
        folder.mkdir(parents=True, exist_ok=True)
        folder.chmod(0o700)
        for name, source in homeworks.items():
            place = folder / "source" / name
            place.mkdir(parents=True)
            shutil.copyfile(source, place / Path(source).name)
        (folder / "submitted").mkdir(parents=True)
        settings = SETTINGS.read_text(encoding="utf-8")
        if exchange is not None:
            settings += EXCHANGE.format(root=str(Path(exchange).resolve()), course_id=folder.name)
        (folder / SETTINGS.name).write_text(settings, encoding="utf-8")
        return cls(folder)

    @property
    def homeworks(self):
        """The names of the homeworks there are."""
        return sorted(path.name for path in (self.folder / "source").iterdir() if path.is_dir())

    @property
    def learners(self):
        """The names of all learners: in `roster.csv`, in the gradebook, or with a folder in `submitted`."""
        return self.ledger.learners()

    @cached_property
    def ledger(self):
        """The records of the class."""
        return Ledger(self.folder, self.nbgrader.coursedir.db_url)

    # --- what a teacher does ------------------------------------------------------------------------------------------

    def release(self, homework):
        """Make the notebook that learners get, also in the gradebook, and return its path."""
        released = self.folder / "release" / homework / self._source(homework).name
        before = released.read_bytes() if released.is_file() else None
        problem = problem_of(self.nbgrader.generate_assignment(homework))
        if problem and before is not None:  # nbgrader has taken it away
            released.parent.mkdir(parents=True, exist_ok=True)
            released.write_bytes(before)
        if problem:
            raise RuntimeError(f"{homework} was not released: {problem}")
        return released

    def autograde(self, homework, *, learners=None, progress=False):
        """Grade what was handed in, for the first time or again; a `Grade` for each of `learners` (None: all).

        No submission stops the others: one that cannot be graded has no points and a remark. Points that a teacher
        gave by hand stay. `progress=True` shows a bar.
        """
        import nbformat
        from sqlalchemy.exc import SAWarning

        path = self.released(homework)
        release = nbformat.read(path, as_version=4)
        known = self.learners
        unknown = sorted(set(learners or ()) - set(known))
        if unknown:
            raise ValueError(f"there is no learner called {', '.join(unknown)}")
        chosen = [learner for learner in known if learners is None or learner in learners]
        for learner in _with_bar(chosen) if progress else chosen:
            # nbgrader fills its tables in an order of which SQLAlchemy warns at every submission
            with warnings.catch_warnings(action="ignore", category=SAWarning):
                remarks = self._grade(homework, learner, release, path.name)
            self.ledger.remark(homework, learner, remarks)
        return [self.ledger.grade(homework, learner) for learner in chosen]

    def feedback(self, homework):
        """Write a page, without hidden tests, for everyone whose work was graded; {learner: its path}."""
        name = self.released(homework).stem
        pages = {}
        for learner in self.learners:
            student = student_id(learner)
            if not (self.folder / "autograded" / student / homework / f"{name}.ipynb").is_file():
                continue
            problem = problem_of(self.nbgrader.generate_feedback(homework, student))
            remarks = [said for said in self.ledger.remarks(homework).get(learner, []) if not said.startswith(NO_PAGE)]
            if problem:
                remarks.append(f"{NO_PAGE}: {printable(problem, 200)}")
            else:
                pages[learner] = self.folder / "feedback" / student / homework / f"{name}.html"
            self.ledger.remark(homework, learner, remarks)
        return pages

    def grades(self, path=None):
        """All grades, as a list of rows (dicts), one for each homework and learner; also as CSV to `path`, if given."""
        released = [homework for homework in self.homeworks if (self.folder / "release" / homework).is_dir()]
        learners = self.learners
        rows = [self.ledger.grade(homework, learner).row() for homework in released for learner in learners]
        if path is not None:
            write_csv(path, rows)
        return rows

    # --- one submission -----------------------------------------------------------------------------------------------

    def _grade(self, homework, learner, release, name):
        """Grade one submission and return the remarks on it, whatever it is."""
        submitted = self.folder / "submitted" / learner / homework
        if not os.path.lexists(submitted):
            return [NOTHING]
        remarks = []
        try:
            if submitted.parent.is_symlink():
                submitted = submitted.parent  # a link itself, which is not followed
            submission = read_submission(submitted, release, name)
            remarks += submission.remarks
            self._lay_out(submitted, self.folder / CHECKED / student_id(learner) / homework, submission, name, remarks)
            problem = problem_of(self.nbgrader.autograde(homework, student_id(learner)))
        except Exception as error:  # whatever it is, the others' work is graded
            problem = f"{type(error).__name__}: {error}"
        if problem:
            remarks.append(f"It could not be graded and has no points: {printable(problem, 200)}")
            self.ledger.zero(homework, learner)
            with suppress(OSError):
                self._show_release(homework, learner, submitted)
        return remarks

    def _lay_out(self, submitted, place, submission, name, remarks):
        """Write what is to be graded to `place`: the rebuilt notebook, and the learner's data files."""
        import nbformat

        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        files = [path for path in regular_files(submitted) if path.suffix.lower() != ".ipynb"]
        data = [path for path in files if path.suffix.lower() not in NO_DATA]
        modules = [path for path in files if path.suffix.lower() in NO_DATA]
        if modules:
            listed = ", ".join(printable(path.relative_to(submitted)) for path in modules[:3])
            remarks.append(f"Code in files of its own is not used: {listed}.")
        left = LARGEST_DATA
        for path in data[:MOST_DATA]:
            inside = path.relative_to(submitted)
            try:
                content = read_bytes(path, left)
            except Unreadable as error:
                remarks.append(f"{printable(inside)} {error}.")
                continue
            if inside == Path("timestamp.txt") and not _is_time(content):
                remarks.append("timestamp.txt holds no time; the submission counts as handed in on time.")
                continue
            left -= len(content)
            (place / inside).parent.mkdir(parents=True, exist_ok=True)
            (place / inside).write_bytes(content)
        if len(data) > MOST_DATA:
            remarks.append(f"Only the first {MOST_DATA} of its {len(data)} data files are used.")
        nbformat.write(submission.notebook, place / name)

    def _show_release(self, homework, learner, submitted):
        """Put the released notebook where the graded one would be, so that there is a feedback page."""
        released = self.released(homework)
        place = self.folder / "autograded" / student_id(learner) / homework
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        shutil.copyfile(released, place / released.name)
        for name in FOR_EXCHANGE:
            with suppress(OSError, Unreadable):
                (place / name).write_bytes(read_bytes(submitted / name, LARGEST_DATA))

    # --- nbgrader -----------------------------------------------------------------------------------------------------

    @cached_property
    def nbgrader(self):
        """The interface of nbgrader to this class: https://nbgrader.readthedocs.io/en/stable/api/high_level_api.html."""
        from nbgrader.apps import NbGraderAPI
        from sqlalchemy.exc import SQLAlchemyError
        from traitlets.config.loader import PyFileConfigLoader

        settings = PyFileConfigLoader(SETTINGS.name, path=str(self.folder)).load_config()
        settings.CourseDirectory.root = str(self.folder)
        settings.CourseDirectory.submitted_directory = CHECKED
        settings.ExchangeFactory.collect = "course_lib.classroom.collect.CollectOwn"
        settings.ExchangeReleaseAssignment.force = True
        api = NbGraderAPI(config=settings)
        try:
            with _programs_beside_python():  # to make a gradebook it calls `alembic`
                api.gradebook.close()
        except SQLAlchemyError as error:
            raise RuntimeError(
                f"the gradebook {api.coursedir.db_url} cannot be used: {getattr(error, 'orig', error)}"
            ) from None
        return api

    def _source(self, homework):
        """The path of a homework's source; a `ValueError` that names those there are."""
        if homework not in self.homeworks:
            raise ValueError(f"there is no {homework} here, only {', '.join(self.homeworks) or 'no homework at all'}")
        notebooks = sorted((self.folder / "source" / homework).glob("*.ipynb"))
        if len(notebooks) != 1:
            raise ValueError(f"source/{homework} must hold one notebook, and holds {len(notebooks)}")
        return notebooks[0]

    def released(self, homework):
        """The path of a homework's released notebook."""
        path = self.folder / "release" / homework / self._source(homework).name
        if not path.is_file():
            raise FileNotFoundError(f"{homework} has not been released yet")
        return path


def problem_of(result):
    """What went wrong according to nbgrader, in one line; None where nothing did."""
    if result["success"]:
        return None
    if result["error"].rstrip().endswith("KeyboardInterrupt"):  # nbgrader takes even this for a failure of its own
        raise KeyboardInterrupt
    # The last exception in its log is the cause; the one that it raises in the end says only that there was one.
    lines = [line.strip() for line in (result.get("log", "") + result["error"]).splitlines() if line.strip()]
    causes = [line for line in lines if re.match(r"[\w.]+(Error|Exception|Timeout\w*): ", line)]
    specific = [line for line in causes if "NbGraderException" not in line]
    return (specific or causes or lines)[-1]


def _is_time(content):
    from nbgrader.utils import parse_utc

    try:
        parse_utc(content.decode().strip())
    except (ValueError, OverflowError):
        return False
    return True


def _with_bar(learners):
    from tqdm.auto import tqdm

    return tqdm(learners, unit="submission", leave=False)


@contextmanager
def _programs_beside_python():
    """They are found though the environment is not activated. (`nbgrader.utils.setenv` leaves no PATH at all.)"""
    before = os.environ.get("PATH")
    os.environ["PATH"] = os.pathsep.join(filter(None, [sysconfig.get_path("scripts"), before]))
    try:
        yield
    finally:
        if before is None:
            del os.environ["PATH"]
        else:
            os.environ["PATH"] = before
