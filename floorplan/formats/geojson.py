"""Floors in GeoJSON (RFC 7946): features by kind or layer, in metres.

A single geometry is the walkable area, with obstacles as holes. In a collection the property `kind`
of a feature is boundary, obstacle, station or safe_zone. Without it, `layer` is its group, as in
drawings. `name`, `bottom`, `top` and `heading` are optional.
"""

import itertools
import json
from collections.abc import Iterator
from dataclasses import field, replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pydantic import BaseModel, ConfigDict, ValidationError
from shapely.geometry import Point, Polygon, mapping, shape as shape_of

from ..building import METRE
from ..checks import polygon_fault
from ..files.dataclass import dataclass
from ..files.fields import Angle, Number, Positive, are_figures
from ..files.problems import FloorplanError, Problem, field_name, misfits, shown
from ..files.reading import read_text
from ..model import DEFAULT_HEIGHT, Floor, Obstacle, SafeZone, Station
from ..plan import Floorplan
from .drawings import (
    BOUNDARY,
    MOST_DETAILS,
    OUTSIZED,
    Drawn,
    Floats,
    Unread,
    notices_of,
    pieces_of,
)
from .wkt import joined

DEGREES = ("CRS84", "CRS83", "CRS27", "4326", "4258", "4267", "4269", "4283", "4490", "4979")
"""Parts of the names of coordinate systems in degrees."""

KINDS = ("boundary", "obstacle", "station", "safe_zone")


class Properties(BaseModel):
    """Properties of a feature. It may have others."""

    model_config = ConfigDict(extra="ignore", frozen=True, defer_build=True)

    kind: str | None = None
    layer: str | None = None
    name: str | None = None
    bottom: Number | None = None
    top: Number | None = None
    heading: Angle = 0.0
    line_width: Positive | None = None


@dataclass
class _Parts:
    """Parts of the floor that were read."""

    boundary: list[Polygon] = field(default_factory=list)
    bounding: int = 0
    """Features of the boundary."""
    obstacles: list[tuple[str, str | None, Polygon, float, float]] = field(default_factory=list)
    stations: list[Station] = field(default_factory=list)
    safe_zones: list[SafeZone] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    unread: list[Unread] = field(default_factory=list)
    corners: list[Floats] = field(default_factory=list)


def load_geojson(path: Path, drawn: Drawn) -> Floorplan:
    """Return the floorplan in the GeoJSON file at `path`. `FloorplanError` lists all problems."""
    file, text = str(path), read_text(path, FloorplanError)
    try:
        data = json.loads(text)
    except json.JSONDecodeError as why:
        raise FloorplanError.of(file, f"is not JSON: {why.msg}", line=why.lineno) from None
    except (RecursionError, ValueError) as why:
        raise FloorplanError.of(file, f"is not JSON: {why}") from None
    if not isinstance(data, dict):
        raise FloorplanError.of(file, f"is not GeoJSON: expected an object, found {shown(data)}")
    if not isinstance(data.get("type"), str):
        raise FloorplanError.of(file, "is not GeoJSON: it has no type, as 'FeatureCollection'")
    if any(mark in json.dumps(data.get("crs")) for mark in DEGREES):
        message = "its coordinates are degrees (crs); project it to metres"
        raise FloorplanError.of(file, message)
    units = data.get("units")
    if units is not None and (not isinstance(units, str) or units not in METRE):
        raise FloorplanError.of(file, f"units: expected {', '.join(METRE)}, found {shown(units)}")
    in_metres = drawn.metre is not None or units is not None or data.get("crs") is not None
    drawn = replace(drawn, metre=drawn.metre or METRE[units or "m"])
    if data.get("type") == "FeatureCollection":
        features = data.get("features")
        if not isinstance(features, list):
            raise FloorplanError.of(file, "features: expected a list of features")
        return _collection(features, file, drawn, in_metres)
    geometry = data.get("geometry") if data.get("type") == "Feature" else data
    area = _geometry(geometry, drawn)
    if isinstance(area, str):
        raise FloorplanError.of(file, area)
    if not in_metres and _may_be_degrees(shapely.get_coordinates(area)):
        raise FloorplanError.of(file, _NO_CRS)
    source = f"{Path(file).name} (GeoJSON)"
    return Floorplan.of_area(Path(file).stem, source, joined(area, file))


