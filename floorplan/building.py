"""Values of the parts of a floor from their keys in a file."""

from __future__ import annotations

import math
from typing import Any

from shapely.geometry import Polygon, box

from .model import Axis, Door, Gantry, Gate, Human, Lane, Obstacle, SafeZone, Station, Zone
from .schema import (
    AgvsSchema,
    AxisSchema,
    FloorplanSchema,
    FootprintSchema,
    GantrySchema,
    LaneSchema,
)

_CORNERS = 32
"""Corners of the polygon that stands for a disc."""


def parts(schema: FloorplanSchema) -> dict[str, Any]:
    """Return what stands on the floor of a file, by the names of a floor's fields."""
    zone = schema.safe_zone
    return {
        "obstacles": [
            Obstacle(name, footprint(one), *one.z) for name, one in schema.obstacles.items()
        ],
        "stations": [Station(name, at) for name, at in schema.stations.items()],
        "patrol": None if schema.patrol is None else tuple(schema.patrol),
        "safe_zone": SafeZone(zone.at, zone.heading) if zone else None,
        "human": Human(**schema.human.model_dump()),
        "lanes": _lanes(schema.agvs) if schema.agvs else (),
        "gantry": _gantry(schema.gantry) if schema.gantry else None,
        "doors": [
            Door(name, one.between, one.open, one.thickness, one.height)
            for name, one in schema.doors.items()
        ],
        "zones": [
            Zone(
                name,
                footprint(one),
                one.max_speed,
                one.forbidden,
                tuple(one.concerns),
                one.one_way,
            )
            for name, one in schema.zones.items()
        ],
        "gates": [
            Gate(name, one.between, one.towards, tuple(one.concerns))
            for name, one in schema.gates.items()
        ],
    }


def _lanes(agvs: AgvsSchema) -> tuple[Lane, ...]:
    return tuple(_lane(name, lane, agvs) for name, lane in agvs.lanes.items())


def _lane(name: str, lane: LaneSchema, agvs: AgvsSchema) -> Lane:
    length, width = lane.size or agvs.size
    return Lane(
        name=name,
        origin=lane.origin,
        heading=lane.heading,
        limits=lane.limits or agvs.limits,
        locations=dict(agvs.locations if lane.locations is None else lane.locations),
        start=lane.start or agvs.start,
        length=length,
        width=width,
        height=lane.height or agvs.height,
        max_speed=lane.max_speed or agvs.max_speed,
        max_acceleration=lane.max_acceleration or agvs.max_acceleration,
        serves=dict(lane.serves),
    )


def _gantry(entry: GantrySchema) -> Gantry:
    return Gantry(
        x=_axis(entry.x),
        y=_axis(entry.y),
        rotation=_axis(entry.rotation),
        start=entry.start,
        torso=(*entry.torso.size, *entry.torso.z),
        arm_mount=entry.arm.mount,
        arm_reach=entry.arm.reach,
        arm_bottom=entry.arm.bottom,
        rail_height=entry.rail_height,
        tray_height=entry.tray_height,
    )


def footprint(entry: FootprintSchema) -> Polygon:
    """Return the polygon that the keys of `entry` stand for."""
    if entry.polygon is not None:
        return Polygon(entry.polygon, entry.holes)
    if entry.x is not None and entry.y is not None:
        return box(entry.x[0], entry.y[0], entry.x[1], entry.y[1])
    assert entry.center is not None  # the schema has seen to it
    cx, cy = entry.center
    if entry.size is not None:
        half_x, half_y = entry.size[0] / 2, entry.size[1] / 2
        return box(cx - half_x, cy - half_y, cx + half_x, cy + half_y)
    assert entry.radius is not None
    return _round(cx, cy, entry.radius)


def _round(x: float, y: float, radius: float) -> Polygon:
    """Return the regular polygon around a disc: it covers all of the disc."""
    outer = radius / math.cos(math.pi / _CORNERS)
    angles = [2 * math.pi * (k + 0.5) / _CORNERS for k in range(_CORNERS)]
    return Polygon([(x + outer * math.cos(a), y + outer * math.sin(a)) for a in angles])


def _axis(entry: AxisSchema) -> Axis:
    return Axis(*entry.range, entry.max_speed, entry.max_acceleration, entry.max_jerk)
