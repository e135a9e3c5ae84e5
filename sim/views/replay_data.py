"""A run as the JSON of its replay page."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from floorplan import Floorplan, Gantry, Gate, Lane, Obstacle, Zone
from navigation import Piece, SeparationLaw
from navigation.separation import AnyLaw, required_at_speeds

from ..core.body import MachineShape
from ..core.fields import MachineFields
from ..core.recorder import rounded
from ..core.rules import RuleSet
from ..machines.kinds import rails_under
from ..record.figures import COSTS
from ..record.outcome import Outcome
from ..safety.laws import is_of_speeds_alone
from .replay import FORMAT, without_zeros


def replay_data(run: Outcome) -> dict[str, Any]:
    """Return the run in the format of the replay page: metres, seconds, radians."""
    plan, trial, controller = run.floorplan, run.scene.trial, run.scene.controller
    data: dict[str, Any] = rounded(
        {
            "format": FORMAT,
            "title": trial if trial == plan.name else f"{trial} · {plan.name}",
            "duration": run.duration,
            "summary": {k: v for k, v in run.summary.items() if k not in COSTS},
            "floorplan": _floorplan(plan),
            "bodies": _bodies(run),
            "motions": {
                name: [piece_data(piece) for piece in motion.pieces]
                for name, motion in run.motions.items()
            },
            "events": run.events,
            "watches": _watches(run),
            "minds": _minds(run),
            **_passing(run),
            **({"controller": controller} if controller else {}),
        }
    )
    return data


def _floorplan(plan: Floorplan) -> dict[str, Any]:
    zone, gantry = plan.safe_zone, plan.gantry
    return {
        "name": plan.name,
        "title": plan.title,
        "boundary": plan.boundary.exterior.coords[:-1],
        "holes": [ring.coords[:-1] for ring in plan.boundary.interiors],
        "obstacles": [_obstacle(obstacle) for obstacle in plan.obstacles],
        "stations": [{"name": s.name, "at": s.position} for s in plan.stations],
        "safe_zone": {"at": zone.position, "heading": zone.heading} if zone else None,
        "lanes": [_lane(lane) for lane in plan.lanes],
        "gantry": {
            "x": [gantry.x.low, gantry.x.high],
            "y": [gantry.y.low, gantry.y.high],
            "rail_height": gantry.rail_height,
        }
        if gantry
        else None,
        **({"zones": [_zone(zone) for zone in plan.zones]} if plan.zones else {}),
        **({"gates": [_gate(gate) for gate in plan.one_ways]} if plan.one_ways else {}),
    }


def _obstacle(obstacle: Obstacle) -> dict[str, Any]:
    return {
        "name": obstacle.name,
        "footprint": obstacle.footprint.exterior.coords[:-1],
        "bottom": obstacle.bottom,
        "top": obstacle.top,
    }


def _zone(zone: Zone) -> dict[str, Any]:
    return {
        "name": zone.name,
        "footprint": zone.area.exterior.coords[:-1],
        "max_speed": zone.max_speed,
        "forbidden": zone.forbidden,
    }


def _gate(gate: Gate) -> dict[str, Any]:
    return {"name": gate.name, "ends": gate.ends, "direction": gate.normal}


def _passing(run: Outcome) -> dict[str, Any]:
    """Return the obstacles that appear and disappear, doors included, as events describe."""
    doors = [door.closed for door in run.floorplan.doors]
    there = [_obstacle(one) for one in (*doors, *run.scene.passing)]
    return {"passing": there} if there else {}


def _lane(lane: Lane) -> dict[str, Any]:
    low, high = lane.limits
    return {
        "name": lane.name,
        "from": lane.position(low),
        "to": lane.position(high),
        "locations": {name: lane.position(q) for name, q in lane.locations.items()},
    }


def _bodies(run: Outcome) -> list[dict[str, Any]]:
    people: list[dict[str, Any]] = [
        {
            "name": person.name,
            "category": "person",
            "radius": person.radius,
            "personality": Path(person.personality).stem,
            "height": person.height,
        }
        for person in run.scene.people
    ]
    fields = run.scene.fields
    return people + [
        _machine(machine, run.floorplan) | _fields(fields.get(machine.name), machine)
        for machine in run.scene.machines
    ]


def _machine(machine: MachineShape, plan: Floorplan) -> dict[str, Any]:
    rails = rails_under(machine.name, plan)
    on_lane = any(lane.name == machine.name for lane in plan.lanes)
    return {
        **{name: getattr(machine, name) for name in ("name", "category", "length", "width")},
        **({"reach": machine.reach, "mount": machine.mount} if machine.reach > 0 else {}),
        **({"outline": machine.outline} if machine.outline else {}),
        **({"course": machine.course} if machine.course and not on_lane else {}),
        **({"bridge": (rails.y.low, rails.y.high)} if rails is not None else {}),
        "bottom": machine.bottom,
        "top": machine.top,
        **(_heights(rails) if rails is not None else {}),
    }


def _fields(fields: MachineFields | None, machine: MachineShape) -> dict[str, Any]:
    """Return the field sets of a machine, with None for open ends of ranges.

    Sets for another load than that of a vehicle are omitted, because the load does not change.
    """
    if fields is None:
        return {}
    keeps_load = machine.kind in ("agv", "amr")
    return {
        "fields": [
            {
                "name": one.name,
                "linear": [x if math.isfinite(x) else None for x in one.linear],
                "theta": [x if math.isfinite(x) else None for x in one.theta],
                "direction": one.direction,
                "protective": one.protective,
                "warning": one.warning,
            }
            for one in fields.sets
            if not keeps_load or one.fits_load(machine.loaded)
        ]
    }


def _heights(gantry: Gantry) -> dict[str, float]:
    return {
        "rail_height": gantry.rail_height,
        "shoulder": gantry.arm_mount[1],
        "arm_bottom": gantry.arm_bottom,
    }


def _minds(run: Outcome) -> dict[str, list[dict[str, Any]]]:
    minds: dict[str, list[dict[str, Any]]] = {}
    for thought in run.thoughts:
        change = {key: value for key, value in thought.items() if key != "person"}
        minds.setdefault(thought["person"], []).append(change)
    return minds


def _watches(run: Outcome) -> list[dict[str, Any]]:
    rules = run.scene.rules
    watches = []
    for (person, machine), intervals in run.violations.items():
        shape = run.scene.machine(machine)
        law = rules.law_of(shape)
        curve = run.requirements.get((person, machine))
        watch: dict[str, Any] = {"person": person, "other": machine, "violations": intervals}
        watch["law"] = _law(law) if curve is None else {"curve": curve}
        if shape.category == "robot":
            watch |= _notice(rules, law)
        if (at := rules.measured_at(shape)) != (0.0, 0.0):
            watch["measured_at"] = at
        if (shapes := run.scene.shapes(person, machine)) is not None:
            radius, corners = shapes.person.radius, shape.silhouette[0].corners
            watch["surfaces"] = {"radius": radius, "corners": corners, "reach": shape.reach}
        watches.append(watch)
    return watches


def _law(law: AnyLaw) -> dict[str, float]:
    """Return the terms of a plain law (see `is_of_speeds_alone`)."""
    if isinstance(law, SeparationLaw):
        terms = {"t1": law.t1, "t2": law.t2}
        return {**terms, "stopping": law.stopping, "intrusion": law.intrusion}
    return {"distance": required_at_speeds(law, 0.0, 0.0)}


def _notice(rules: RuleSet, law: AnyLaw) -> dict[str, Any]:
    scaled = rules.notice.law
    notice = {"notice": scaled.factor, "notice_cap": scaled.cap if scaled.cap < math.inf else None}
    if scaled.law == law:
        return notice
    # The page cannot draw the distance of other custom laws.
    return {**notice, "notice_law": _law(scaled.law)} if is_of_speeds_alone(scaled.law) else {}


def piece_data(piece: Piece) -> list[Any]:
    """Return the begin and end of a piece, and its cubics without zeros at their ends."""
    return [
        piece.begin,
        piece.end,
        *(without_zeros(c) for c in (piece.x, piece.y, piece.rotation)),
    ]
