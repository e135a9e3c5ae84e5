"""Benchmark of planners: questions, evaluated answers, tables and logs."""

from .answering import Answer, Progress, table_name
from .measuring import SEEDED, TOUCHES, Asked, Attempt, benchmark, evaluate
from .peers import PEERS
from .questions import Question, QuestionsError, drawn_questions, map_of, read_questions
from .reports import (
    Curve,
    Estimate,
    PlannerRow,
    cost_over_time,
    groups,
    median,
    share,
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
    "Answer",
    "Asked",
    "Attempt",
    "Curve",
    "Estimate",
    "PlannerRow",
    "Progress",
    "Question",
    "QuestionsError",
    "ShortestPaths",
    "benchmark",
    "cost_over_time",
    "drawn_questions",
    "evaluate",
    "groups",
    "map_of",
    "median",
    "read_questions",
    "share",
    "success_over_time",
    "summary",
    "table_name",
    "write_csv",
    "write_ompl_log",
    "write_summary",
]
