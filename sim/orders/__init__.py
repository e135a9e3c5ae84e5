"""Trials of the ARIAC competition: their files, their orders, and the points for them."""

from ..core.scenario import (
    AssemblyTask,
    ChallengePerson,
    CombinedTask,
    Item,
    KittingTask,
    Load,
    Malfunction,
    Order,
    PartType,
    Workload,
)
from .dispatcher import Dispatcher
from .scoring import Inserted, assembly_score, best_score, kitting_score

__all__ = [
    "AssemblyTask",
    "ChallengePerson",
    "CombinedTask",
    "Dispatcher",
    "Inserted",
    "Item",
    "KittingTask",
    "Load",
    "Malfunction",
    "Order",
    "PartType",
    "Workload",
    "assembly_score",
    "best_score",
    "kitting_score",
]
