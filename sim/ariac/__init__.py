"""Trials of the ARIAC competition: their files, their orders, and the points for them."""

from .orders import (
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
from .scoring import Inserted, assembly_score, best_score, kitting_score
from .workcell import Workcell

__all__ = [
    "AssemblyTask",
    "CombinedTask",
    "Human",
    "Inserted",
    "Item",
    "KittingTask",
    "Load",
    "Malfunction",
    "Order",
    "Part",
    "Workcell",
    "Workload",
    "assembly_score",
    "best_score",
    "kitting_score",
]
