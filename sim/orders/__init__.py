"""Trials of the ARIAC competition: their files, their orders, and the points for them."""

from ..core.workload import (
    AssemblyTask,
    CombinedTask,
    Human,
    Item,
    KittingTask,
    Load,
    Malfunction,
    Order,
    Part,
    Workload,
)
from .dispatcher import Dispatcher
from .scoring import Inserted, assembly_score, best_score, kitting_score

__all__ = [
    "AssemblyTask",
    "CombinedTask",
    "Dispatcher",
    "Human",
    "Inserted",
    "Item",
    "KittingTask",
    "Load",
    "Malfunction",
    "Order",
    "Part",
    "Workload",
    "assembly_score",
    "best_score",
    "kitting_score",
]