_NO_CRS = (
    "has no crs, so its coordinates are degrees of longitude and latitude (RFC 7946); project"
    ' them to metres, or add "units": "m" beside "type" (or `units: m` in a floor on top of it)'
)


def _may_be_degrees(corners: Floats) -> bool:
    return len(corners) > 0 and bool((np.abs(corners) <= (180, 90)).all())


def _collection(features: list[Any], file: str, drawn: Drawn, in_metres: bool) -> Floorplan:
    parts = _Parts()
    layers: set[str] = set()
    for k, feature in enumerate(features):
        place = f"features[{k}]"
        if not isinstance(feature, dict) or feature.get("type") != "Feature":
            parts.problems.append(Problem("expected a feature", place))
            continue
        values = feature.get("properties") or {}
        try:
            properties = Properties.model_validate(values)
        except ValidationError as wrong:
            for message, at in misfits(wrong, Properties, values):
                inner = f"{place}.properties.{field_name(at)}"
                parts.problems.append(Problem(message, inner))
            continue
        if properties.layer is not None:
            layers.add(properties.layer)
        fault = _feature(feature.get("geometry"), properties, place, parts, drawn)
        if fault:
            parts.problems.append(Problem(fault, place))
    parts.problems += drawn.unmatched(layers)
    count = len(parts.boundary)
    if drawn.boundary is None and count != 1 and not (parts.problems and parts.bounding):
        names = f" (the layers are {', '.join(sorted(layers))})" if layers else ""
        message = f"expected one polygon of the kind (or layer) {BOUNDARY!r}, found {count}{names}"
        parts.problems = [Problem(message), *parts.problems[: None if count else MOST_DETAILS]]
    if not in_metres and _may_be_degrees(np.concatenate([*parts.corners, np.empty((0, 2))])):
        parts.problems.insert(0, Problem(_NO_CRS))
    if len(parts.safe_zones) > 1:
        parts.problems.append(Problem(f"{len(parts.safe_zones)} safe zones; a floor has one"))
    if parts.problems:
        raise FloorplanError(file, parts.problems)
    return Floorplan(
        name=Path(file).stem,
        source=f"{Path(file).name} (GeoJSON)",
        boundary=parts.boundary[0] if drawn.boundary is None else drawn.boundary,
        obstacles=[*_named(parts)],
        stations=parts.stations,
        safe_zone=parts.safe_zones[0] if parts.safe_zones else None,
        notices=tuple(notices_of(parts.unread)),
    )


