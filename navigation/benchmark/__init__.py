"""Benchmark of planners: seeded questions, measured answers, tables and logs."""

from .measuring import Attempt, Scene, benchmark, scenes
from .reports import Row, summary, write_csv, write_ompl_log
from .shortest import SHORTFALL, ShortestPaths

__all__ = [
    "SHORTFALL",
    "Attempt",
    "Row",
    "Scene",
    "ShortestPaths",
    "benchmark",
    "scenes",
    "summary",
    "write_csv",
    "write_ompl_log",
]
