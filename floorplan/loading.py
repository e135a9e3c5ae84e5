"""Loading of floorplans by the name of a file or of a built-in one."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path

from shapely.geometry import Polygon, box

from .checks import check, faults
from .document import Document, parse_yaml, read_yaml
from .dxf import load_dxf
from .model import Axis, Floorplan, Gantry, Human, Lane, Obstacle, SafeZone, Station
from .problems import FloorplanError, suggestion
from .reading import is_there
from .ros_map import build_ros_map, is_ros_map
from .schema import AgvsSchema, AxisSchema, FloorplanSchema, GantrySchema, ObstacleSchema
from .wkt import load_wkt

YAML_SUFFIXES = (".yaml", ".yml")
OTHER_SUFFIXES = {".wkt": load_wkt, ".dxf": load_dxf}


def builtin() -> tuple[str, ...]:
    """Return the names of the floorplans that come with Floorwalker, sorted."""
    files = resources.files(__package__).joinpath("data").iterdir()
    return tuple(sorted(Path(f.name).stem for f in files if f.name.endswith(".yaml")))


def load(source: str | Path) -> Floorplan:
    """Return the floorplan called `source` (a built-in name) or in the file at `source`.

    `FloorplanError` lists everything that is wrong with the file, each with its place.
    """
    text = str(source)
    if text in builtin():
        data = resources.files(__package__).joinpath("data", f"{text}.yaml")
        return parse(data.read_text(encoding="utf-8"), file=text)
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix in YAML_SUFFIXES:
        document = read_yaml(path, FloorplanError)
        return build_ros_map(document) if is_ros_map(document) else build(document)
    if suffix in OTHER_SUFFIXES:
        plan = OTHER_SUFFIXES[suffix](path)
        check(plan, file=text)
        return plan
    if is_there(path):
        known = ", ".join((*YAML_SUFFIXES, *OTHER_SUFFIXES))
        raise FloorplanError.of(text, f"the name of a floorplan's file ends in one of {known}")
    hint = suggestion(text, builtin())
    raise FloorplanError.of(text, f"no such file, nor a built-in floorplan; {hint}")


def parse(text: str, *, file: str = "<text>") -> Floorplan:
    """Return the floorplan in `text`, in the YAML format; errors call it `file`."""
    return build(parse_yaml(text, file, FloorplanError))


def build(document: Document) -> Floorplan:
    """Return the floorplan in `document`; `FloorplanError` with all that is wrong with it."""
    schema = document.checked(FloorplanSchema, FloorplanError)
    zone = schema.safe_zone
    plan = Floorplan(
        name=schema.name or Path(document.file).stem,
        title=schema.title,
        source=schema.source,
        boundary=Polygon(schema.boundary),
        obstacles=tuple(
            Obstacle(name, _footprint(entry), *entry.z) for name, entry in schema.obstacles.items()
        ),
        stations=tuple(Station(name, at) for name, at in schema.stations.items()),
        patrol=None if schema.patrol is None else tuple(schema.patrol),
        safe_zone=SafeZone(zone.at, zone.heading) if zone else None,
        human=Human(**schema.human.model_dump()),
        lanes=_lanes(schema.agvs) if schema.agvs else (),
        gantry=_gantry(schema.gantry) if schema.gantry else None,
    )
    problems = [document.problem(message, *place) for message, place in faults(plan)]
    if problems:
        raise FloorplanError(document.file, problems)
    return plan


def _footprint(entry: ObstacleSchema) -> Polygon:
    if entry.polygon is not None:
        return Polygon(entry.polygon)
    if entry.x is not None and entry.y is not None:
        return box(entry.x[0], entry.y[0], entry.x[1], entry.y[1])
    assert entry.center is not None  # the schema has seen to it
    cx, cy = entry.center
    if entry.size is not None:
        half_x, half_y = entry.size[0] / 2, entry.size[1] / 2
        return box(cx - half_x, cy - half_y, cx + half_x, cy + half_y)
    assert entry.radius is not None
    return _round(cx, cy, entry.radius)


def _round(x: float, y: float, radius: float, corners: int = 32) -> Polygon:
    """Return the regular polygon around a disc: it covers all of the disc."""
    outer = radius / math.cos(math.pi / corners)
    angles = [2 * math.pi * (k + 0.5) / corners for k in range(corners)]
    return Polygon([(x + outer * math.cos(a), y + outer * math.sin(a)) for a in angles])


def _lanes(agvs: AgvsSchema) -> tuple[Lane, ...]:
    return tuple(
        Lane(
            name=name,
            origin=lane.origin,
            heading=lane.heading,
            limits=agvs.limits,
            locations=dict(agvs.locations),
            start=lane.start or agvs.start,
            length=agvs.size[0],
            width=agvs.size[1],
            height=agvs.height,
            max_speed=agvs.max_speed,
            max_acceleration=agvs.max_acceleration,
            serves=dict(lane.serves),
        )
        for name, lane in agvs.lanes.items()
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


def _axis(entry: AxisSchema) -> Axis:
    return Axis(*entry.range, entry.max_speed, entry.max_acceleration, entry.max_jerk)
