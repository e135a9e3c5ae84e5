"""Benchmark of planners: questions, measured and judged answers, tables and logs."""

from .attempts import TOUCHES, Asked, Attempt
from .measuring import SEEDED, benchmark, known
from .ompl_log import write_ompl_log
from .peers import PEERS, PeerInfo
from .questions import QuestionsError, Scene, map_of, scenes, scenes_of
from .reports import Row, groups, summary, write_csv, write_summary
from .shortest import MOST_CORNERS, SHORTFALL, ShortestPaths
from .statistics import Curve, Estimate, cost_over_time, success_over_time

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
    "PeerInfo",
    "QuestionsError",
    "Row",
    "Scene",
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
