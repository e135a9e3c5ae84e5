"""Floors from DXF drawings: closed polylines and circles, sorted by their layers.

The one on the layer "boundary" bounds the floor; those on other layers are obstacles, called after
their layer. Their elevation and thickness are their heights. Layers that are off or frozen, and
what can't bound anything (texts, dimensions, points, hatches), are left out.
"""

from __future__ import annotations

import io
import itertools
from collections import Counter
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shapely.geometry import Polygon

from .checks import polygon_fault
from .model import DEFAULT_HEIGHT, Floorplan, Obstacle
from .problems import FloorplanError, Problem
from .reading import require_readable

if TYPE_CHECKING:
    from ezdxf.document import Drawing

BOUNDARY = "boundary"
"""The layer of the outline of the floor, in any case."""

LARGEST_FILE = 32_000_000
"""Bytes: a hall that is drawn in all detail takes a few million."""

SAGITTA = 1e-3
"""Metres. How far a drawn arc may be from the corners that stand for it."""

DAMAGED = (
    *(ArithmeticError, AttributeError, LookupError, RuntimeError, StopIteration),
    *(TypeError, ValueError),
)
"""Exceptions that ezdxf raises, besides its own, at a drawing that is damaged."""

_OUTLINES = ("LWPOLYLINE", "POLYLINE", "CIRCLE")
_SILENT = ("TEXT", "MTEXT", "DIMENSION", "LEADER", "MULTILEADER", "POINT", "HATCH", "VIEWPORT")


@dataclass(frozen=True)
class _Outline:
    layer: str
    handle: str
    shape: Polygon
    bottom: float
    top: float


def load_dxf(path: Path) -> Floorplan:
    """The floorplan in the DXF file at `path`; `FloorplanError` with all that is wrong with it."""
    file = str(path)
    drawing = _drawing(path)
    metre = _metre(drawing, file)
    outlines: list[_Outline] = []
    problems: list[Problem] = []
    others: Counter[tuple[str, str]] = Counter()
    for entity in drawing.modelspace():
        name = _layer_name(entity)
        layer = drawing.layers.get(name) if drawing.layers.has_entry(name) else None
        kind = entity.dxftype()
        if kind in _SILENT or (layer is not None and (layer.is_off() or layer.is_frozen())):
            continue
        if kind not in _OUTLINES:
            others[name, kind] += 1
            continue
        found = _outline(entity, metre)
        if isinstance(found, _Outline):
            outlines.append(found)
        else:
            problems.append(Problem(found, _place(entity)))
    for (name, kind), count in sorted(others.items()):
        message = (
            f"{count} {kind} can't be read as outlines: draw closed polylines or circles,"
            " or turn the layer off"
        )
        problems.append(Problem(message, f"layer {name!r}"))
    bounding = [o for o in outlines if o.layer.lower() == BOUNDARY]
    if len(bounding) != 1 and not problems:
        problems.append(_boundary_problem(len(bounding), outlines))
    if problems:
        raise FloorplanError(file, problems)
    return Floorplan(
        name=path.stem,
        source=f"{path.name} (DXF)",
        boundary=bounding[0].shape,
        obstacles=_obstacles([o for o in outlines if o.layer.lower() != BOUNDARY]),
    )


def _drawing(path: Path) -> Drawing:
    try:
        from ezdxf.filemanagement import readfile
        from ezdxf.lldxf.const import DXFError
    except ImportError:
        message = "DXF drawings can't be read without ezdxf; pip install 'floorwalker[floorplans]'"
        raise FloorplanError.of(path, message) from None
    require_readable(path, FloorplanError, LARGEST_FILE)
    try:
        with redirect_stdout(io.StringIO()):  # ezdxf prints some of its warnings
            return readfile(path)
    except (DXFError, *DAMAGED) as why:
        message = f"is not a DXF drawing: {str(why) or 'it ends too early'}"
        raise FloorplanError.of(path, message) from None
    except OSError as why:
        # ezdxf says this without a system's reason of a file that it does not recognise.
        message = f"can't be read: {why.strerror}" if why.strerror else "is not a DXF drawing"
        raise FloorplanError.of(path, message) from None


def _metre(drawing: Drawing, file: str) -> float:
    """Return the length of a unit of the drawing in metres; 1 where it does not say."""
    from ezdxf.enums import InsertUnits
    from ezdxf.units import conversion_factor

    try:
        unit = InsertUnits(drawing.units)
        known = unit == InsertUnits.Unitless
        return 1.0 if known else float(conversion_factor(unit, InsertUnits.Meters))
    except (ValueError, TypeError):
        message = f"its unit ($INSUNITS = {drawing.units}) is not known; use metres"
        raise FloorplanError.of(file, message) from None


def _layer_name(entity: Any) -> str:
    """Return the layer of `entity`; "0" for kinds that ezdxf does not know."""
    known = entity.dxf.is_supported("layer")
    return str(entity.dxf.get("layer", "0")) if known else "0"


def _place(entity: Any) -> str:
    return f"layer {_layer_name(entity)!r}, {entity.dxftype()} {entity.dxf.handle}"


def _outline(entity: Any, metre: float) -> _Outline | str:
    """Return the outline of `entity`, or the reason why it has none."""
    from ezdxf import path

    kind = entity.dxftype()
    if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
        return "is a mesh; only plain outlines can be read"
    outline = path.make_path(entity)
    closed = kind == "CIRCLE" or entity.is_closed
    if not closed and not (len(outline) > 2 and outline.is_closed):
        return "is open; close it"
    corners = [(v.x * metre, v.y * metre) for v in outline.flattening(SAGITTA / metre)]
    if len(corners) < 3:
        return "has fewer than three corners"
    shape = Polygon(corners)
    if fault := polygon_fault(shape):
        return fault
    bottom = _elevation(entity) * metre
    thickness = entity.dxf.get("thickness", 0.0) * metre
    heights = sorted((bottom, bottom + (thickness or DEFAULT_HEIGHT)))
    return _Outline(_layer_name(entity), entity.dxf.handle, shape, heights[0], heights[1])


def _elevation(entity: Any) -> float:
    if entity.dxftype() == "LWPOLYLINE":
        return float(entity.dxf.elevation)
    if entity.dxftype() == "CIRCLE":
        return float(entity.dxf.center.z)
    return float(entity.dxf.get("elevation", (0.0, 0.0, 0.0))[2])


def _boundary_problem(count: int, outlines: list[_Outline]) -> Problem:
    layers = ", ".join(sorted({o.layer for o in outlines})) or "none"
    return Problem(
        f"expected one outline on the layer {BOUNDARY!r}, found {count}"
        f" (layers with outlines: {layers})"
    )


def _obstacles(outlines: list[_Outline]) -> tuple[Obstacle, ...]:
    """Return the outlines as obstacles, named by layer and numbered where it has several.

    A number is left out where another layer has that name.
    """
    several = Counter(o.layer for o in outlines)
    numbers = {layer: itertools.count(1) for layer in several}
    taken = {layer for layer, count in several.items() if count == 1}
    found = []
    for o in outlines:
        name = o.layer
        if several[o.layer] > 1:
            numbered = (f"{o.layer}{k}" for k in numbers[o.layer])
            name = next(one for one in numbered if one not in taken)
            taken.add(name)
        found.append(Obstacle(name, o.shape, o.bottom, o.top))
    return tuple(found)
