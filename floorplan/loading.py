"""Loading of floorplans by the name of a file or of a built-in one."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from shapely.geometry import Polygon

from .building import parts
from .checks import check, faults, keep_sound
from .document import Document, parse_yaml, read_yaml
from .dxf import load_dxf
from .geojson import load_geojson
from .layers import AS_IT_IS, Drawn, Group
from .movingai import load_drawn_map
from .overlay import corrected, correction_faults, laid_over
from .placing import put, scaled
from .plan import Floorplan
from .problems import FloorplanError, Problem, UserError, suggestion
from .reading import is_there
from .ros_map import build_ros_map, is_ros_map
from .schema import METRE, OF_DRAWINGS, FloorplanSchema
from .validation import Place
from .wkt import load_wkt

BUILT_IN = Path(__file__).parent / "data"
"""Folder of the floorplans that come with Floorwalker."""

FAR_OUT = 5.0
"""Sizes of a floor. What is farther away from it was probably meant in another unit."""

YAML_SUFFIXES = (".yaml", ".yml")
LAYERED = {".dxf": load_dxf, ".geojson": load_geojson, ".json": load_geojson}
"""Formats of drawings with layers, by suffix."""
DRAWINGS = {**LAYERED, ".wkt": load_wkt, ".map": load_drawn_map}
"""Formats whose unit may be left open, by suffix."""
IMAGES = (".pgm", ".png", ".bmp")
"""Suffixes that the image of a ROS map usually has."""


def builtin() -> tuple[str, ...]:
    """Return the names of the floorplans that come with Floorwalker, sorted."""
    return tuple(sorted(path.stem for path in BUILT_IN.glob("*.yaml")))


def load(source: str | Path) -> Floorplan:
    """Return the floorplan called `source` (a built-in name) or in the file at `source`.

    `FloorplanError` lists everything that is wrong with the file, each with its place.
    """
    text = str(source)
    if text in builtin():
        return parse((BUILT_IN / f"{text}.yaml").read_text(encoding="utf-8"), file=text)
    path = Path(source)
    plan = _read(path, AS_IT_IS, ())
    if path.suffix.lower() not in YAML_SUFFIXES:  # those are checked, with the lines of faults
        check(plan, file=text)
    return plan


def parse(text: str, *, file: str = "<text>") -> Floorplan:
    """Return the floorplan in `text`, in the YAML format; errors call it `file`."""
    return build(parse_yaml(text, file, FloorplanError))


def build(document: Document, folder: Path | None = None, name: str = "") -> Floorplan:
    """Return the floorplan in `document`; `FloorplanError` with all that is wrong with it.

    A base of it is looked up from `folder`, that of the document's file by default. If it has no
    name of its own it is called `name`, or else as the file.
    """
    return _build(document, Path(document.file).parent if folder is None else folder, (), name)


def _read(path: Path, drawn: Drawn, above: tuple[Path, ...]) -> Floorplan:
    """Return the floor in the file at `path`, below the files `above`; it need not be sound."""
    suffix = path.suffix.lower()
    if suffix in YAML_SUFFIXES:
        document = read_yaml(path, FloorplanError)
        if is_ros_map(document):
            return build_ros_map(document)
        return _build(document, path.parent, (*above, path.resolve()))
    if suffix in DRAWINGS:
        return DRAWINGS[suffix](path, drawn)
    if is_there(path):
        known = ", ".join((*YAML_SUFFIXES, *DRAWINGS))
        message = f"the name of a floorplan's file ends in one of {known}"
        beside = path.with_suffix(".yaml")
        if suffix in IMAGES and is_there(beside):
            message += f"; of a ROS map it is that of its settings: {beside}"
        raise FloorplanError.of(path, message)
    hint = suggestion(str(path), builtin())
    raise FloorplanError.of(path, f"no such file, nor a built-in floorplan; {hint}")


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


def _is_far_out(plan: Floorplan) -> bool:
    """Return True if places are so far from the floor as lengths are in another unit."""
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
    """Return the floor below, in metres; with this `boundary` if there is one."""
    assert schema.base is not None
    name, path = schema.base, folder / schema.base
    given = [key for key in OF_DRAWINGS if key in schema.model_fields_set]
    if given and path.suffix.lower() not in LAYERED:
        message = f"only a drawing ({', '.join(LAYERED)}) has layers, and {name!r} is none"
        raise FloorplanError(document.file, [document.problem(message, key) for key in given])
    if name in builtin():
        return load(name)
    if not is_there(path):
        message = f"no such file, nor a built-in floorplan: {name!r}"
        message = f"{message}; {suggestion(name, builtin())}"
        raise FloorplanError(document.file, [document.problem(message, "base")])
    if path.resolve() in above:
        message = f"{name!r} lies below itself"
        raise FloorplanError(document.file, [document.problem(message, "base")])
    groups = None
    if schema.layers is not None:
        groups = {
            group: Group(
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
    return _read(path, drawn, above)


def _problem(document: Document, message: str, place: Place) -> Problem:
    """Return a problem at its line, or that of the `base` that it comes from."""
    problem = document.problem(message, *place)
    if place and place[:2] not in document.lines and ("base",) in document.lines:
        return replace(problem, line=document.lines["base",])
    return problem
