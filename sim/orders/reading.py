"""Trials read from ARIAC trial files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

import floorplan
from floorplan import Floorplan, Problem
from floorplan.files.documents import Document

from ..core.entries import Blackout, Drop, Start
from ..core.rules import ARIAC2023
from ..core.scenario import GantryEntry, PersonEntry, Scenario, TrialError
from ..machines.gantry.robot import GANTRY
from .checks import agv_name, notices, problems
from .inventory import BELT_REACH
from .schema import (
    AgvLoad,
    AgvPart,
    AriacTrialFile,
    Challenge,
    ConveyorBelt,
    ConveyorPart,
    KittingTrays,
    Lot,
    OrderEntry,
    Parts,
    StartCondition,
)
from .workload import (
    AssemblyTask,
    ChallengePerson,
    CombinedTask,
    Conveyor,
    Item,
    KittingTask,
    Load,
    Malfunction,
    Order,
    PartType,
    Workload,
)

FLOOR = "ariac2023"
"""Floor of ARIAC trial files."""

LONGEST = 1000.0
"""Seconds after which a trial without time limit ends even if orders are left.

Twice the longest time limit of the competition.
"""

CONTROLLER = "pausing"
"""Default gantry controller for orders."""

_Model = TypeVar("_Model", bound=BaseModel)
_Made = TypeVar("_Made", bound=Scenario)


def build(form: type[_Made], document: Document, folder: Path) -> _Made:
    """Return the trial in `document`, on the floor and with the rules of the competition.

    `TrialError` contains all problems.
    """
    plan = floorplan.load(FLOOR)
    workload, doubts = read_workload(document, plan)
    path = Path(document.file)
    return form(
        floorplan=plan,
        floorplan_source=FLOOR,
        name=path.name.split(".")[0],
        duration=duration_of(workload),
        until_submitted=True,
        rules=ARIAC2023,
        people=people_of(workload),
        gantry=GantryEntry(CONTROLLER),
        folder=folder,
        workload=workload,
        notices=doubts,
    )


def read_workload(document: Document, plan: Floorplan) -> tuple[Workload, tuple[Problem, ...]]:
    """Return the work in `document` for the floor `plan`, and notices about it.

    `TrialError` contains all problems.
    """
    file, misfits = _readable(document)
    faults = [*misfits, *problems(file, plan, document)]
    if faults:
        raise TrialError(document.file, faults)
    workload = _workload(file, Path(document.file).name)
    by_line = sorted(notices(file, workload, document), key=lambda notice: notice.line or 0)
    return workload, tuple(by_line)


def duration_of(workload: Workload) -> float:
    """Return the time limit of a trial, or its maximum duration without one (s)."""
    return LONGEST if workload.time_limit is None else workload.time_limit


def people_of(workload: Workload) -> tuple[PersonEntry, ...]:
    """Return the people of the human challenge: the operator, and others by number."""
    return tuple(
        PersonEntry(
            f"operator{k + 1}" if k else "operator", personality=human.behavior, start=human.start
        )
        for k, human in enumerate(workload.humans)
    )


def _readable(document: Document) -> tuple[AriacTrialFile, tuple[Problem, ...]]:
    """Return the file with None for unreadable entries, and the problems of these."""
    try:
        return document.checked(AriacTrialFile, TrialError), ()
    except TrialError as why:
        if not isinstance(document.data, dict):
            raise
        return _salvaged(document.data), why.problems


def _salvaged(data: dict[str, Any]) -> AriacTrialFile:
    parts = _dict(data.get("parts"))
    return AriacTrialFile.model_construct(
        kitting_trays=_read(KittingTrays, data.get("kitting_trays")),
        parts=Parts.model_construct(
            bins={
                str(name): [_read(Lot, lot) for lot in _list(lots)]
                for name, lots in _dict(parts.get("bins")).items()
            },
            agvs={
                str(name): _read(AgvLoad, load) for name, load in _dict(parts.get("agvs")).items()
            },
            conveyor_belt=None,
        ),
        challenges=[_read(Challenge, one) for one in _list(data.get("challenges"))],
        orders=[_read(OrderEntry, one) for one in _list(data.get("orders"))],
    )


def _read(schema: type[_Model], data: object) -> _Model | None:
    try:
        return schema.model_validate(data)
    except ValidationError:
        return None


def _dict(data: object) -> dict[Any, Any]:
    return data if isinstance(data, dict) else {}


def _list(data: object) -> list[Any]:
    return data if isinstance(data, list) else []


def _workload(file: AriacTrialFile, source: str) -> Workload:
    parts, trays = file.parts or Parts(), file.kitting_trays or KittingTrays()
    challenges = file.challenges or []
    return Workload(
        orders=tuple(_order(entry) for entry in file.orders),
        bins={
            name: {
                slot: replace(_item(lot), faulty=slot in lot.faulty)
                for lot in lots or []
                for slot in lot.slots
            }
            for name, lots in (parts.bins or {}).items()
        },
        trays=dict(zip(trays.slots, trays.tray_ids, strict=True)),
        loads={
            name: Load(load.tray_id, {part.quadrant: _item(part) for part in load.parts or []})
            for name, load in (parts.agvs or {}).items()
            if load is not None
        },
        malfunctions=tuple(_malfunctions(challenges)),
        faulty=_faulty(challenges),
        drops=tuple(
            Drop(str(_part(drop)), drop.drop_after, drop.delay)
            for challenge in challenges
            for drop in [challenge.dropped_part]
            if drop is not None and drop.robot == "ceiling_robot"
        ),
        conveyor=_conveyor(parts.conveyor_belt),
        blackouts=tuple(
            Blackout(GANTRY, _start(blackout), blackout.duration)
            for challenge in challenges
            for blackout in [challenge.sensor_blackout]
            if blackout is not None and blackout.duration and blackout.is_of_people
        ),
        humans=tuple(
            ChallengePerson(human.behavior, _start(human))
            for challenge in challenges
            for human in (challenge.human, challenge.human_operator)
            if human is not None
        ),
        time_limit=None if file.time_limit == -1 else file.time_limit,
        source=source,
    )


def _conveyor(belt: ConveyorBelt | None) -> Conveyor:
    if belt is None or not belt.active:
        return Conveyor()
    parts = tuple(
        (_item(lot), BELT_REACH * lot.offset)
        for lot in belt.parts_to_spawn or []
        for _ in range(lot.number)
    )
    return Conveyor(parts, belt.spawn_rate, belt.order == "random")


def _malfunctions(challenges: list[Challenge]) -> Iterator[Malfunction]:
    for challenge in challenges:
        malfunction = challenge.robot_malfunction
        if malfunction is not None and "ceiling_robot" in malfunction.robots_to_disable:
            yield Malfunction(_start(malfunction), malfunction.duration)


def _faulty(challenges: list[Challenge]) -> dict[str, frozenset[int]]:
    """Return the quadrants in which the first part is faulty, by order."""
    by_order: dict[str, frozenset[int]] = {}
    for faulty in (challenge.faulty_part for challenge in challenges):
        if faulty is not None:
            marked = (faulty.quadrant1, faulty.quadrant2, faulty.quadrant3, faulty.quadrant4)
            quadrants = frozenset(k for k, is_faulty in enumerate(marked, start=1) if is_faulty)
            by_order[faulty.order_id] = by_order.get(faulty.order_id, frozenset()) | quadrants
    return by_order


def _order(entry: OrderEntry) -> Order:
    task: KittingTask | AssemblyTask | CombinedTask
    if entry.kitting_task is not None:
        kit = entry.kitting_task
        products = {product.quadrant: _part(product) for product in kit.products}
        task = KittingTask(
            agv=agv_name(kit.agv_number),
            tray=kit.tray_id,
            destination=kit.destination,
            products=products,
        )
    elif entry.assembly_task is not None:
        assembly = entry.assembly_task
        agvs = tuple(dict.fromkeys(agv_name(number) for number in assembly.agv_number))
        task = AssemblyTask(assembly.station, agvs, tuple(map(_part, assembly.products)))
    else:
        assert entry.combined_task is not None  # the schema requires one of the three
        combined = entry.combined_task
        task = CombinedTask(combined.station, tuple(map(_part, combined.products)))
    return Order(entry.id, task, announcement=_start(entry.announcement), priority=entry.priority)


def _start(condition: StartCondition) -> Start:
    if condition.submission_condition is not None:
        return Start(None, order_submitted=condition.submission_condition.order_id)
    placed = condition.part_place_condition
    if placed is not None:
        on = {} if placed.agv is None else {"agv": agv_name(placed.agv)}
        return Start(None, part_placed={"part": str(_part(placed)), **on})
    return Start(condition.time_condition)


def _item(lot: Lot | AgvPart | ConveyorPart) -> Item:
    return Item(_part(lot), lot.flipped)


def _part(entry: Any) -> PartType:
    return PartType(entry.color, entry.type)
