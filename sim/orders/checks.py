"""Checks of an ARIAC trial file beyond its keys and types: the things it names are there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from floorplan import Document, Floorplan, Place, Problem, suggestion

from . import layout
from .schema import Condition, OrderEntry, TrialFile


def problems(file: TrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
    """Return everything that keeps the file from being run on this floor, each with its place.

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
    """Return the AGV that a trial file knows by its number."""
    return f"agv{number}"


def conditions(file: TrialFile) -> Iterator[tuple[Place, Condition]]:
    """Yield every condition of the file, and its place."""
    for k, order in enumerate(file.orders):
        if order:
            yield ("orders", k, "announcement"), order.announcement
    for k, challenge in enumerate(file.challenges or []):
        if challenge:
            figures = getattr(challenge, challenge.kind)
            if isinstance(figures, Condition):
                yield ("challenges", k, challenge.kind), figures


def _floor_problems(file: TrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
    if plan.gantry is None:
        yield document.problem(f"the floorplan {plan.name} has no gantry to work on orders")
    missing = layout.lacking(plan, belt=_has_belt(file))
    if missing:
        yield document.problem(
            f"the floorplan {plan.name} has no {', '.join(missing)} to work on orders with"
        )


def _supply_problems(file: TrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
    trays = file.kitting_trays
    if trays and len(trays.tray_ids) != len(trays.slots):
        message = f"{len(trays.tray_ids)} tray_ids and {len(trays.slots)} slots don't go together"
        yield document.problem(message, "kitting_trays")
    if trays:
        slots = [(("kitting_trays", "slots", k), slot) for k, slot in enumerate(trays.slots)]
        yield from _twice(slots, "there is a tray in slot", document)
    known = [o.name for o in plan.obstacles if o.name.startswith("bin")]
    for name, lots in ((file.parts and file.parts.bins) or {}).items():
        place: Place = ("parts", "bins", name)
        if name not in known:
            yield document.problem(f"no bin is called {name!r}; {suggestion(name, known)}", *place)
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


def _reach_problems(file: TrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
    """Yield the things needed for orders that the gantry can't get to; each once."""
    if plan.gantry is None:
        return
    middles = {obstacle.name: obstacle.footprint.centroid for obstacle in plan.obstacles}
    reported: set[str] = set()
    bins = (file.parts and file.parts.bins) or {}
    for name, (dx, dy) in layout.errands(plan, bins, belt=_has_belt(file)):
        if name not in middles or name in reported:
            continue
        target = (middles[name].x + dx, middles[name].y + dy, plan.gantry.start[2])
        for fault in plan.gantry.faults(target):
            reported.add(name)
            place = ("parts", "bins", name) if name.startswith("bin") else ()
            yield document.problem(f"the gantry can't get to {name!r}: {fault}", *place)


def _has_belt(file: TrialFile) -> bool:
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
            known = ", ".join([*lane.locations, *lane.serves])
            message = f"{lane.name} can't go to {kit.destination!r} (it goes to: {known})"
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


def _condition_problems(file: TrialFile, plan: Floorplan, document: Document) -> Iterator[Problem]:
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
        known = ", ".join(name.removeprefix("agv") for name in names)
        yield document.problem(f"there is no AGV {number} (there are: {known})", *place)


def _twice(
    entries: Iterable[tuple[Place, object]], what: str, document: Document
) -> Iterator[Problem]:
    """Yield a problem for every value of `entries` that stood there before."""
    seen: set[object] = set()
    for place, value in entries:
        if value in seen:
            yield document.problem(f"{what} {value} already", *place)
        seen.add(value)


def _no_order(order: str, known: Sequence[str], place: Place, document: Document) -> Problem:
    return document.problem(f"no order is called {order!r}; {suggestion(order, known)}", *place)
