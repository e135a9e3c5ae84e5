"""Assumptions behind a run: the floor, the machines, and the rules that hold on it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from markupsafe import Markup

from floorplan import Floorplan, Zone
from navigation import AnyLaw

from ...core.machine import MachineShape
from ...core.machine_model import MachineModel
from ...core.rules import RuleSet
from ...core.scene import Scene
from ...core.work import as_given
from ...record.risk import CELL
from ...record.zone_exposure import MOMENT
from .laws import law_sheet
from .parts import Cell, Facts, Points, Table, listed, minus


def floor_facts(plan: Floorplan) -> Facts:
    """Return what the floor is and what is on it."""
    west, south, east, north = plan.boundary.bounds
    there = {
        "obstacle": len(plan.obstacles),
        "station": len(plan.stations),
        "door": len(plan.doors),
        "zone": len(plan.zones),
        "AGV lane": len(plan.lanes),
        "gantry": int(plan.gantry is not None),
    }
    rows: list[tuple[str, Cell]] = [
        ("name", plan.title or plan.name),
        ("source", plan.source or NO_SOURCE),
        ("size", f"{east - west:g} m × {north - south:g} m, {plan.boundary.area:,.1f} m² inside"),
        ("on it", ", ".join(counted(n, what) for what, n in there.items() if n) or "nothing"),
        *(("left out or taken for granted", str(notice)) for notice in plan.notices[:MOST_NOTICES]),
    ]
    if (more := len(plan.notices) - MOST_NOTICES) > 0:
        rows.append(("", f"and {more} more notices, as of floorwalker check"))
    return Facts(rows, "The floor")


NO_SOURCE = "no source given"

MOST_NOTICES = 10
"""Notices of a floor that are printed."""


def _rules(zone: Zone) -> Iterator[str]:
    if zone.forbidden:
        yield "forbidden"
    if zone.max_speed is not None:
        yield f"at most {zone.max_speed:g} m/s"
    if zone.one_way is not None:
        yield minus("one way, towards ({:g}, {:g})".format(*zone.one_way))


def zones_table(plan: Floorplan) -> Table:
    """Return the zones of a floor with their rules."""
    rows = [
        (
            zone.name,
            f"{zone.area.area:,.1f}",
            ", ".join(_rules(zone)),
            "everybody" if zone.concerns == ("*",) else ", ".join(zone.concerns),
        )
        for zone in plan.zones
    ]
    heads = ("zone", "area, m²", "rule", "for")
    return Table(heads, rows, "Zones", figures=frozenset({1}))


def machines_table(scene: Scene, models: Mapping[str, MachineModel]) -> Table:
    """Return the machines: sizes, top speeds, and the stops that their limits leave them."""
    rows = []
    for names, shape, stop in _alike(scene, models):
        size = f"{shape.length:g} × {shape.width:g}, from {shape.bottom:g} to {shape.top:g} high"
        stops = "not known" if stop is None else f"{stop[0]:.2f} s, {stop[1]:.2f} m"
        law = _law_key(scene.rules, shape)
        rows.append((listed(names), shape.kind, size, f"{shape.top_speed:.2f}", stops, law))
    words = "Sizes in metres. The stop is the longest and farthest that the limits allow."
    heads = ("machine", "kind", "size", "top speed, m/s", "stop", "law")
    return Table(heads, rows, "Machines", words, frozenset({3}))


def _alike(
    scene: Scene, models: Mapping[str, MachineModel]
) -> Iterable[tuple[list[str], MachineShape, tuple[float, float] | None]]:
    """Yield machines that differ in their names alone, together."""
    groups: dict[str, tuple[list[str], MachineShape, tuple[float, float] | None]] = {}
    for shape in scene.machines:
        model = models.get(shape.name)
        stop = None if model is None else model.longest_stop(scene.floorplan)
        size = (shape.kind, shape.length, shape.width, shape.bottom, shape.top, shape.top_speed)
        key = repr((size, stop, _law_key(scene.rules, shape)))
        groups.setdefault(key, ([], shape, stop))[0].append(shape.name)
    return groups.values()


def _law_key(rules: RuleSet, shape: MachineShape) -> str:
    return rules.law_and_key_of(shape)[0]


def laws_of(rules: RuleSet, machines: Iterable[MachineShape]) -> list[tuple[str, AnyLaw]]:
    """Return the laws that hold for some machines, each with its keys and machines in words."""
    found: list[tuple[AnyLaw, dict[str, list[str]]]] = []
    for machine in machines:
        key, law = rules.law_and_key_of(machine)
        known = next((keys for other, keys in found if other == law), None)
        if known is None:
            found.append((law, known := {}))
        known.setdefault(key, []).append(machine.name)
    return [
        ("; ".join(f"{key}: {listed(names)}" for key, names in keys.items()), law)
        for law, keys in found
    ]


def law_table(laws: Sequence[tuple[str, AnyLaw]]) -> Table:
    """Return laws, each with the machines or trials it holds for, its formula and its terms."""
    rows: list[Sequence[Cell]] = []
    for key, law in laws:
        sheet = law_sheet(law)
        terms = Markup("<br>").join(_term(*term) for term in sheet.terms)
        formula = Markup('<span class="formula">{}</span>').format(sheet.formula)
        rows.append((key, sheet.name, formula, terms))
    return Table(("holds for", "law", "required distance", "terms"), rows, "Required distances")


def _term(symbol: Markup, value: str, meaning: str) -> Markup:
    if not value:
        return Markup("{}: {}").format(symbol, meaning)
    return Markup("{} = {}{}").format(symbol, value, f", {meaning}" if meaning else "")


def rules_facts(rules: RuleSet) -> Facts:
    """Return what follows from a violation, and when people notice a machine."""
    machine = {
        "none": "goes on",
        "stop": "makes a protective stop until there is room again",
        "disable": f"a gantry is disabled for {rules.gantry_disabled:g} s (a penalty)"
        + (f"; no consequence in the {rules.grace:g} s after that" if rules.grace else ""),
    }[rules.machine]
    pause = f"{rules.pause_after_violation:g} s ({rules.pause_after_agv:g} s for an AGV)"
    person = {
        "none": "walks on, and does not know of it",
        "teleport": f"is put into the safe zone and waits there for {pause}",
    }[rules.person]
    notice = rules.notice
    noticed = law_sheet(notice.law)
    again = (
        f"once until the two have parted by {notice.parting:g} m"
        if notice.every is None
        else f"at most every {notice.every:g} s"
    )
    rows: list[tuple[str, Cell]] = [
        ("rule set", f"{rules.name}{f' ({rules.summary})' if rules.summary else ''}"),
        ("a violation", VIOLATION),
        ("the machine", machine),
        ("the person", person),
        ("people notice a robot", Markup("inside {}; {}").format(noticed.formula, again)),
    ]
    if rules.reactions:
        waits = (f"{name} {seconds:g} s" for name, seconds in rules.reactions.items())
        rows.append(("people react to a robot after", ", ".join(waits)))
    if rules.agv_offset:
        point = f"the point {rules.agv_offset:g} m along its lane from its centre"
        rows.append(("distance to an AGV", f"to {point}"))
    if rules.between_people is not None:
        rows.append(("between people", f"recorded below {rules.between_people:g} m"))
    return Facts(rows)


VIOLATION = (
    "begins when a person is nearer to a robot, or to a vehicle that moves, than the law requires;"
    " distances are between the centres on the floor"
)


def resolution() -> Points:
    """Return how exact the figures of a report are."""
    return Points(
        (
            "Motions are formulas of time. The instants at which violations begin and end are"
            " solved for, right to 0.1 µs; none that is longer is missed.",
            "The least margin of a violation is solved for to 1 µm where the law is a formula of"
            f" two speeds, else looked for every {MOMENT:g} s.",
            f"Exposure to zones is summed up in steps of {MOMENT:g} s while somebody moves: a time"
            " is right to that for each time that they come in or go out.",
            f"Maps have cells of {CELL:g} m and the same steps; a spot counts while it is under the"
            " body of a person.",
            "The same trial and seed give the same run, to the byte: every figure can be repeated.",
        ),
        "Resolution",
    )


def counted(count: int, what: str) -> str:
    """Return how many there are of something."""
    if what == "person":
        return "1 person" if count == 1 else f"{count:,} people"
    plural = f"{what[:-1]}ies" if what.endswith("y") and what[-2] not in "aeiou" else f"{what}s"
    return f"{count:,} {what if count == 1 else plural}"


def span(begin: float, end: float) -> str:
    """Return an interval of time as the trial has it."""
    return f"{as_given(begin)} – {'the end' if end == math.inf else as_given(end)}"
