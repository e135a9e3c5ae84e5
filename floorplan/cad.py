"""Entities of a CAD drawing as lines and areas: curves drawn out, blocks put where they stand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from .layers import Drawn

if TYPE_CHECKING:
    from ezdxf.document import Drawing

SAGITTA = 1e-3
"""Metres. How far a drawn arc may be from the corners that stand for it."""

DEEPEST = 32
"""Most blocks inside each other: deeper ones contain themselves."""

_NOWHERE = shapely.Polygon()

SILENT = frozenset(
    (
        *("TEXT", "MTEXT", "ATTRIB", "ATTDEF", "TOLERANCE", "POINT", "VIEWPORT"),
        *("DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION"),
        *("LEADER", "MULTILEADER", "MLEADER"),
    )
)
"""Kinds of entities that are about shapes, but are none."""

LINES = frozenset(("LINE", "ARC", "ELLIPSE", "SPLINE", "HELIX"))
OUTLINES = frozenset(("LWPOLYLINE", "POLYLINE", "CIRCLE", "SOLID", "TRACE", "3DFACE"))
HATCHES = frozenset(("HATCH", "MPOLYGON"))
PARTED = frozenset(("MLINE",))
"""Kinds that are drawn as several lines."""


@dataclass(frozen=True)
class Shape:
    """A line of a drawing in metres, of the layer `layer`; `place` names its entity.

    `corners` is (N, 2). A `closed` one bounds an area; a `filled` one is a hatched area, with
    `holes` in it. `bottom` and `thickness` are heights.
    """

    layer: str
    place: str
    corners: NDArray[np.float64]
    closed: bool
    bottom: float
    thickness: float
    filled: bool = False
    holes: shapely.Geometry = None


@dataclass(frozen=True)
class Unread:
    """An entity that is no shape: `why` it is not, and whether it is on a layer that is read."""

    layer: str
    place: str
    why: str
    wanted: bool


class Reader:
    """Reads the shapes of a drawing with a unit of `metre` metres.

    `layers` are those with something on them that is not switched off.
    """

    def __init__(self, drawing: Drawing, metre: float, drawn: Drawn) -> None:
        self.layers: set[str] = set()
        self._drawing = drawing
        self._metre = metre
        self._drawn = drawn
        self.group_of = lru_cache(None)(drawn.group_of)
        """The name of the group of a layer, None if it is in none."""
        self._hidden = {
            layer.dxf.name.casefold(): (layer.is_off() or layer.is_frozen(), layer.is_frozen())
            for layer in drawing.layers
        }

    def shapes(self) -> Iterator[Shape | Unread]:
        """Yield the shapes of the model space, and what is left out of it."""
        yield from self._read(self._drawing.modelspace(), None, "", 0)

    def _read(
        self, entities: Iterable[Any], inserted_on: str | None, within: str, depth: int
    ) -> Iterator[Shape | Unread]:
        for entity in entities:
            kind = entity.dxftype()
            layer = _layer(entity)
            if inserted_on is not None and layer == "0":
                layer = inserted_on  # so AutoCAD draws what a block has on the layer 0
            hidden, frozen = self._hidden.get(layer.casefold(), (False, False))
            if kind in SILENT or (frozen if kind == "INSERT" else hidden):
                continue
            if self._drawn.leave_out and _handle(entity) in self._drawn.leave_out:
                yield Unread(layer, _named(kind, entity, within), "is left out as asked", False)
                continue
            if kind == "INSERT":
                yield from self._insert(entity, layer, within, depth)
                continue
            self.layers.add(layer)
            place = partial(_named, kind, entity, within)
            if self.group_of(layer) is None:
                yield Unread(layer, place(), "is on a layer that no group has", False)
            elif kind in PARTED:
                for part in entity.virtual_entities():
                    yield self._shape(part, part.dxftype(), layer, place())
            elif kind in HATCHES:
                yield from self._hatch(entity, layer, place())
            else:
                yield self._shape(entity, kind, layer, place())

    def _insert(self, insert: Any, layer: str, within: str, depth: int) -> Iterator[Shape | Unread]:
        place = _named("INSERT", insert, within)
        name = insert.dxf.get("name", "")
        block = insert.block()
        if block is None:
            yield Unread(layer, place, f"there is no block {name!r}", True)
            return
        if block.block is not None and block.block.is_xref:
            why = f"refers to another drawing ({name!r}); bind it into this one"
            yield Unread(layer, place, why, self.group_of(layer) is not None)
            return
        if depth >= DEEPEST:
            yield Unread(layer, place, f"the block {name!r} contains itself", True)
            return
        skipped: list[tuple[Any, str]] = []
        for one in insert.multi_insert() if insert.mcount > 1 else (insert,):
            parts = one.virtual_entities(
                skipped_entity_callback=lambda entity, why: skipped.append((entity, why))
            )
            yield from self._read(parts, layer, f"{place} ({name})", depth + 1)
        for entity, why in skipped:
            if entity.dxftype() not in SILENT:
                own = _layer(entity)
                own = layer if own == "0" else own
                wanted = self.group_of(own) is not None
                at = _named(entity.dxftype(), entity, f"{place} ({name})")
                yield Unread(own, at, f"can't be put where its block is: {why}", wanted)

    def _shape(self, entity: Any, kind: str, layer: str, place: str) -> Shape | Unread:
        refuse = partial(Unread, layer, place, wanted=True)
        if kind == "LINE":
            ends = (entity.dxf.start, entity.dxf.end)
            corners = np.array([(v.x, v.y, v.z) for v in ends]) * self._metre
            return self._line(entity, layer, place, corners, closed=False)
        if kind not in LINES | OUTLINES:
            return refuse(why="can't be read as an outline: draw polylines, lines or circles")
        if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
            return refuse(why="is a mesh; only plain outlines can be read")
        if kind == "LWPOLYLINE" and (plain := _plain_polyline(entity)) is not None:
            corners = plain * self._metre
        else:
            from ezdxf import path

            outline = path.make_path(entity)
            if not len(outline):
                return refuse(why="has no length")
            flat = outline.flattening(SAGITTA / self._metre)
            corners = np.array([(v.x, v.y, v.z) for v in flat]) * self._metre
        if not np.isfinite(corners).all():
            return refuse(why="has coordinates that are not numbers")
        closed = kind in ("CIRCLE", "SOLID", "TRACE", "3DFACE")
        closed = closed or (kind in ("LWPOLYLINE", "POLYLINE") and entity.is_closed)
        if len(corners) > 3 and bool((corners[0, :2] == corners[-1, :2]).all()):
            closed = True
        if closed and len(corners) < 3:
            return refuse(why="has fewer than three corners")
        return self._line(entity, layer, place, corners, closed=closed)

    def _line(
        self, entity: Any, layer: str, place: str, corners: NDArray[np.float64], *, closed: bool
    ) -> Shape:
        thickness = entity.dxf.get("thickness", 0.0) if entity.dxf.is_supported("thickness") else 0
        bottom = float(corners[:, 2].min())
        return Shape(layer, place, corners[:, :2], closed, bottom, thickness * self._metre)

    def _hatch(self, hatch: Any, layer: str, place: str) -> Iterator[Shape | Unread]:
        """Yield the hatched areas: a boundary inside an odd number of others is an opening."""
        if self._drawn.groups is None:
            yield Unread(
                layer, place, "hatches are read only from layers that `layers` names", False
            )
            return
        from ezdxf import path

        area: Any = _NOWHERE
        bottom = 0.0
        for outline in path.from_hatch(hatch):
            corners = [(v.x, v.y, v.z) for v in outline.flattening(SAGITTA / self._metre)]
            if len(corners) >= 3:
                scaled = np.array(corners) * self._metre
                bottom = float(scaled[:, 2].min())
                area = area.symmetric_difference(shapely.make_valid(shapely.Polygon(scaled[:, :2])))
        parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
        if not parts:
            yield Unread(layer, place, "encloses no area", True)
        for part in parts:
            ring = np.array(part.exterior.coords)
            holes = shapely.union_all([shapely.Polygon(hole) for hole in part.interiors])
            yield Shape(layer, place, ring, True, bottom, 0.0, filled=True, holes=holes)


def _layer(entity: Any) -> str:
    """Return the layer of `entity`; "0" for kinds that ezdxf does not know."""
    known = entity.dxf.is_supported("layer")
    return str(entity.dxf.get("layer", "0")) if known else "0"


def _handle(entity: Any) -> str:
    """Return the handle of `entity`, or of the entity in a block that it is a copy of."""
    source = entity if entity.dxf.handle else entity.source_of_copy
    return str(getattr(getattr(source, "dxf", None), "handle", None) or "")


def _named(kind: str, entity: Any, within: str) -> str:
    name = f"{kind} {_handle(entity)}".rstrip()
    return f"{within}, {name}" if within else name


def _plain_polyline(entity: Any) -> NDArray[np.float64] | None:
    """Return the corners (N, 3) of a polyline without arcs in the plane of the floor, else None."""
    if entity.dxf.hasattr("extrusion") and tuple(entity.dxf.extrusion) != (0.0, 0.0, 1.0):
        return None
    points = np.array(entity.get_points("xyb"), float).reshape(-1, 3)
    if points[:, 2].any():
        return None
    points[:, 2] = entity.dxf.elevation
    return points
