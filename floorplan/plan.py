"""Floorplans, saved as YAML, GeoJSON, WKT or a ROS map."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Point, Polygon, box, mapping

from .checks import check
from .files.documents import MOST_TEXT, yaml_text
from .files.problems import UserError
from .formats.raster import MOST_CELLS
from .model import EVERYBODY, Axis, Door, Floor, Gantry, Gate, Human, Lane, Obstacle, Zone

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


USUAL = 0.05
"""Metres. Length of a cell where nothing else is asked for."""

FINEST = 1e-4
"""Metres. Least length of a cell."""

FREE, OCCUPIED = 254, 0
"""Grey of cells, as map_server writes them."""

_MARGIN = 1
"""Cells around the floor, so that its edge is drawn."""


def write_map(plan: Floor, path: Path, resolution: float) -> None:
    """Write `plan` as a map in cells of `resolution` metres: `path` and the other of its two files.

    `ValueError` if it would have more cells than can be read.
    """
    area = walkable(plan)
    west, south, east, north = area.bounds
    columns = math.ceil((east - west) / resolution) + 2 * _MARGIN
    rows = math.ceil((north - south) / resolution) + 2 * _MARGIN
    if columns * rows > MOST_CELLS:
        raise UserError(
            f"{path}: a map of {columns:,} × {rows:,} cells is too large (at most {MOST_CELLS:,}"
            " cells); give a coarser resolution"
        )
    corner = (west - _MARGIN * resolution, south - _MARGIN * resolution)
    free = free_cells(area, corner, resolution, rows, columns)
    text, image = map_files(path)
    settings = {
        "image": image.name,
        "resolution": float(resolution),
        "origin": [float(corner[0]), float(corner[1]), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    grey = np.where(free[::-1], FREE, OCCUPIED).astype(np.uint8)
    image.write_bytes(b"P5\n%d %d\n255\n" % (columns, rows) + grey.tobytes())
    text.write_text(yaml_text(settings), encoding="utf-8", newline="\n")


def map_files(path: Path) -> tuple[Path, Path]:
    """Return the two files of a ROS map, of which one is `path`: its settings and its image."""
    is_text = path.suffix.lower() in (".yaml", ".yml")
    return path if is_text else path.with_suffix(".yaml"), path.with_suffix(".pgm")


def free_cells(
    area: shapely.Geometry, corner: tuple[float, float], size: float, rows: int, columns: int
) -> NDArray[np.bool_]:
    """Return the cells that are wholly in `area`: (rows, columns), the lowest row first.

    Cells are `size` metres long, the first one has its lower left corner at `corner`. Squares of
    cells that the edge of `area` does not cross are decided as a whole.
    """
    free = np.zeros((rows, columns), bool)
    shapely.prepare(area)
    whole = 1 << (max(rows, columns) - 1).bit_length()
    squares = np.array([[0, 0]])
    while len(squares):
        low = squares * size + (corner[1], corner[0])
        high = np.minimum(squares + whole, (rows, columns)) * size + (corner[1], corner[0])
        boxes = shapely.box(low[:, 1], low[:, 0], high[:, 1], high[:, 0])
        inside = shapely.covers(area, boxes)
        for row, column in squares[inside]:
            free[row : row + whole, column : column + whole] = True
        if whole == 1:
            break
        # Only what is partly in the area is looked at more closely.
        crossed = squares[~inside & shapely.intersects(area, boxes)]
        whole //= 2
        quarters = np.array([[0, 0], [0, whole], [whole, 0], [whole, whole]])
        squares = (crossed[:, None, :] + quarters).reshape(-1, 2)
        squares = squares[(squares < (rows, columns)).all(axis=1)]
    return free


@dataclass(frozen=True, repr=False, kw_only=True)
class Floorplan(Floor):
    """A floor: its boundary and what stands on it. Compare with `==`, share freely.

    Fields are those of `Floor`: obstacles, stations and lanes are tuples that also answer to
    names: `stations["dock"]`. `patrol` names the stations that people go to, in their order; None
    stands for all of them. `notices` are what was left out of the drawing it was read from, or
    taken for granted there.
    """

    def save(self, path: str | Path, *, resolution: float | None = None) -> None:
        """Write the floor to the file at `path`, in the format that its suffix says.

        Only Floorwalker's own (.yaml, .yml) holds all of it. GeoJSON (.geojson, .json) has no
        machines, no patrol and no measures of people; WKT (.wkt) is only the area that people can
        walk on. A ROS map (.pgm, with its .yaml beside it; or .yaml with a `resolution`) is this
        area in cells of `resolution` metres, 0.05 by default: a cell is free if all of it is.

        `FloorplanError` if the floor is not sound, `ValueError` for another suffix, for a YAML
        file too long to be read, or where people could walk nowhere, or in too many cells;
        `OSError` says why it can't be written.
        """
        check(self)
        path = Path(path)
        suffix = path.suffix.lower()
        is_map = suffix == ".pgm" or (suffix in (".yaml", ".yml") and resolution is not None)
        if resolution is not None and not (is_map and resolution >= FINEST):
            reason = f"a ROS map (.pgm, .yaml), of at least {FINEST:g} m"
            raise UserError(f"{path}: a resolution belongs to {reason}")
        if is_map:
            write_map(self, path, USUAL if resolution is None else resolution)
            return
        if suffix not in TEXTS:
            known = ", ".join((*TEXTS, ".pgm"))
            raise UserError(f"{path}: a floor can be written to files that end in one of {known}")
        text = TEXTS[suffix](self)
        if suffix in (".yaml", ".yml") and len(text) > MOST_TEXT:
            reason = f"{len(text):,} characters, and one of more than {MOST_TEXT:,} can't be read"
            raise UserError(f"{path}: the floor would take {reason}; .geojson holds its shapes")
        path.write_text(text, encoding="utf-8", newline="\n")

    def to_yaml(self) -> str:
        """Return the text of a file in Floorwalker's own format that holds this floor."""
        check(self)
        return TEXTS[".yaml"](self)
