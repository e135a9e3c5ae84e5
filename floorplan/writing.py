"""Floors as text: the files from which they can be read again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import Any

import shapely
from shapely.geometry import Point, Polygon, box, mapping

from .model import EVERYBODY, Axis, Door, Floor, Gantry, Gate, Human, Lane, Obstacle, Zone
from .problems import UserError
from .yaml_writing import yaml_text

Data = dict[str, Any]
"""Keys and values as they stand in a file. What is left out has its usual value."""


def floor_keys(plan: Floor) -> Data:
    """Return the keys of a file in Floorwalker's own format from which `plan` is read again."""
    zone = plan.safe_zone
    data: Data = {
        "name": plan.name,
        "title": plan.title,
        "source": plan.source,
        "boundary": _ring(plan.boundary.exterior),
        "holes": [_ring(ring) for ring in plan.boundary.interiors],
        "human": _changed(plan.human, Human()),
        "safe_zone": None if zone is None else {"at": _pair(zone.position)},
        "stations": {one.name: _pair(one.position) for one in plan.stations},
        "patrol": None if plan.patrol is None else [*plan.patrol],
        "obstacles": {one.name: obstacle_keys(one) for one in plan.obstacles},
        "agvs": _agvs([*plan.lanes]) if plan.lanes else None,
        "gantry": None if plan.gantry is None else _gantry(plan.gantry),
        "doors": {door.name: _door(door) for door in plan.doors},
        "zones": {zone.name: _zone(zone) for zone in plan.zones},
        "gates": {gate.name: _gate(gate) for gate in plan.gates},
    }
    if zone is not None and zone.heading:
        data["safe_zone"]["heading"] = float(zone.heading)
    # An empty patrol is not the usual one, which is all stations.
    return {
        key: value
        for key, value in data.items()
        if key == "name" or value not in (None, "", [], {}) or (key == "patrol" and value == [])
    }


def obstacle_keys(one: Obstacle) -> Data:
    """Return the keys from which the obstacle `one` is read again."""
    return {**_footprint(one.footprint), "z": _pair((one.bottom, one.top))}


def to_yaml(plan: Floor) -> str:
    """Return `plan` in Floorwalker's own format."""
    return yaml_text(floor_keys(plan))


def walkable(plan: Floor) -> shapely.Geometry:
    """Return the area that people can walk on: `ValueError` if there is none."""
    area = shapely.force_2d(plan.free(0.0, plan.human.height))
    if area.is_empty:
        raise UserError(f"people can walk nowhere on the floor {plan.name!r}")
    return area


def to_wkt(plan: Floor) -> str:
    """Return the area of `plan` that people can walk on, as well-known text.

    `ValueError` if it is not one area.
    """
    area = walkable(plan)
    if area.geom_type != "Polygon":
        count = len(area.geoms)
        raise UserError(
            f"people on the floor {plan.name!r} walk on {count} separate areas; a WKT file has one"
        )
    return f"{shapely.to_wkt(area, rounding_precision=-1)}\n"


def to_geojson(plan: Floor) -> str:
    """Return the boundary, the obstacles, the stations and the safe zone of `plan` as GeoJSON."""
    features = [
        json.dumps({"type": "Feature", "properties": properties, "geometry": mapping(shape)})
        for properties, shape in _features(plan)
    ]
    lines = ",\n".join(features)
    return f'{{"type": "FeatureCollection", "features": [\n{lines}\n]}}\n'


TEXTS: dict[str, Callable[[Floor], str]] = {
    ".yaml": to_yaml,
    ".yml": to_yaml,
    ".geojson": to_geojson,
    ".json": to_geojson,
    ".wkt": to_wkt,
}
"""Formats of text, by suffix."""


def lost(plan: Floor, suffix: str) -> list[str]:
    """Return what of `plan` files that end in `suffix` can't hold, in words.

    A ROS map counts as ".pgm".
    """
    if suffix in (".yaml", ".yml"):
        return []
    parts = {
        "AGVs": len(plan.lanes),
        "the gantry": plan.gantry is not None,
        "the patrol": plan.patrol is not None,
        "measures of people": plan.human != Human(),
        "doors": len(plan.doors),
        "zones": len(plan.zones),
        "one-way gates": len(plan.gates),
    }
    if suffix not in (".geojson", ".json"):
        parts |= {
            "names and heights of obstacles": len(plan.obstacles),
            "stations": len(plan.stations),
            "the safe zone": plan.safe_zone is not None,
        }
    return [part for part, there in parts.items() if there]


