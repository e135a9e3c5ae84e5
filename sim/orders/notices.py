"""Notices on an ARIAC trial file: entries that are not simulated, or that will not work out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from floorplan import Document, Place, Problem

from ..core.workload import KittingTask, Order, Part, Workload
from .checks import agv_name, conditions
from .schema import Challenge, TrialFile, angle


def notices(file: TrialFile, workload: Workload, document: Document) -> Iterator[Problem]:
    """Yield the notices, each with its place; one that applies to several places comes once."""
    yield from _not_simulated(file, document)
    yield from _angles(document.data, (), document)
    yield from _nowhere(workload, document)
    yield from _never(file, document)


def _not_simulated(file: TrialFile, document: Document) -> Iterator[Problem]:
    if file.assembly_inserts:
        message = "how inserts are turned makes no difference here"
        yield document.problem(message, "assembly_inserts")
    challenges = file.challenges or []
    blind = [(k, one.sensor_blackout) for k, one in enumerate(challenges)]
    idle = [k for k, blackout in blind if blackout and not blackout.is_of_people]
    if idle:
        places = f" ({len(idle)} places)" if len(idle) > 1 else ""
        message = "break beams, proximity sensors and laser profilers see no people: their blackout"
        message += f" makes no difference here{places}"
        yield document.problem(message, "challenges", idle[0], "sensor_blackout")
    floor = [k for k, challenge in enumerate(challenges) if _is_of_floor_robot(challenge)]
    if floor:
        message = "the floor robot is not simulated, nor are its malfunctions and its dropped parts"
        yield document.problem(message, "challenges", floor[0], challenges[floor[0]].kind)
    kits = {entry.id for entry in file.orders if entry.kitting_task is not None}
    for k, challenge in enumerate(challenges):
        if challenge.faulty_part is not None and challenge.faulty_part.order_id not in kits:
            message = "faulty parts are found in kits alone: those of this order are good"
            yield document.problem(message, "challenges", k, "faulty_part", "order_id")


def _is_of_floor_robot(challenge: Challenge) -> bool:
    malfunction, dropped = challenge.robot_malfunction, challenge.dropped_part
    robots = [] if malfunction is None else malfunction.robots_to_disable
    return "floor_robot" in (*robots, None if dropped is None else dropped.robot)


def _angles(data: object, place: Place, document: Document) -> Iterator[Problem]:
    """Yield slips of the pen in angles, wherever they stand."""
    if isinstance(data, dict):
        for key, value in data.items():
            if key in ("rotation", "rpy"):
                yield from _angle_slips(value, (*place, key), document)
            else:
                yield from _angles(value, (*place, str(key)), document)
    elif isinstance(data, list):
        for k, value in enumerate(data):
            yield from _angles(value, (*place, k), document)


def _angle_slips(value: object, place: Place, document: Document) -> Iterator[Problem]:
    if isinstance(value, list):
        for k, one in enumerate(value):
            yield from _angle_slips(one, (*place, k), document)
    elif isinstance(value, str) and angle(value) is None:
        message = f"{value!r} is no angle; taken as 0, as the competition takes it"
        yield document.problem(message, *place)


def _nowhere(workload: Workload, document: Document) -> Iterator[Problem]:
    """Yield trays and parts that orders need and that are nowhere, as far as can be foreseen."""
    left = Counter(item.part for slots in workload.bins.values() for item in slots.values())
    left.update(item.part for item, _ in workload.conveyor.parts)
    on_agvs = {
        agv: {q: item.part for q, item in load.items.items()}
        for agv, load in workload.loads.items()
    }
    trays = [*workload.trays.values()]
    for k, order in enumerate(workload.orders):
        place: Place = ("orders", k, f"{order.kind}_task")
        task = order.task
        if isinstance(task, KittingTask):
            load = workload.loads.get(task.agv)
            if task.tray not in trays and (load is None or load.tray != task.tray):
                message = f"tray {task.tray} is nowhere: the kit will be made without it"
                yield document.problem(message, *place, "tray_id")
        for j, part in enumerate(_products(order)):
            if not _found(order, j, part, left, on_agvs):
                message = f"no {part} is left for it: the order will be submitted without"
                yield document.problem(message, *place, "products", j)


def _never(file: TrialFile, document: Document) -> Iterator[Problem]:
    """Yield the conditions that wait for a part that no order has put on an AGV."""
    kits = [(order.kitting_task, order.combined_task) for order in file.orders]
    placed = {  # a combined order has its parts put on any AGV
        (one.color, one.type, agv_name(kit.agv_number) if kit else None)
        for kit, combined in kits
        for one in (kit.products if kit else combined.products if combined else ())
    }
    for place, condition in conditions(file):
        wanted = condition.part_place_condition
        if wanted is not None:
            on = None if wanted.agv is None else agv_name(wanted.agv)
            met = [
                agv for color, type_, agv in placed if (color, type_) == (wanted.color, wanted.type)
            ]
            if not any(None in (on, agv) or on == agv for agv in met):
                message = f"no order has a {wanted.color} {wanted.type} put on {on or 'an AGV'}"
                yield document.problem(
                    f"{message}: it waits in vain", *place, "part_place_condition"
                )


def _products(order: Order) -> tuple[Part, ...]:
    task = order.task
    return tuple(task.products.values()) if isinstance(task, KittingTask) else task.products


def _found(
    order: Order,
    k: int,
    part: Part,
    left: Counter[Part],
    on_agvs: dict[str, dict[int, Part]],
) -> bool:
    """Take product `k` from the order's AGVs or the bins; return False if it is in none."""
    task = order.task
    if isinstance(task, KittingTask):
        quadrant = list(task.products)[k]
        kit = on_agvs.setdefault(task.agv, {})
        if kit.get(quadrant) != part:
            if not left[part]:
                return False
            left[part] -= 1
            kit[quadrant] = part
        return True
    for agv in getattr(task, "agvs", ()):
        for quadrant, one in on_agvs.get(agv, {}).items():
            if one == part:
                del on_agvs[agv][quadrant]
                return True
    if not left[part]:
        return False
    left[part] -= 1
    return True
