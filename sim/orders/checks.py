"""Checks of an ARIAC trial file: missing names, and entries that have no effect."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from floorplan import Floorplan, Problem
from floorplan.files.documents import Document
from floorplan.files.problems import Place, suggestion

from .inventory import errands, lacking
from .schema import AriacTrialFile, Challenge, OrderEntry, StartCondition, angle
from .workload import KittingTask, Order, PartType, Workload


def problems(file: AriacTrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
    """Return all problems that keep the file from being run on this floor, with their places.

    Entries of `file` that could not be read are None, and have been reported.
    """
    orders = [(k, order) for k, order in enumerate(file.orders) if order]
    yield from _floor_problems(file, plan, document)
    yield from _supply_problems(file, plan, document)
    yield from _reach_problems(file, plan, document)
    yield from _twice(
        [(("orders", k, "id"), order.id) for k, order in orders], "there is an order", document
    )
    for k, order in orders:
        yield from _order_problems(order, plan, document, k)
    yield from _condition_problems(file, plan, document)
    yield from _never_announced(orders, document)


def agv_name(number: int) -> str:
    """Return the AGV with the number of a trial file."""
    return f"agv{number}"


def conditions(file: AriacTrialFile) -> Iterator[tuple[Place, StartCondition]]:
    """Yield every condition of the file with its place."""
    for k, order in enumerate(file.orders):
        if order:
            yield ("orders", k, "announcement"), order.announcement
    for k, challenge in enumerate(file.challenges or []):
        if challenge:
            figures = getattr(challenge, challenge.kind)
            if isinstance(figures, StartCondition):
                yield ("challenges", k, challenge.kind), figures


def _floor_problems(file: AriacTrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
    if plan.gantry is None:
        yield document.problem(f"the floorplan {plan.name} has no gantry to work on orders")
    missing = lacking(plan, belt=_has_belt(file))
    if missing:
        yield document.problem(
            f"the floorplan {plan.name} has no {', '.join(missing)} to work on orders with"
        )


def _supply_problems(
    file: AriacTrialFile, plan: Floorplan, document: Document
) -> Iterator[Problem]:
    trays = file.kitting_trays
    if trays and len(trays.tray_ids) != len(trays.slots):
        message = f"{len(trays.tray_ids)} tray_ids and {len(trays.slots)} slots don't go together"
        yield document.problem(message, "kitting_trays")
    if trays:
        slots = [(("kitting_trays", "slots", k), slot) for k, slot in enumerate(trays.slots)]
        yield from _twice(slots, "there is a tray in slot", document)
    all_bins = [o.name for o in plan.obstacles if o.name.startswith("bin")]
    for name, lots in ((file.parts and file.parts.bins) or {}).items():
        place: Place = ("parts", "bins", name)
        if name not in all_bins:
            yield document.problem(
                f"no bin is called {name!r}; {suggestion(name, all_bins)}", *place
            )
        taken = [
            ((*place, k, "slots", j), slot)
            for k, lot in enumerate(lots or [])
            if lot
            for j, slot in enumerate(lot.slots)
        ]
        yield from _twice(taken, "there is a part in slot", document)
    lanes = [lane.name for lane in plan.lanes]
    for name, load in ((file.parts and file.parts.agvs) or {}).items():
        place = ("parts", "agvs", name)
        if name not in lanes:
            yield document.problem(f"no AGV is called {name!r}; {suggestion(name, lanes)}", *place)
        filled = [
            ((*place, "parts", k, "quadrant"), part.quadrant)
            for k, part in enumerate((load and load.parts) or [])
        ]
        yield from _twice(filled, "there is a part in quadrant", document)


def _reach_problems(file: AriacTrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
    """Yield the objects of orders that the gantry cannot reach, each once."""
    if plan.gantry is None:
        return
    middles = {obstacle.name: obstacle.footprint.centroid for obstacle in plan.obstacles}
    reported: set[str] = set()
    bins = (file.parts and file.parts.bins) or {}
    for name, (dx, dy) in errands(plan, bins, belt=_has_belt(file)):
        if name not in middles or name in reported:
            continue
        target = (middles[name].x + dx, middles[name].y + dy, plan.gantry.start[2])
        for fault in plan.gantry.faults(target):
            reported.add(name)
            place = ("parts", "bins", name) if name.startswith("bin") else ()
            yield document.problem(f"the gantry can't get to {name!r}: {fault}", *place)


def _has_belt(file: AriacTrialFile) -> bool:
    belt = file.parts and file.parts.conveyor_belt
    return bool(belt and belt.active and belt.parts_to_spawn)


def _order_problems(
    order: OrderEntry, plan: Floorplan, document: Document, k: int
) -> Iterator[Problem]:
    place: Place = ("orders", k, f"{order.type}_task")
    stations = {station for lane in plan.lanes for station in lane.serves}
    if order.kitting_task:
        kit = order.kitting_task
        number: Place = (*place, "agv_number")
        yield from _agv_problems(kit.agv_number, number, plan, document)
        lane = next((one for one in plan.lanes if one.name == agv_name(kit.agv_number)), None)
        if lane and kit.destination not in {*lane.locations, *lane.serves}:
            locations = ", ".join([*lane.locations, *lane.serves])
            message = f"{lane.name} can't go to {kit.destination!r} (it goes to: {locations})"
            yield document.problem(message, *place, "destination")
        filled = [
            ((*place, "products", j, "quadrant"), product.quadrant)
            for j, product in enumerate(kit.products)
        ]
        yield from _twice(filled, "the order has a part for quadrant", document)
    assembly = order.assembly_task or order.combined_task
    if assembly and assembly.station not in stations:
        message = f"no AGV serves a station {assembly.station!r}; "
        message += suggestion(assembly.station, sorted(stations))
        yield document.problem(message, *place, "station")
    if assembly:
        types = [
            ((*place, "products", j, "type"), product.type)
            for j, product in enumerate(assembly.products)
        ]
        yield from _twice(types, "the insert has one place for each type, and there is a", document)
    for j, agv in enumerate(order.assembly_task.agv_number if order.assembly_task else []):
        number = (*place, "agv_number", j)
        yield from _agv_problems(agv, number, plan, document)
        lane = next((one for one in plan.lanes if one.name == agv_name(agv)), None)
        station = assembly.station if assembly else ""
        if lane and station in stations and station not in lane.serves:
            message = f"{lane.name} does not serve {station} (but {', '.join(lane.serves)})"
            yield document.problem(message, *number)


def _condition_problems(
    file: AriacTrialFile, plan: Floorplan, document: Document
) -> Iterator[Problem]:
    raw = document.data.get("orders")
    entries = raw if isinstance(raw, list) else []
    ids = sorted({str(entry.get("id")) for entry in entries if isinstance(entry, dict)})
    for place, condition in conditions(file):
        if condition.part_place_condition and condition.part_place_condition.agv is not None:
            number: Place = (*place, "part_place_condition", "agv")
            agv = condition.part_place_condition.agv
            yield from _agv_problems(agv, number, plan, document)
        if condition.submission_condition:
            order = condition.submission_condition.order_id
            if order not in ids:
                where: Place = (*place, "submission_condition", "order_id")
                yield _no_order(order, ids, where, document)
    for k, challenge in enumerate(file.challenges or []):
        if challenge and challenge.faulty_part and challenge.faulty_part.order_id not in ids:
            where = ("challenges", k, "faulty_part", "order_id")
            yield _no_order(challenge.faulty_part.order_id, ids, where, document)


def _never_announced(
    orders: Sequence[tuple[int, OrderEntry]], document: Document
) -> Iterator[Problem]:
    """Yield the orders that wait for each other, or for themselves."""
    waits = {
        order.id: order.announcement.submission_condition.order_id
        for _, order in orders
        if order.announcement.submission_condition
    }
    places = {order.id: k for k, order in orders}
    settled: set[str] = set()
    for name in waits:
        chain: dict[str, None] = {}
        while name in waits and name not in settled and name not in chain:
            chain[name] = None
            name = waits[name]
        settled.update(chain)
        if name in chain:
            names = list(chain)
            circle = [*names[names.index(name) :], name]
            message = f"is never announced: {' after '.join(circle)}"
            yield document.problem(message, "orders", places[name], "announcement")


def _agv_problems(
    number: int, place: Place, plan: Floorplan, document: Document
) -> Iterator[Problem]:
    names = [lane.name for lane in plan.lanes]
    if agv_name(number) not in names:
        numbers = ", ".join(name.removeprefix("agv") for name in names)
        yield document.problem(f"there is no AGV {number} (there are: {numbers})", *place)


def _twice(
    entries: Iterable[tuple[Place, object]], what: str, document: Document
) -> Iterator[Problem]:
    """Yield a problem for every repeated value of `entries`."""
    seen: set[object] = set()
    for place, value in entries:
        if value in seen:
            yield document.problem(f"{what} {value} already", *place)
        seen.add(value)


def _no_order(order: str, orders: Sequence[str], place: Place, document: Document) -> Problem:
    return document.problem(f"no order is called {order!r}; {suggestion(order, orders)}", *place)


def notices(file: AriacTrialFile, workload: Workload, document: Document) -> Iterator[Problem]:
    """Yield the notices with their places, each once."""
    yield from _not_simulated(file, document)
    yield from _angles(document.data, (), document)
    yield from _nowhere(workload, document)
    yield from _never(file, document)


def _not_simulated(file: AriacTrialFile, document: Document) -> Iterator[Problem]:
    if file.assembly_inserts:
        message = "the rotation of inserts is ignored"
        yield document.problem(message, "assembly_inserts")
    challenges = file.challenges or []
    blind = [(k, one.sensor_blackout) for k, one in enumerate(challenges)]
    idle = [k for k, blackout in blind if blackout and not blackout.is_of_people]
    if idle:
        places = f" ({len(idle)} places)" if len(idle) > 1 else ""
        message = "break beams, proximity sensors and laser profilers do not detect people:"
        message += " their blackout"
        message += f" has no effect{places}"
        yield document.problem(message, "challenges", idle[0], "sensor_blackout")
    floor = [k for k, challenge in enumerate(challenges) if _is_of_floor_robot(challenge)]
    if floor:
        message = "the floor robot is not simulated, nor are its malfunctions and its dropped parts"
        yield document.problem(message, "challenges", floor[0], challenges[floor[0]].kind)
    kits = {entry.id for entry in file.orders if entry.kitting_task is not None}
    for k, challenge in enumerate(challenges):
        if challenge.faulty_part is not None and challenge.faulty_part.order_id not in kits:
            message = "faulty parts are only found in kits; those of this order are good"
            yield document.problem(message, "challenges", k, "faulty_part", "order_id")


def _is_of_floor_robot(challenge: Challenge) -> bool:
    malfunction, dropped = challenge.robot_malfunction, challenge.dropped_part
    robots = [] if malfunction is None else malfunction.robots_to_disable
    return "floor_robot" in (*robots, None if dropped is None else dropped.robot)


def _angles(data: object, place: Place, document: Document) -> Iterator[Problem]:
    """Yield probable typing errors of angles."""
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
        message = f"{value!r} is not an angle; 0 is used, as in the competition"
        yield document.problem(message, *place)


def _nowhere(workload: Workload, document: Document) -> Iterator[Problem]:
    """Yield trays and parts that orders need and that are missing, as far as is foreseeable."""
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
                message = f"tray {task.tray} does not exist; the kit will be made without it"
                yield document.problem(message, *place, "tray_id")
        for j, part in enumerate(_products(order)):
            if not _found(order, j, part, left, on_agvs):
                message = f"no {part} is left for it: the order will be submitted without"
                yield document.problem(message, *place, "products", j)


def _never(file: AriacTrialFile, document: Document) -> Iterator[Problem]:
    """Yield the conditions that wait for a part that no order places on an AGV."""
    kits = [(order.kitting_task, order.combined_task) for order in file.orders]
    placed = {  # combined orders may use any AGV
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
                    f"{message}; it waits forever", *place, "part_place_condition"
                )


def _products(order: Order) -> tuple[PartType, ...]:
    task = order.task
    return tuple(task.products.values()) if isinstance(task, KittingTask) else task.products


def _found(
    order: Order,
    k: int,
    part: PartType,
    left: Counter[PartType],
    on_agvs: dict[str, dict[int, PartType]],
) -> bool:
    """Take product `k` from the order's AGVs or the bins. Return False if it is missing."""
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
