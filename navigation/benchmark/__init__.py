"""Benchmark of planners: questions, measured and judged answers, tables and logs."""

from .measuring import SEEDED, TOUCHES, Asked, Attempt, benchmark, known
from .peers import PEERS
from .questions import QuerySet, QuestionsError, map_of, scenes, scenes_of
from .reports import (
    Curve,
    Estimate,
    PlannerRow,
    cost_over_time,
    groups,
    success_over_time,
    summary,
    write_csv,
    write_ompl_log,
    write_summary,
)
from .shortest import MOST_CORNERS, SHORTFALL, ShortestPaths

__all__ = [
    "MOST_CORNERS",
    "PEERS",
    "SEEDED",
    "SHORTFALL",
    "TOUCHES",
    "Asked",
    "Attempt",
    "Curve",
    "Estimate",
    "PlannerRow",
    "QuerySet",
    "QuestionsError",
    "ShortestPaths",
    "benchmark",
    "cost_over_time",
    "groups",
    "known",
    "map_of",
    "scenes",
    "scenes_of",
    "success_over_time",
    "summary",
    "write_csv",
    "write_ompl_log",
    "write_summary",
]