def _features(plan: Floor) -> Iterator[tuple[Data, shapely.Geometry]]:
    yield {"kind": "boundary", "name": plan.name}, plan.boundary
    for obstacle in plan.obstacles:
        heights = {"bottom": float(obstacle.bottom), "top": float(obstacle.top)}
        yield {"kind": "obstacle", "name": obstacle.name, **heights}, obstacle.footprint
    for station in plan.stations:
        yield {"kind": "station", "name": station.name}, Point(station.position)
    if plan.safe_zone is not None:
        heading = {"heading": float(plan.safe_zone.heading)}
        yield {"kind": "safe_zone", **heading}, Point(plan.safe_zone.position)


def _footprint(footprint: Polygon) -> Data:
    west, south, east, north = footprint.bounds
    if footprint == box(west, south, east, north):
        return {"x": [west, east], "y": [south, north]}
    holes = [_ring(ring) for ring in footprint.interiors]
    return {"polygon": _ring(footprint.exterior), **({"holes": holes} if holes else {})}


def _door(door: Door) -> Data:
    return {
        "between": [_pair(end) for end in door.ends],
        "open": door.is_open,
        "thickness": float(door.thickness),
        "height": float(door.height),
    }


def _zone(zone: Zone) -> Data:
    rule: Data = {"forbidden": True} if zone.forbidden else {}
    if zone.max_speed is not None:
        rule["max_speed"] = float(zone.max_speed)
    if zone.one_way is not None:
        rule["one_way"] = _pair(zone.one_way)
    return {**_footprint(zone.area), **rule, **_concerns(zone)}


def _gate(gate: Gate) -> Data:
    ends = [_pair(end) for end in gate.ends]
    return {"between": ends, "towards": _pair(gate.towards), **_concerns(gate)}


def _concerns(rule: Zone | Gate) -> Data:
    return {} if rule.concerns == EVERYBODY else {"concerns": [*rule.concerns]}


def _ring(ring: Any) -> list[list[float]]:
    return [_pair(at[:2]) for at in ring.coords[:-1]]


def _pair(pair: Any) -> list[float]:
    return [float(value) for value in pair]


def _changed(value: Human, usual: Human) -> Data:
    given = {field.name: getattr(value, field.name) for field in fields(value)}
    return {name: float(held) for name, held in given.items() if held != getattr(usual, name)}


def _agvs(lanes: list[Lane]) -> Data:
    """Return the keys that the AGVs share with the first of them, and those of each alone."""
    shared = _lane(lanes[0])
    own = {}
    for lane in lanes:
        keys = {key: value for key, value in _lane(lane).items() if value != shared[key]}
        placed = {"origin": _pair(lane.origin), "heading": float(lane.heading)}
        served = {"serves": dict(lane.serves)} if lane.serves else {}
        own[lane.name] = placed | keys | served
    return {**shared, "lanes": own}


def _lane(lane: Lane) -> Data:
    return {
        "size": _pair((lane.length, lane.width)),
        "height": float(lane.height),
        "max_speed": float(lane.max_speed),
        "max_acceleration": float(lane.max_acceleration),
        "limits": _pair(lane.limits),
        "locations": {name: float(q) for name, q in lane.locations.items()},
        "start": lane.start,
    }


def _gantry(gantry: Gantry) -> Data:
    length, width, bottom, top = gantry.torso
    return {
        "x": _axis(gantry.x),
        "y": _axis(gantry.y),
        "rotation": _axis(gantry.rotation),
        "start": [float(value) for value in gantry.start],
        "torso": {"size": _pair((length, width)), "z": _pair((bottom, top))},
        "arm": {
            "mount": _pair(gantry.arm_mount),
            "reach": float(gantry.arm_reach),
            "bottom": float(gantry.arm_bottom),
        },
        "rail_height": float(gantry.rail_height),
        "tray_height": float(gantry.tray_height),
    }


def _axis(axis: Axis) -> Data:
    return {
        "range": _pair((axis.low, axis.high)),
        "max_speed": float(axis.max_speed),
        "max_acceleration": float(axis.max_acceleration),
        "max_jerk": float(axis.max_jerk),
    }
