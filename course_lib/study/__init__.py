"""The same thing many times: many settings, many seeds, here or on a cluster, and what they say together."""

from course_lib.study.results import Results
from course_lib.study.running import run, workers
from course_lib.study.statistics import (
    Estimate,
    band,
    bootstrap,
    difference,
    interquartile_mean,
    probability_of_improvement,
)
from course_lib.study.training import thinned, train_networks, train_tables
from course_lib.study.work import CellFailed

__all__ = [
    "CellFailed",
    "Estimate",
    "Results",
    "band",
    "bootstrap",
    "difference",
    "interquartile_mean",
    "probability_of_improvement",
    "run",
    "thinned",
    "train_networks",
    "train_tables",
    "workers",
]
