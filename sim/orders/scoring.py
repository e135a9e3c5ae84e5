"""Points for orders, by the scoring page of the competition's documentation (ARIAC 2023).

The competition multiplies the points of each order by factors for speed and cost of sensors
relative to other teams. A simulation has no other teams. The factors are 1, and a trial's score is
the sum of its orders' points ("completion score").
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from floorplan.files.dataclass import dataclass

from .workload import AssemblyTask, CombinedTask, KittingTask, Load, PartType

TRAY_POINTS = 3
KIT_PART_POINTS = 3
ASSEMBLY_PART_POINTS = 3
COMBINED_PART_POINTS = 5
ASSEMBLY_BONUS = 4


@dataclass(frozen=True)
class Inserted:
    """A part that was inserted at an assembly station, and whether its pose is right."""

    part: PartType
    right_pose: bool = True


def kitting_score(
    task: KittingTask, shipment: Load, *, arrived: bool, faulty: Iterable[int] = ()
) -> int:
    """Return the points for a kit.

    `arrived` is True if the AGV is at its destination, and `faulty` contains the quadrants with
    faulty parts.
    """
    points = [
        _kit_part_points(part, shipment, quadrant, set(faulty))
        for quadrant, part in task.products.items()
    ]
    n, m = len(points), len(shipment.items)
    tray = TRAY_POINTS if shipment.tray == task.tray else 0
    bonus = n if sum(points) == n * KIT_PART_POINTS else 0
    return max(tray + sum(points) + bonus - max(m - n, 0), 0) if arrived else 0


def assembly_score(task: AssemblyTask | CombinedTask, inserted: Mapping[str, Inserted]) -> int:
    """Return the points for the parts inserted at the task's station, by type of the part.

    Parts inserted at other stations give no points.
    """
    full = COMBINED_PART_POINTS if isinstance(task, CombinedTask) else ASSEMBLY_PART_POINTS
    points = [_inserted_points(part, inserted.get(part.type), full) for part in task.products]
    bonus = len(points) * ASSEMBLY_BONUS if sum(points) == len(points) * full else 0
    return sum(points) + bonus


def best_score(task: KittingTask | AssemblyTask | CombinedTask) -> int:
    """Return the points for a task without a fault."""
    n = len(task.products)
    if isinstance(task, KittingTask):
        return TRAY_POINTS + n * KIT_PART_POINTS + n
    full = COMBINED_PART_POINTS if isinstance(task, CombinedTask) else ASSEMBLY_PART_POINTS
    return n * full + n * ASSEMBLY_BONUS


def _kit_part_points(part: PartType, shipment: Load, quadrant: int, faulty: set[int]) -> int:
    item = shipment.items.get(quadrant)
    if item is None or item.part.type != part.type or quadrant in faulty:
        return 0
    return KIT_PART_POINTS - (item.part.color != part.color) - item.flipped


def _inserted_points(part: PartType, inserted: Inserted | None, full: int) -> int:
    if inserted is None:
        return 0
    return full - (inserted.part.color != part.color) - (not inserted.right_pose)
