"""Floors from DXF drawings, sorted by layer, with flattened curves and expanded blocks.

Closed outlines bound areas, and so do lines, arcs and splines that meet. The area on the layer (or
in the group of layers) "boundary" bounds the floor, those on others are obstacles, called after
their layer or group. Elevation and thickness are their heights. Layers that are off or frozen, and
what is no shape (texts, dimensions, points), are left out.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import shapely

from ..building import unit_name
from ..checks import size_notices
from ..files.collector import paused_collector
from ..files.dataclass import dataclass
from ..files.problems import FloorplanError, Problem, UserError
from ..files.reading import require_readable
from ..model import Obstacle
from ..plan import Floorplan
from .curves import (
    POLYLINES,
    SAGITTA,
    SPLINES,
    Floats,
    corners_of,
    covered,
    hatch_outlines,
    vertices,
)
from .drawings import (
    BOUNDARY,
    Drawn,
    Name,
    Polyline,
    Shape,
    Unread,
    areas_in,
    boundary_problems,
    hatched,
    line,
    notices_of,
    numbered,
    place_of,
)

if TYPE_CHECKING:
    from ezdxf.document import Drawing


LARGEST_FILE = 64_000_000
"""Bytes. Maximum size of a drawing. A hall in all detail takes a few million."""

DAMAGED = (
    *(ArithmeticError, AttributeError, LookupError, RuntimeError, StopIteration),
    *(TypeError, ValueError),
)
"""Exceptions that ezdxf raises for damaged drawings, besides its own."""

TOLD = frozenset(("TEXT", "MTEXT", "POINT", "DIMENSION", "LEADER", "MULTILEADER", "TOLERANCE"))
"""Kinds of entities that are skipped, because they are no shapes and no shapes depend on them."""

_ENTITY, _HANDLE, _COMMENT = 0, 5, 999
"""Codes of tags: begin of an entity, handle, comment."""


def open_drawing(path: Path) -> Drawing:
    """Return the drawing in the file at `path`. `FloorplanError` if it cannot be read."""
    try:
        from ezdxf.filemanagement import readfile
        from ezdxf.lldxf.const import DXFError
    except ImportError:
        message = "DXF drawings can't be read without ezdxf; pip install 'floorwalker[floorplans]'"
        raise FloorplanError.of(path, message) from None
    require_readable(path, FloorplanError, LARGEST_FILE)
    try:
        with redirect_stdout(io.StringIO()):  # because ezdxf prints warnings
            try:
                return _without_texts(path)
            except (DXFError, OSError, *DAMAGED):
                return readfile(path)  # whose errors name the damaged line
    except (DXFError, *DAMAGED) as why:
        message = f"is not a DXF drawing: {str(why) or 'it ends too early'}"
        raise FloorplanError.of(path, message) from None
    except OSError as why:
        # ezdxf raises this for files that it does not recognize.
        message = f"can't be read: {why.strerror}" if why.strerror else "is not a DXF drawing"
        raise FloorplanError.of(path, message) from None


class _Tag(NamedTuple):
    """Tag in the form that ezdxf expects from a tag loader."""

    code: int
    value: str


def _without_texts(path: Path) -> Drawing:
    """Return the drawing in the text file at `path`. It may raise any exception."""
    from ezdxf.document import Drawing
    from ezdxf.filemanagement import dxf_file_info
    from ezdxf.lldxf.validator import is_dxf_file

    if not is_dxf_file(str(path)):
        raise UserError("is not a DXF file in text")
    encoding = dxf_file_info(path).encoding
    lines = path.read_text(encoding=encoding, errors="surrogateescape").split("\n")
    tags = lines[: len(lines) // 2 * 2]
    codes, values = _kept([int(code) for code in tags[::2]], tags[1::2])
    tag: Any = _Tag
    return Drawing.load(map(tag, codes, values))


def _kept(codes: list[int], values: list[str]) -> tuple[list[int], list[str]]:
    """Return codes and values of all tags except those of texts with handles.

    Entities without handles are numbered as they are read, and a floor above the drawing may use
    these numbers.
    """
    if _COMMENT in codes:
        indices = [k for k, code in enumerate(codes) if code != _COMMENT]
        codes, values = [codes[k] for k in indices], [values[k] for k in indices]
    begins = [k for k, code in enumerate(codes) if code == _ENTITY]
    read: tuple[list[int], list[str]] = [], []
    for begin, end in zip(begins, [*begins[1:], len(codes)], strict=True):
        entity = codes[begin:end]
        if values[begin].strip() not in TOLD or _HANDLE not in entity:
            read[0].extend(entity)
            read[1].extend(values[begin:end])
        if values[begin] == "EOF":
            break
    return read


MOST_COPIES = 10_000
"""Maximum number of copies of a block in one insert."""

SILENT = frozenset(
    (
        *("TEXT", "MTEXT", "ATTRIB", "ATTDEF", "TOLERANCE", "POINT", "VIEWPORT"),
        *("DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION"),
        *("LEADER", "MULTILEADER", "MLEADER"),
    )
)
"""Kinds of entities that describe shapes, but are none."""

LINES = SPLINES | {"LINE", "ARC", "ELLIPSE"}
OUTLINES = POLYLINES | {"CIRCLE", "SOLID", "TRACE", "3DFACE"}
HATCHES = frozenset(("HATCH", "MPOLYGON"))
PARTED = frozenset(("MLINE",))
"""Kinds of entities that consist of several lines."""


class _Entity:
    """Entity of a drawing. Its outlines are computed once for all of its copies."""

    def __init__(self, entity: Any) -> None:
        self.entity = entity
        self.kind: str = entity.dxftype()
        has_layer = entity.dxf.is_supported("layer")  # kinds that ezdxf does not know have none
        self.layer = str(entity.dxf.get("layer", "0")) if has_layer else "0"
        self._drawn: dict[float, tuple[list[Floats], shapely.Geometry | None]] = {}

    @cached_property
    def handle(self) -> str:
        """Handle of the entity, or of the entity that contains it."""
        entity = self.entity
        source = entity if entity.dxf.handle else entity.source_of_copy
        return str(getattr(getattr(source, "dxf", None), "handle", None) or "")

    @property
    def closed(self) -> bool:
        """Whether it is marked as closed, wherever its ends are."""
        if self.kind in POLYLINES:
            return bool(self.entity.is_closed)
        if self.kind == "SPLINE":
            return bool(self.entity.closed)
        return self.kind in ("CIRCLE", "SOLID", "TRACE", "3DFACE")

    @property
    def thickness(self) -> Floats:
        """Extrusion vector (3,) in units of the drawing."""
        dxf = self.entity.dxf
        if not dxf.is_supported("thickness") or not dxf.get("thickness", 0.0):
            return np.zeros(3)
        return float(dxf.thickness) * np.array((*dxf.get("extrusion", (0, 0, 1)),))

    def drawn(self, distance: float) -> tuple[list[Floats], shapely.Geometry | None]:
        """Return its outlines (N, 3) in units of the drawing, and the area of its width.

        Curves are flattened within `distance`. Errors as of `corners_of`.
        """
        if distance not in self._drawn:
            entity = self.entity
            if self.kind in HATCHES:
                self._drawn[distance] = hatch_outlines(entity, distance), None
            else:
                straight = self._straight
                corners = corners_of(entity, distance) if straight is None else straight
                flat = self.kind == "LWPOLYLINE" or (
                    self.kind == "POLYLINE" and entity.is_2d_polyline
                )
                area = covered(entity, corners, distance) if flat else None
                self._drawn[distance] = [corners], area
        return self._drawn[distance]

    @property
    def _straight(self) -> Floats | None:
        """Corners (N, 3) of a line, or of a horizontal polyline without arcs, otherwise None."""
        dxf = self.entity.dxf
        if self.kind == "LINE":
            return np.array((dxf.start.xyz, dxf.end.xyz))
        if self.kind != "LWPOLYLINE":
            return None
        if dxf.hasattr("extrusion") and tuple(dxf.extrusion) != (0.0, 0.0, 1.0):
            return None
        points = vertices(self.entity)
        if len(points) < 2 or points[:, 4].any():
            return None
        points[:, 2] = dxf.elevation
        return points[:, :3]

    @cached_property
    def steps(self) -> list[Floats]:
        """Transforms (4, 4) of the copies of the block of an insert."""
        insert = self.entity
        several = insert.multi_insert() if insert.mcount > 1 else (insert,)
        return [np.array([*one.matrix44()]).reshape(4, 4) for one in several]


@dataclass(frozen=True)
class _Inserted:
    """Copy of a block, inside the `blocks` of these names.

    Its entities on layer 0 are on `layer`, and `within` names its place. The matrix `at` (4, 4)
    transforms it. It is None for the model space.
    """

    layer: str | None = None
    within: str = ""
    blocks: frozenset[str] = frozenset()
    at: Floats | None = None

    def named(self, one: _Entity) -> str:
        """Return the name of an entity in the block."""
        name = f"{one.kind} {one.handle}".rstrip()
        return f"{self.within}, {name}" if self.within else name

    def block(self, name: str, layer: str, within: str, step: Floats) -> _Inserted:
        """Return a copy of the block of this name, placed into this one by the matrix `step`."""
        at = step if self.at is None else step @ self.at
        return _Inserted(layer, within, self.blocks | {name.casefold()}, at)

    @cached_property
    def stretch(self) -> float:
        """Maximum scale factor of the block."""
        if self.at is None:
            return 1.0
        # Rounded, so that rotated copies share the flattened curves.
        return max(float(f"{np.linalg.norm(self.at[:3, :3], 2):.9g}"), 1e-9)

    def put(self, points: Floats) -> Floats:
        """Return the positions of `points` (N, 2 or 3) of the block."""
        if self.at is None:
            return points
        # ezdxf multiplies row vectors by matrices, whose last row is the translation.
        size = points.shape[1]
        placed: Floats = points @ self.at[:size, :size] + self.at[3, :size]
        return placed

    def put_area(self, area: shapely.Geometry | None, metre: float) -> shapely.Geometry | None:
        """Return an area of the block at its position, in metres."""
        if area is None:
            return None
        return shapely.transform(area, lambda points: self.put(points) * metre)

    def rise(self, thickness: Floats) -> float:
        """Return the height in the drawing of an extrusion by `thickness` (3,)."""
        return float((thickness if self.at is None else thickness @ self.at[:3, :3])[2])


_MODEL_SPACE = _Inserted()


class Reader:
    """Reader of the shapes of a drawing with a unit of `metre` metres.

    `layers` are the visible layers with shapes.
    """

    def __init__(self, drawing: Drawing, metre: float, drawn: Drawn) -> None:
        self.layers: set[str] = set()
        self._drawing = drawing
        self._metre = metre
        self._drawn = drawn
        self._blocks: dict[str, list[_Entity]] = {}
        self.group_of = lru_cache(None)(drawn.group_of)
        """Name of the group of a layer, or None."""
        hidden = {
            layer.dxf.name.casefold(): (layer.is_off() or layer.is_frozen(), layer.is_frozen())
            for layer in drawing.layers
        }
        self._hidden = lru_cache(None)(lambda layer: hidden.get(layer.casefold(), (False, False)))

    def shapes(self) -> Iterator[Shape]:
        """Yield the shapes of the model space, and the ignored entities."""
        return self._read(map(_Entity, self._drawing.modelspace()), _MODEL_SPACE)

    def _read(self, entities: Iterable[_Entity], block: _Inserted) -> Iterator[Shape]:
        for one in entities:
            kind, layer = one.kind, one.layer
            if block.layer is not None and layer == "0":
                layer = block.layer  # as AutoCAD draws layer 0 of a block
            hidden, frozen = self._hidden(layer)
            if kind in SILENT or (frozen if kind == "INSERT" else hidden):
                continue
            name = partial(block.named, one)
            if self._drawn.leave_out and one.handle in self._drawn.leave_out:
                yield Unread(layer, name, "is left out as asked", False)
                continue
            if kind == "INSERT":
                yield from self._insert(one, layer, block)
                continue
            self.layers.add(layer)
            if self.group_of(layer) is None:
                yield Unread(layer, name, "is on a layer that no group has", False)
            elif kind in PARTED:
                for part in one.entity.virtual_entities():
                    yield from self._traced(_Entity(part), layer, name, block)
            else:
                yield from self._traced(one, layer, name, block)

    def _insert(self, one: _Entity, layer: str, within: _Inserted) -> Iterator[Shape]:
        insert = one.entity
        name = insert.dxf.get("name", "")
        block = insert.block()
        refuse = partial(Unread, layer, partial(within.named, one))
        if block is None:
            yield refuse(f"there is no block {name!r}")
            return
        if block.block is not None and block.block.is_xref:
            why = f"refers to another drawing ({name!r}); bind it into this one"
            yield refuse(why, self.group_of(layer) is not None)
            return
        if name.casefold() in within.blocks:
            yield refuse(f"the block {name!r} contains itself")
            return
        if name not in self._blocks:
            self._blocks[name] = [_Entity(entity) for entity in block]
        if insert.mcount > MOST_COPIES:
            yield refuse(f"puts {insert.mcount:,} copies of a block, more than {MOST_COPIES:,}")
            return
        place = f"{within.named(one)} ({name})"
        for step in one.steps:
            inserted = within.block(name, layer, place, step)
            yield from self._read(self._blocks[name], inserted)

    def _traced(self, one: _Entity, layer: str, name: Name, block: _Inserted) -> Iterator[Shape]:
        """Yield the shapes of an entity in a block."""
        from ezdxf.lldxf.const import DXFError

        kind, metre = one.kind, self._metre
        refuse = partial(Unread, layer, name)
        if kind in HATCHES and self._drawn.groups is None:
            yield refuse("is hatched, which is read only from layers that `layers` names", False)
            return
        if kind not in LINES | OUTLINES | HATCHES:
            yield refuse("can't be read as an outline: draw polylines, lines or circles")
            return
        if kind == "POLYLINE" and not (one.entity.is_2d_polyline or one.entity.is_3d_polyline):
            yield refuse("is a mesh; only plain outlines can be read")
            return
        try:
            outlines, area = one.drawn(SAGITTA / metre / block.stretch)
        except UserError as why:
            yield refuse(str(why))
            return
        except (DXFError, *DAMAGED) as why:
            yield refuse(f"is damaged: {why}")
            return
        placed = [block.put(outline) * metre for outline in outlines]
        if kind in HATCHES:
            yield from hatched(layer, name, [outline for outline in placed if len(outline) >= 3])
        elif len(placed[0]) < 2:
            yield refuse("has no length")
        else:
            height = block.rise(one.thickness) * metre
            area = block.put_area(area, metre)
            yield line(layer, name, placed[0], one.closed, height, area)


@paused_collector()
def load_dxf(path: Path, drawn: Drawn) -> Floorplan:
    """Return the floorplan in the DXF file at `path`. `FloorplanError` lists all problems."""
    file = str(path)
    drawing = open_drawing(path)
    notices: list[Problem] = []
    metre, unit = _metre(drawing, drawn, file, notices)
    reader = Reader(drawing, metre, drawn)
    shapes: dict[str, list[Polyline]] = {}
    unread: list[Unread] = []
    try:
        with np.errstate(all="ignore"):  # invalid numbers are rejected below
            for shape in reader.shapes():
                if isinstance(shape, Polyline):
                    shapes.setdefault(str(reader.group_of(shape.layer)), []).append(shape)
                else:
                    unread.append(shape)
    except DAMAGED as why:
        raise FloorplanError.of(path, f"has a damaged entity: {why}") from None
    problems = [Problem(one.why, place_of(one)) for one in unread if one.is_problem]
    areas: list[Obstacle] = []
    for name, polylines in shapes.items():
        for area in areas_in(name, polylines, drawn):
            if isinstance(area, Obstacle):
                areas.append(area)
            elif isinstance(area, Unread):
                unread.append(area)
            else:
                problems.append(area)
    problems += drawn.unmatched(reader.layers)
    problems = boundary_problems(areas, reader.layers, drawn, problems)
    if problems:
        raise FloorplanError(file, problems)
    bounding = [area.footprint for area in areas if area.name == BOUNDARY]
    plan = Floorplan(
        name=path.stem,
        source=f"{path.name} (DXF)",
        boundary=bounding[0] if drawn.boundary is None else drawn.boundary,
        obstacles=numbered([area for area in areas if area.name != BOUNDARY]),
    )
    if drawn.boundary is None:
        notices += size_notices(plan, unit)
    return replace(
        plan, notices=(*notices, *notices_of(one for one in unread if not one.is_problem))
    )


def _metre(drawing: Drawing, drawn: Drawn, file: str, notices: list[Problem]) -> tuple[float, str]:
    """Return the unit of the drawing in metres, and its name. Add a notice if it is uncertain."""
    from ezdxf.enums import InsertUnits
    from ezdxf.units import conversion_factor

    try:
        unit = InsertUnits(drawing.units)
        named = unit != InsertUnits.Unitless
        own = float(conversion_factor(unit, InsertUnits.Meters)) if named else 1.0
    except (ValueError, TypeError):
        if drawn.metre is not None:
            return drawn.metre, unit_name(drawn.metre)
        message = f"its unit ($INSUNITS = {drawing.units}) is not known; use metres"
        raise FloorplanError.of(file, message) from None
    if drawn.metre is None:
        if not named:
            message = "the drawing gives no unit ($INSUNITS), metres are assumed"
            notices.append(Problem(f"{message}; a floor on top of it can give `units`"))
        return own, f"{unit.name.lower()} ($INSUNITS)" if named else "metres, which are assumed"
    if named and abs(own - drawn.metre) > 1e-9:
        message = f"the drawing gives {unit.name.lower()} as its unit ($INSUNITS)"
        notices.append(Problem(f"{message}; the `units` of the floor on top of it count"))
    return drawn.metre, unit_name(drawn.metre)
