"""Scope of the orders of a trial. It decides which figures a run has."""

from __future__ import annotations

from ..core.scenario import Scenario
from .workload import Workload


def has_orders(trial: Scenario) -> bool:
    """Return True if there are orders, and a gantry that can work on them."""
    return trial.workload is not None and trial.floorplan.gantry is not None


def _workload(trial: Scenario) -> Workload | None:
    """Return the workload if a gantry can work on it."""
    return trial.workload if has_orders(trial) and isinstance(trial.workload, Workload) else None


def has_faulty_parts(trial: Scenario) -> bool:
    """Return True if the quality check may find faulty parts."""
    work = _workload(trial)
    return work is not None and (
        bool(work.faulty)
        or any(item.faulty for slots in work.bins.values() for item in slots.values())
    )


def has_conveyor(trial: Scenario) -> bool:
    """Return True if parts arrive on a conveyor."""
    work = _workload(trial)
    return work is not None and bool(work.conveyor.parts)


def has_drops(trial: Scenario) -> bool:
    """Return True if a gripper drops parts."""
    more = (entry.keys.get("drops") for entry in trial.machines.values())
    ordered = trial.workload.drops if isinstance(trial.workload, Workload) else ()
    return any((trial.gantry.drops, ordered, *more))
