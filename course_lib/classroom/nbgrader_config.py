"""nbgrader's settings for a class; `Course.new` copies this file into the teacher's folder, to be changed there.

What else can be set: https://nbgrader.readthedocs.io/en/stable/configuration/config_options.html
"""

c = get_config()  # noqa: F821 (traitlets hands it in when it reads this file)

theirs, ours = "nbgrader.preprocessors", "course_lib.classroom.preprocessors"

# From a source to what learners get. The order is nbgrader's: checksums are taken twice, since the gradebook keeps the
# cells with their hidden tests and learners get them without.
c.ClearSolutions.code_stub = {"python": "raise NotImplementedError  # your code here"}
c.ClearSolutions.text_stub = "*Your answer here.*"
c.GenerateAssignment.preprocessors = [
    f"{ours}.RelinkCells",
    f"{theirs}.LockCells",
    f"{theirs}.ClearSolutions",
    f"{theirs}.ClearOutput",
    f"{theirs}.CheckCellMetadata",
    f"{theirs}.ComputeChecksums",
    f"{theirs}.SaveCells",
    f"{theirs}.ClearHiddenTests",
    f"{theirs}.ClearMarkScheme",
    f"{ours}.TrimCells",
    f"{theirs}.ComputeChecksums",
    f"{theirs}.CheckCellMetadata",
]

# From a submission to points. nbgrader stops, for all learners, at a check cell that one of them has copied, so every
# notebook is first made anew. Then the course's judge stands where nbgrader would run it in one kernel, in which a
# learner's code could reach the checks.
c.Autograde.sanitize_preprocessors = [
    f"{ours}.RebuildCells",
    f"{theirs}.ClearOutput",
    f"{theirs}.OverwriteKernelspec",
    f"{theirs}.OverwriteCells",
    f"{theirs}.CheckCellMetadata",
]
c.Autograde.autograde_preprocessors = [
    "course_lib.classroom.judge.JudgePreprocessor",
    f"{theirs}.IgnorePattern",
    f"{theirs}.LimitOutput",
    f"{theirs}.SaveAutoGrades",
    f"{theirs}.AssignLatePenalties",
    f"{theirs}.CheckCellMetadata",
]
c.JudgePreprocessor.time_limit = 30.0  # seconds for a cell, or for one call of a learner's function
c.JudgePreprocessor.total_time_limit = 300.0  # seconds for a whole submission
c.JudgePreprocessor.memory_limit = 4_000_000_000  # bytes
c.JudgePreprocessor.output_limit = 10_000_000  # bytes of prints

# From points to pages that learners may see, and that a teacher opens: no script of a learner's runs in them.
c.GenerateFeedback.exporter_class = "course_lib.classroom.pages.FeedbackPage"
c.GenerateFeedback.preprocessors = [
    f"{theirs}.GetGrades",
    f"{ours}.HideTests",
    "nbconvert.preprocessors.CSSHTMLHeaderPreprocessor",
]

# From the learners' servers to `submitted`, where both work on one machine: nbgrader's own step trusts them too much.
c.ExchangeFactory.collect = "course_lib.classroom.collect.CollectOwn"
