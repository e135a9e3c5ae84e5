"""Loading of floorplans by name or path, scaled, placed and laid over a base."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from .building import METRE, OF_DRAWINGS, FloorplanSchema, parts, unit_name
from .checks import check, faults, keep_sound, size_notices
from .files.documents import Document, parse_yaml, read_yaml
from .files.problems import Fault, FloorplanError, Place, Problem, UserError, suggestion
from .files.reading import is_there
from .formats import LAYERED, OF_SUFFIX, READ, YAML, function
from .model import Axis, Door, Gantry, Gate, Lane, Obstacle, Point, Station, Zone
from .plan import Floorplan

if TYPE_CHECKING:
    from .formats.drawings import Drawn

_Floats = NDArray[np.float64]


def scaled(plan: Floorplan, metre: float) -> Floorplan:
    """Return `plan`, whose lengths are in a unit of `metre` metres, in metres.

    Measures of people, speeds and accelerations are in metres and seconds already.
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
    """Return `plan` with its point `origin` (metres) at (0, 0), rotated by `rotation` (radians).

    `UserError` if a gantry would have to be rotated, because its axes are those of the floor.
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
    """Return cosine and sine of `angle` (radians), exact for right angles."""
    # The cosine of π / 2 is 6e-17 in floating point, which would skew rectangles.
    return round(math.cos(angle), 15), round(math.sin(angle), 15)


def _mapped(plan: Floorplan, move: Callable[[_Floats], _Floats]) -> Floorplan:
    """Return `plan` with all positions (N, 2) moved. Lanes move with their origins."""

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


_Thing = TypeVar("_Thing", Obstacle, Station, Door, Zone, Gate)


_FIELDS = {
    **{key: key for key in ("title", "source", "boundary", "patrol", "safe_zone", "human")},
    "agvs": "lanes",
    "gantry": "gantry",
}
"""Fields of a floor that replace those of its base, by their keys in a file."""


def corrected(base: Floorplan, schema: FloorplanSchema, metre: float) -> Floorplan:
    """Return `base` with obstacles removed, moved and renamed.

    Names are those of the obstacles in `base`. Distances are in units of `metre` metres.
    """
    obstacles = []
    for obstacle in base.obstacles:
        name = obstacle.name
        if any(fnmatchcase(name, pattern) for pattern in schema.remove):
            continue
        if name in schema.move:
            dx, dy = (d * metre for d in schema.move[name])
            footprint = shapely.transform(obstacle.footprint, lambda at, d=(dx, dy): at + d)
            obstacle = replace(obstacle, footprint=footprint)
        obstacles.append(replace(obstacle, name=schema.rename.get(name, name)))
    return replace(base, obstacles=obstacles)


def correction_faults(base: Floorplan, schema: FloorplanSchema) -> Iterator[Fault]:
    """Yield the corrections that match no obstacle of `base`, or contradict each other."""
    names = [obstacle.name for obstacle in base.obstacles]
    removed = set()
    for k, pattern in enumerate(schema.remove):
        met = {name for name in names if fnmatchcase(name, pattern)}
        removed |= met
        if not met:
            yield _unknown(pattern, names), ("remove", k)
    for key, corrections in (("move", schema.move), ("rename", schema.rename)):
        for name in corrections:
            if name not in names:
                yield _unknown(name, names), (key, name)
            elif name in removed:
                yield f"{name!r} is removed as well", (key, name)


def _unknown(name: str, names: Sequence[str]) -> str:
    hint = suggestion(name, names) if names else "it has none"
    return f"no obstacle of the base is called {name!r}; {hint}"


def laid_over(base: Floorplan, top: Floorplan, keys: Iterable[str]) -> Floorplan:
    """Return `base` with `top` over it. `keys` are the keys of `top` in its file.

    An entry of `top` replaces one of the same kind and name.
    """
    laid = {_FIELDS[key]: getattr(top, _FIELDS[key]) for key in keys if key in _FIELDS}
    return replace(
        base,
        name=top.name,
        notices=(*base.notices, *top.notices),
        obstacles=_replaced(base.obstacles, top.obstacles),
        stations=_replaced(base.stations, top.stations),
        doors=_replaced(base.doors, top.doors),
        zones=_replaced(base.zones, top.zones),
        gates=_replaced(base.gates, top.gates),
        **laid,
    )


def _replaced(below: Sequence[_Thing], above: Sequence[_Thing]) -> list[_Thing]:
    over = [thing.name for thing in above]
    return [thing for thing in below if thing.name not in over] + list(above)


BUILT_IN = Path(__file__).parent / "data"
"""Folder of the floorplans that come with Floorwalker."""

FAR_OUT = 5.0
"""Distance, in sizes of the floor, beyond which positions are probably in another unit."""

IMAGES = (".pgm", ".png", ".bmp", ".tif", ".tiff")
"""Usual suffixes of the images of ROS maps."""


def builtin() -> tuple[str, ...]:
    """Return the names of the built-in floorplans.

    Returns
    -------
    tuple of str
        Names in alphabetical order.
    """
    return tuple(sorted(path.stem for path in BUILT_IN.glob("*.yaml")))


def load(source: str | Path) -> Floorplan:
    """Return a built-in floorplan, or read one from a file.

    Parameters
    ----------
    source : str or pathlib.Path
        Built-in name, or path of a file. The suffix determines the format.

    Returns
    -------
    Floorplan
        Floorplan in metres. `notices` lists what the reader ignored or assumed.

    Raises
    ------
    FloorplanError
        With all problems of the file, each with its line or field.

    Examples
    --------
    >>> import floorplan
    >>> plan = floorplan.load("ariac2023")
    >>> plan.stations["station1"].position
    (-5.0, 3.75)
    """
    text = str(source)
    if text in builtin():
        return parse((BUILT_IN / f"{text}.yaml").read_text(encoding="utf-8"), file=text)
    path = Path(source)
    plan = _read(path, None, ())
    if (
        path.suffix.lower() not in YAML.suffixes
    ):  # YAML files are checked with the lines of their faults
        check(plan, file=text)
    return plan


def parse(text: str, *, file: str = "<text>") -> Floorplan:
    """Return the floorplan in a text in the YAML format.

    Parameters
    ----------
    text : str
        Text of a floorplan file.
    file : str, optional
        Name of the text in errors.

    Returns
    -------
    Floorplan
        Floorplan in metres.

    Raises
    ------
    FloorplanError
        With all problems of the text, each with its line and field.
    """
    return build(parse_yaml(text, file, FloorplanError))


def build(document: Document, folder: Path | None = None, name: str = "") -> Floorplan:
    """Return the floorplan in `document`. `FloorplanError` lists all problems.

    A base is looked up in `folder`, by default the folder of the document. A floorplan without a
    name gets `name`, or the name of the file.
    """
    return _build(document, Path(document.file).parent if folder is None else folder, (), name)


def _read(path: Path, drawn: Drawn | None, above: tuple[Path, ...]) -> Floorplan:
    """Return the floor in a file, which may have faults. Files `above` are based on it."""
    suffix = path.suffix.lower()
    if suffix in YAML.suffixes:
        document = read_yaml(path, FloorplanError)
        if _is_ros_map(document):
            from .formats.ros_map import build_ros_map

            floor = build_ros_map(document)
            return replace(floor, notices=size_notices(floor, "metres", "resolution"))
        return _build(document, path.parent, (*above, path.resolve()))
    if suffix in READ:
        from .formats.drawings import AS_IT_IS

        read = function(OF_SUFFIX[suffix].reader)
        drawn = drawn or AS_IT_IS
        plan: Floorplan = read(path, drawn)
        if drawn.boundary is None and suffix != ".dxf":  # DXF files have a unit
            notices = size_notices(plan, unit_name(drawn.metre or 1.0))
            plan = replace(plan, notices=(*plan.notices, *notices))
        return plan
    if is_there(path):
        endings = ", ".join(READ)
        message = f"the name of a floorplan's file ends in one of {endings}"
        beside = path.with_suffix(".yaml")
        if suffix in IMAGES and is_there(beside):
            message += f"; of a ROS map it is that of its settings: {beside}"
        raise FloorplanError.of(path, message)
    hint = suggestion(str(path), builtin())
    raise FloorplanError.of(path, f"no such file, nor a built-in floorplan; {hint}")


def _is_ros_map(document: Document) -> bool:
    """Return whether a YAML document has keys of map_server."""
    return isinstance(document.data, dict) and not {"image", "resolution"}.isdisjoint(document.data)


def _build(document: Document, folder: Path, above: tuple[Path, ...], name: str = "") -> Floorplan:
    schema = document.checked(FloorplanSchema, FloorplanError)
    boundary = Polygon(schema.boundary or (), schema.holes)
    plan = Floorplan(
        name=schema.name or name or Path(document.file).stem,
        title=schema.title,
        source=schema.source,
        boundary=boundary,
        **parts(schema),
    )
    plan = scaled(plan, schema.metre)
    plan = replace(plan, zones=[*plan.zones, *_masked(schema, folder)])
    if schema.boundary:
        plan = replace(plan, notices=size_notices(plan, unit_name(schema.metre)))
    problems: list[Problem] = []
    if schema.base is not None:
        base = _base(schema, plan.boundary if schema.boundary else None, document, folder, above)
        problems += [_problem(document, *one) for one in correction_faults(base, schema)]
        base = corrected(base, schema, schema.metre)
        plan = laid_over(base, plan, schema.model_fields_set)
    try:
        x, y = schema.origin
        plan = put(plan, (x * schema.metre, y * schema.metre), schema.rotation)
    except UserError as why:
        problems.append(document.problem(str(why), "rotation"))
    problems += [_problem(document, *fault) for fault in faults(plan)]
    if problems and schema.units is None and schema.base and _is_far_out(plan):
        message = "lengths in this file are metres; if they are in another unit, give `units`"
        problems.append(document.problem(message, "base"))
    if problems:
        raise FloorplanError(document.file, problems)
    keep_sound(plan)
    return plan


def _masked(schema: FloorplanSchema, folder: Path) -> Iterator[Zone]:
    """Yield the zones of masks, in metres."""
    for name, zone in schema.zones.items():
        if not isinstance(zone, Zone):
            from .formats.ros_map import mask_zones

            yield from mask_zones(folder / zone.mask, name, zone)


def _is_far_out(plan: Floorplan) -> bool:
    """Return True if positions are so far from the floor that their unit is probably wrong."""
    places = [station.position for station in plan.stations]
    places += [plan.safe_zone.position] if plan.safe_zone else []
    west, south, east, north = plan.boundary.bounds
    size = max(east - west, north - south)
    return any(math.dist(at, (west, south)) > FAR_OUT * size for at in places)


def _base(
    schema: FloorplanSchema,
    boundary: Polygon | None,
    document: Document,
    folder: Path,
    above: tuple[Path, ...],
) -> Floorplan:
    """Return the base in metres, with this `boundary` unless it is None."""
    assert schema.base is not None
    name, path = schema.base, folder / schema.base
    keys = [key for key in OF_DRAWINGS if key in schema.model_fields_set]
    if keys and path.suffix.lower() not in LAYERED:
        message = f"only a drawing ({', '.join(LAYERED)}) has layers, and {name!r} is none"
        raise FloorplanError(document.file, [document.problem(message, key) for key in keys])
    if name in builtin():
        return load(name)
    if not is_there(path):
        message = f"no such file, nor a built-in floorplan: {name!r}"
        message = f"{message}; {suggestion(name, builtin())}"
        raise FloorplanError(document.file, [document.problem(message, "base")])
    if path.resolve() in above:
        message = f"{name!r} lies below itself"
        raise FloorplanError(document.file, [document.problem(message, "base")])
    return _read(path, _drawn(schema, boundary), above)


def _drawn(schema: FloorplanSchema, boundary: Polygon | None) -> Drawn:
    """Return the options for reading the base drawing, from the keys of the floor."""
    from .formats.drawings import Drawn, LayerGroup

    groups = None
    if schema.layers is not None:
        groups = {
            group: LayerGroup(
                tuple(keys.layers),
                None if keys.z is None else (keys.z[0] * schema.metre, keys.z[1] * schema.metre),
                keys.line_width,
                keys.hollow,
            )
            for group, keys in schema.layers.items()
        }
    drawn = Drawn(
        metre=None if schema.units is None else METRE[schema.units],
        groups=groups,
        leave_out=frozenset(schema.leave_out),
        boundary=boundary,
    )
    if schema.snap is not None:
        drawn = replace(drawn, snap=schema.snap)
    return drawn


def _problem(document: Document, message: str, place: Place) -> Problem:
    """Return a problem at its line, or at that of `base` if it comes from there."""
    problem = document.problem(message, *place)
    if place and place[:2] not in document.lines and ("base",) in document.lines:
        return replace(problem, line=document.lines["base",])
    return problem
