"""Floors in other units, and moved and turned as a whole."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from .model import Axis, Gantry, Lane, Point
from .plan import Floorplan
from .problems import UserError

_Floats = NDArray[np.float64]


def scaled(plan: Floorplan, metre: float) -> Floorplan:
    """Return `plan`, whose lengths are in a unit of `metre` metres, in metres.

    Measures of people, speeds and accelerations are metres and seconds as they are.
    """
    if metre == 1.0:
        return plan
    moved = _mapped(plan, lambda points: points * metre)
    gantry = plan.gantry
    return replace(
        moved,
        obstacles=[replace(o, bottom=o.bottom * metre, top=o.top * metre) for o in moved.obstacles],
        lanes=[_scaled_lane(lane, metre) for lane in moved.lanes],
        gantry=None if gantry is None else _scaled_gantry(gantry, metre),
        doors=[
            replace(door, thickness=door.thickness * metre, height=door.height * metre)
            for door in moved.doors
        ],
    )


def put(plan: Floorplan, origin: Point, rotation: float) -> Floorplan:
    """Return `plan` with its point `origin` (metres) at (0, 0), turned about it by `rotation`.

    The gantry's axes are those of the floor: `ValueError` if it would have to be turned.
    """
    if origin == (0.0, 0.0) and rotation == 0.0:
        return plan
    if plan.gantry is not None and rotation != 0.0:
        raise UserError(
            "a gantry can't be turned, its axes are those of the floor: put it into a floor of its"
            " own whose base is this file without the gantry"
        )
    c, s = _turn(rotation)

    def moved(points: _Floats) -> _Floats:
        x, y = points[:, 0] - origin[0], points[:, 1] - origin[1]
        return np.column_stack([c * x - s * y, s * x + c * y])

    placed = _mapped(plan, moved)
    zone, gantry = placed.safe_zone, plan.gantry
    return replace(
        placed,
        safe_zone=None if zone is None else replace(zone, heading=zone.heading + rotation),
        lanes=[replace(lane, heading=lane.heading + rotation) for lane in placed.lanes],
        gantry=None if gantry is None else _moved_gantry(gantry, origin),
    )


def _turn(angle: float) -> Point:
    """Return cosine and sine of `angle` (radians); exact at quarters of a turn."""
    # The cosine of π / 2 as a float is 6e-17: what is square stays square.
    return round(math.cos(angle), 15), round(math.sin(angle), 15)


def _mapped(plan: Floorplan, move: Callable[[_Floats], _Floats]) -> Floorplan:
    """Return `plan` with all places of it (N, 2) moved; lanes begin where they are moved to."""

    def place(at: Point) -> Point:
        x, y = move(np.array([at], float))[0].tolist()
        return x, y

    zone = plan.safe_zone
    return replace(
        plan,
        boundary=shapely.transform(plan.boundary, move),
        obstacles=[
            replace(o, footprint=shapely.transform(o.footprint, move)) for o in plan.obstacles
        ],
        stations=[replace(one, position=place(one.position)) for one in plan.stations],
        safe_zone=None if zone is None else replace(zone, position=place(zone.position)),
        lanes=[replace(lane, origin=place(lane.origin)) for lane in plan.lanes],
        doors=[
            replace(door, ends=(place(door.ends[0]), place(door.ends[1]))) for door in plan.doors
        ],
        zones=[replace(zone, area=shapely.transform(zone.area, move)) for zone in plan.zones],
        gates=[
            replace(
                gate, ends=(place(gate.ends[0]), place(gate.ends[1])), towards=place(gate.towards)
            )
            for gate in plan.gates
        ],
    )


def _scaled_lane(lane: Lane, metre: float) -> Lane:
    return replace(
        lane,
        limits=(lane.limits[0] * metre, lane.limits[1] * metre),
        locations={name: q * metre for name, q in lane.locations.items()},
        length=lane.length * metre,
        width=lane.width * metre,
        height=lane.height * metre,
    )


def _scaled_gantry(gantry: Gantry, metre: float) -> Gantry:
    def axis(one: Axis) -> Axis:
        return replace(one, low=one.low * metre, high=one.high * metre)

    x, y, rotation = gantry.start
    length, width, bottom, top = (value * metre for value in gantry.torso)
    return replace(
        gantry,
        x=axis(gantry.x),
        y=axis(gantry.y),
        start=(x * metre, y * metre, rotation),
        torso=(length, width, bottom, top),
        arm_mount=(gantry.arm_mount[0] * metre, gantry.arm_mount[1] * metre),
        arm_reach=gantry.arm_reach * metre,
        arm_bottom=gantry.arm_bottom * metre,
        rail_height=gantry.rail_height * metre,
        tray_height=gantry.tray_height * metre,
    )


def _moved_gantry(gantry: Gantry, origin: Point) -> Gantry:
    def axis(one: Axis, by: float) -> Axis:
        return replace(one, low=one.low - by, high=one.high - by)

    x, y, rotation = gantry.start
    return replace(
        gantry,
        x=axis(gantry.x, origin[0]),
        y=axis(gantry.y, origin[1]),
        start=(x - origin[0], y - origin[1], rotation),
    )
