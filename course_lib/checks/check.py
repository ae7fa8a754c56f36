"""A check: a task's trials, run one after the other on the learner's function, and its hints."""

import re
from dataclasses import dataclass, field
from pathlib import Path

from course_lib.checks.here import Here
from course_lib.checks.learner import Fault, Kind, Learner
from course_lib.checks.verdict import Hint, Outcome, Row, Verdict
from course_lib.validate import number, whole_number

_NOTHING_MORE_AFTER = {Kind.NOT_STARTED, Kind.NO_FUNCTION, Kind.SIGNATURE, Kind.TIME_UP, Kind.INTERRUPTED, Kind.DIED}
_NOT_TRIED = "not tried after that"


class NotYet(Exception):
    """Raised by a trial: what came instead of what was expected, and the misunderstanding that it looks like.

    `likely` goes on after "It looks as if"; it is left empty where the record does not show what was misunderstood.
    `last`: no other trial would come to anything else.
    """

    def __init__(self, came, likely="", map="", *, last=False):  # noqa: A002 (what else to call it)
        super().__init__(came)
        self.came, self.likely, self.map, self.last = came, likely, map, last


@dataclass(frozen=True)
class Call:
    """Calls the learner's function with a time limit; `kept` is what one trial of a check leaves to the next."""

    learner: Learner
    time_limit: float
    kept: dict = field(default_factory=dict)

    def __call__(self, *arguments):
        return self.learner.call(*arguments, time_limit=self.time_limit)

    def once(self, name, work):
        """What `work()` gives, or raises, done once a check however many trials ask for it."""
        if name not in self.kept:
            try:
                self.kept[name] = work(), None
            except (NotYet, Fault) as what_came:
                self.kept[name] = None, what_came
        value, what_came = self.kept[name]
        if what_came is not None:
            raise what_came
        return value


@dataclass(frozen=True)
class Trial:
    """One row of a check. `run(call, seed)` returns if all is well; it raises `NotYet`, or lets a `Fault` pass."""

    tried: str
    expected: str
    run: object


class Check:
    """The check of one task: `check(function)` gives a `Verdict`, `check.hint()` the next `Hint`.

    title    of the task
    usage    how the learner's function is called, such as "play(maze, q_table, rng)"
    trials   each worth a point
    hints    from a nudge to nearly the answer
    likely   {pattern: words}: what an error that the learner's code raised looks like, where its words match
    """

    def __init__(self, name, *, title, usage, trials, hints, likely=()):
        self.name, self.title, self.usage = name, title, usage
        self._likely_errors = dict(likely)
        self.trials, self.hints = tuple(trials), tuple(hints)
        self._hints_given = 0

    @property
    def max_points(self):
        return float(len(self.trials))

    def __call__(self, function, *, seed=0, time_limit=10.0):
        """The `Verdict` on the learner's function. Another `seed` tries it with other mazes or data."""
        seed, time_limit = whole_number("seed", seed), number("time_limit", time_limit)
        learner = function if isinstance(function, Learner) else Here(function)
        call, rows, stop = Call(learner, time_limit), [], None
        for trial in self.trials:
            row, stop = self._not_tried(trial, stop) if stop else self._tried(trial, call, seed)
            rows.append(row)
        more = f"Stuck? Run `checks.{self.name}.hint()`, and again for the next of {len(self.hints)} hints."
        return Verdict(self.title, _said_once(rows), more, learner.printed)

    def hint(self):
        """The next hint; after the last one the first again."""
        number = self._hints_given % len(self.hints)
        self._hints_given += 1
        return Hint(number + 1, len(self.hints), self.hints[number])

    def __repr__(self):
        return f"checks.{self.name}: give it your function, {self.usage}; or ask it for a .hint()"

    def _tried(self, trial, call, seed):
        """The trial's row, and the kind of fault after which nothing more need be tried, or None."""
        try:
            trial.run(call, seed)
        except NotYet as finding:
            stop = Kind.STEPS_UP if finding.last else None
            return Row(Outcome.NOT_YET, trial.tried, trial.expected, finding.came, finding.likely, finding.map), stop
        except Fault as fault:
            stop = fault.kind if fault.kind in _NOTHING_MORE_AFTER else None
            if fault.kind is Kind.NOT_STARTED:
                return Row(Outcome.NOT_STARTED, trial.tried, trial.expected), stop
            return Row(Outcome.NOT_YET, trial.tried, trial.expected, str(fault), self._likely(fault)), stop
        except KeyboardInterrupt:
            return Row(Outcome.NOT_YET, trial.tried, trial.expected, "you stopped it"), Kind.INTERRUPTED
        except Exception as error:  # ours, however the learner's code has led to it: a check shows no traceback
            likely = "the mistake is in the check and not in your code: please show this to your teacher."
            return Row(Outcome.NOT_YET, trial.tried, trial.expected, _place_of(error), likely), None
        return Row(Outcome.PASSED, trial.tried, trial.expected), None

    def _not_tried(self, trial, stop):
        if stop is Kind.NOT_STARTED:
            return Row(Outcome.NOT_STARTED, trial.tried, trial.expected), stop
        return Row(Outcome.NOT_YET, trial.tried, trial.expected, _NOT_TRIED), stop

    def _likely(self, fault):
        words = str(fault)
        if words.startswith("RecursionError"):
            return "a function in your code calls itself too often: Python allows about 1000 such calls. Use a loop."
        if words.startswith("SystemExit"):
            return "your code ends the whole program, by `exit()` or the like: use `return`."
        if "this maze shows no" in words:
            return "your code asks for the map, which the mouse does not have."
        for pattern, likely in self._likely_errors.items():
            if fault.kind is Kind.RAISED and re.search(pattern, words):
                return likely
        return {
            Kind.LEFT_OVER: "the line `raise NotImplementedError` was left in: delete it.",
            Kind.NO_FUNCTION: f"the check was given something else than your function: `{self.usage}`.",
            Kind.SIGNATURE: f"your function has other parameters than asked: it is called as `{self.usage}`.",
            Kind.TIME_UP: "a loop in your code never ends, or does a great deal of work at every step.",
            Kind.STEPS_UP: "a loop in your code goes on, whatever answer it gets. Does an `except` hide an error?",
        }.get(fault.kind, "")


def _said_once(rows):
    """The rows; what several have to say in the same words is said in the first of them."""
    said, result = set(), []
    for row in rows:
        words = row.came, row.likely, row.map
        if row.outcome is Outcome.NOT_YET and words in said and row.came != _NOT_TRIED:
            row = Row(row.outcome, row.tried, row.expected, "the same as above")
        said.add(words)
        result.append(row)
    return tuple(result)


def _place_of(error):
    """'KeyError in task_1.py, line 7', for whoever is to mend it."""
    frame = error.__traceback__
    while frame.tb_next is not None:
        frame = frame.tb_next
    file = Path(frame.tb_frame.f_code.co_filename).name
    return f"the check itself failed: {type(error).__name__} in {file}, line {frame.tb_lineno}"