def _feature(
    geometry: Any, properties: Properties, place: str, parts: _Parts, drawn: Drawn
) -> str | None:
    """Add a feature to `parts`, or return what is wrong with it."""
    kind, layer = properties.kind, properties.layer
    group = None
    if kind is None and layer is not None:
        group = drawn.group_of(layer)
        if group is None:
            why = "is on a layer that no group has"
            parts.unread.append(Unread(layer, lambda: place, why, False))
            return None
        kind = BOUNDARY if group == BOUNDARY else "obstacle"
    if kind not in KINDS:
        kind_text = "neither kind nor layer" if kind is None else f"the kind {kind!r}"
        return f"has {kind_text}; the kinds are {', '.join(KINDS)}"
    parts.bounding += kind == BOUNDARY
    shape = _geometry(geometry, drawn)
    if isinstance(shape, str):
        return shape
    metre = drawn.metre or 1.0
    parts.corners.append(shapely.get_coordinates(shape) / metre)
    if kind in ("station", "safe_zone"):
        if shape.geom_type != "Point":
            return f"expected a Point, found a {shape.geom_type}"
        if kind == "safe_zone":
            parts.safe_zones.append(SafeZone((shape.x, shape.y), properties.heading))
        elif properties.name is None:
            return "a station needs a name"
        else:
            parts.stations.append(Station(properties.name, (shape.x, shape.y)))
        return None
    width = properties.line_width or (drawn.group(group).line_width if group else None)
    if width is not None and shape.geom_type in ("LineString", "MultiLineString"):
        shape = shape.buffer(width / 2, cap_style="square", join_style="mitre")
    if shape.geom_type not in ("Polygon", "MultiPolygon"):
        wide = ", and it has no line_width" if "Line" in shape.geom_type else ""
        return f"expected a Polygon, found a {shape.geom_type}: it encloses no area{wide}"
    polygons = [*shapely.get_parts(shape)]
    for polygon in polygons:
        if fault := polygon_fault(polygon):
            return fault
    if kind == BOUNDARY:
        parts.boundary += polygons
        return None
    bottom = 0.0 if properties.bottom is None else properties.bottom * metre
    top = bottom + DEFAULT_HEIGHT if properties.top is None else properties.top * metre
    heights = drawn.group(group).z if group is not None else None
    bottom, top = heights or (bottom, top)
    # A hollow obstacle has several pieces, which need different names.
    pieces, _ = pieces_of([shape])
    own = properties.name if len(pieces) == 1 else None
    label = group or properties.name or "obstacle"
    parts.obstacles += [(label, own, piece, bottom, top) for piece in pieces]
    return None


def _geometry(data: Any, drawn: Drawn) -> Any:
    """Return a geometry in metres and without heights, or what is wrong with it."""
    if not isinstance(data, dict):
        return f"expected a geometry, found {shown(data)}"
    try:
        with np.errstate(all="ignore"):
            shape = shapely.force_2d(shape_of(data))
            scaled = shapely.transform(shape, lambda at: at * (drawn.metre or 1.0))
    except OverflowError:  # a whole number is too large for a float
        return OUTSIZED
    except (shapely.GEOSException, AttributeError, LookupError, TypeError, ValueError) as why:
        return f"is no geometry: {why}"
    if scaled.is_empty:
        return "is empty"
    if not are_figures(shapely.get_coordinates(scaled)).all():
        return OUTSIZED
    return scaled


def _named(parts: _Parts) -> Iterator[Obstacle]:
    """Yield the obstacles with their own names, or else the name and number of their group."""
    taken = {own for _, own, *_ in parts.obstacles if own is not None}
    counters: dict[str, Iterator[int]] = {}
    for label, own, polygon, bottom, top in parts.obstacles:
        name = own
        if name is None:
            counter = counters.setdefault(label, itertools.count(1))
            name = next(one for k in counter if (one := f"{label}{k}") not in taken)
        yield Obstacle(name=name, footprint=polygon, bottom=bottom, top=top)


def write_geojson(plan: Floor, path: Path) -> None:
    """Write the boundary, the obstacles, the stations and the safe zone of `plan` as GeoJSON."""
    features = [
        json.dumps({"type": "Feature", "properties": properties, "geometry": mapping(shape)})
        for properties, shape in _features(plan)
    ]
    lines = ",\n".join(features)
    text = f'{{"type": "FeatureCollection", "units": "m", "features": [\n{lines}\n]}}\n'
    path.write_text(text, encoding="utf-8", newline="\n")


def _features(plan: Floor) -> Iterator[tuple[dict[str, Any], shapely.Geometry]]:
    yield {"kind": "boundary", "name": plan.name}, plan.boundary
    for obstacle in plan.obstacles:
        heights = {"bottom": float(obstacle.bottom), "top": float(obstacle.top)}
        yield {"kind": "obstacle", "name": obstacle.name, **heights}, obstacle.footprint
    for station in plan.stations:
        yield {"kind": "station", "name": station.name}, Point(station.position)
    if plan.safe_zone is not None:
        heading = {"heading": float(plan.safe_zone.heading)}
        yield {"kind": "safe_zone", **heading}, Point(plan.safe_zone.position)
