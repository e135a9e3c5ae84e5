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
    from ezdxf.math import Matrix44

SAGITTA = 1e-3
"""Metres. How far a drawn arc may be from the corners that stand for it."""

TOUCHING = 1e-9
"""Metres. Ends of an outline that are nearer to each other are one corner: arcs end by rounding."""

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
STRAIGHT = frozenset(("LINE", "LWPOLYLINE"))
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


@dataclass(frozen=True)
class _Inserted:
    """A block that is read where it stands, inside others: `blocks` are their names.

    What it has on the layer 0 is on `layer`, `within` names its place. `steps` put it there, the
    innermost first, and so does the matrix `at` (4, 4) at once; None for the model space.
    """

    layer: str | None = None
    within: str = ""
    blocks: frozenset[str] = frozenset()
    steps: tuple[Matrix44, ...] = ()
    at: NDArray[np.float64] | None = None

    def named(self, kind: str, entity: Any) -> str:
        """Return the name of an entity in the block."""
        name = f"{kind} {_handle(entity)}".rstrip()
        return f"{self.within}, {name}" if self.within else name

    def block(self, name: str, layer: str, within: str, step: Matrix44) -> _Inserted:
        """Return the block of this name, which `step` puts into this one."""
        matrix = np.array([*step]).reshape(4, 4)
        at = matrix if self.at is None else matrix @ self.at
        blocks = self.blocks | {name.casefold()}
        return _Inserted(layer, within, blocks, (step, *self.steps), at)


_MODEL_SPACE = _Inserted()


class Reader:
    """Reads the shapes of a drawing with a unit of `metre` metres.

    `layers` are those with something on them that is not switched off.
    """

    def __init__(self, drawing: Drawing, metre: float, drawn: Drawn) -> None:
        self.layers: set[str] = set()
        self._drawing = drawing
        self._metre = metre
        self._drawn = drawn
        self._corners: dict[str, NDArray[np.float64] | None] = {}
        self.group_of = lru_cache(None)(drawn.group_of)
        """The name of the group of a layer, None if it is in none."""
        self._hidden = {
            layer.dxf.name.casefold(): (layer.is_off() or layer.is_frozen(), layer.is_frozen())
            for layer in drawing.layers
        }

    def shapes(self) -> Iterator[Shape | Unread]:
        """Yield the shapes of the model space, and what is left out of it."""
        yield from self._read(self._drawing.modelspace(), _MODEL_SPACE)

    def _read(self, entities: Iterable[Any], block: _Inserted) -> Iterator[Shape | Unread]:
        for entity in entities:
            kind = entity.dxftype()
            layer = _layer(entity)
            if block.layer is not None and layer == "0":
                layer = block.layer  # so AutoCAD draws what a block has on the layer 0
            hidden, frozen = self._hidden.get(layer.casefold(), (False, False))
            if kind in SILENT or (frozen if kind == "INSERT" else hidden):
                continue
            if self._drawn.leave_out and _handle(entity) in self._drawn.leave_out:
                yield Unread(layer, block.named(kind, entity), "is left out as asked", False)
                continue
            if kind == "INSERT":
                yield from self._insert(entity, layer, block)
                continue
            self.layers.add(layer)
            place = partial(block.named, kind, entity)
            if self.group_of(layer) is None:
                yield Unread(layer, place(), "is on a layer that no group has", False)
            elif block.at is None:
                yield from self._drawn_as(entity, kind, layer, place())
            elif (corners := self._straight(entity, kind)) is not None:
                # ezdxf's matrices act on rows from the right, with the translation in the last row.
                corners = corners @ block.at[:3, :3] + block.at[3, :3]
                yield self._outline(entity, kind, layer, place(), corners)
            else:
                yield from self._put(entity, layer, place(), block)

    def _insert(self, insert: Any, layer: str, within: _Inserted) -> Iterator[Shape | Unread]:
        place = within.named("INSERT", insert)
        name = insert.dxf.get("name", "")
        block = insert.block()
        if block is None:
            yield Unread(layer, place, f"there is no block {name!r}", True)
            return
        if block.block is not None and block.block.is_xref:
            why = f"refers to another drawing ({name!r}); bind it into this one"
            yield Unread(layer, place, why, self.group_of(layer) is not None)
            return
        if name.casefold() in within.blocks:
            yield Unread(layer, place, f"the block {name!r} contains itself", True)
            return
        for one in insert.multi_insert() if insert.mcount > 1 else (insert,):
            inserted = within.block(name, layer, f"{place} ({name})", one.matrix44())
            yield from self._read(block, inserted)

    def _put(
        self, entity: Any, layer: str, place: str, block: _Inserted
    ) -> Iterator[Shape | Unread]:
        """Yield what a curve of a block is where the block stands: drawn out at its size there."""
        from ezdxf.transform import copies

        parts = [entity]
        for (
            step
        ) in block.steps:  # one after the other: each keeps right angles, together they may not
            try:
                log, parts = copies(parts, step)
                why = log[0].error.name.lower().replace("_", " ") if len(log) else ""
            except ValueError as damage:
                why = str(damage)
            if why:
                yield Unread(layer, place, f"can't be put where its block is: {why}", True)
                return
        for part in parts:
            yield from self._drawn_as(part, part.dxftype(), layer, place)

    def _drawn_as(self, entity: Any, kind: str, layer: str, place: str) -> Iterator[Shape | Unread]:
        if kind in PARTED:
            for part in entity.virtual_entities():
                yield self._shape(part, part.dxftype(), layer, place)
        elif kind in HATCHES:
            yield from self._hatch(entity, layer, place)
        else:
            yield self._shape(entity, kind, layer, place)

    def _straight(self, entity: Any, kind: str) -> NDArray[np.float64] | None:
        """Return the corners (N, 3) of a straight line of a block, in the units of the block."""
        handle = _handle(entity)
        if handle not in self._corners:
            thick = kind in STRAIGHT and entity.dxf.get("thickness", 0.0)
            self._corners[handle] = None if thick else _straight(entity, kind)
        return self._corners[handle]

    def _shape(self, entity: Any, kind: str, layer: str, place: str) -> Shape | Unread:
        refuse = partial(Unread, layer, place, wanted=True)
        if kind not in LINES | OUTLINES:
            return refuse(why="can't be read as an outline: draw polylines, lines or circles")
        if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
            return refuse(why="is a mesh; only plain outlines can be read")
        corners = _straight(entity, kind)
        if corners is None:
            from ezdxf import path

            outline = path.make_path(entity)
            if not len(outline):
                return refuse(why="has no length")
            # ezdxf flattens arcs, bulges and splines to within this distance, in units of the
            # drawing.
            flat = outline.flattening(SAGITTA / self._metre)
            corners = np.array([(v.x, v.y, v.z) for v in flat])
        return self._outline(entity, kind, layer, place, corners)

    def _outline(
        self, entity: Any, kind: str, layer: str, place: str, corners: NDArray[np.float64]
    ) -> Shape | Unread:
        """Return the line with these corners (N, 3), in units of the drawing."""
        refuse = partial(Unread, layer, place, wanted=True)
        corners = corners * self._metre
        if not np.isfinite(corners).all():
            return refuse(why="has coordinates that are not numbers")
        closed = kind in ("CIRCLE", "SOLID", "TRACE", "3DFACE")
        closed = closed or (kind in ("LWPOLYLINE", "POLYLINE") and entity.is_closed)
        if len(corners) > 3:
            closed = closed or bool((corners[0, :2] == corners[-1, :2]).all())
            if closed and (np.abs(corners[0, :2] - corners[-1, :2]) < TOUCHING).all():
                corners = corners[:-1]
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
                # Exclusive or of all boundaries is the even-odd rule, in whatever order they come.
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


def _straight(entity: Any, kind: str) -> NDArray[np.float64] | None:
    """Return the corners (N, 3) of a line, or of a level polyline without arcs; None of others."""
    if kind not in STRAIGHT:
        return None
    if kind == "LINE":
        return np.array([(v.x, v.y, v.z) for v in (entity.dxf.start, entity.dxf.end)])
    if entity.dxf.hasattr("extrusion") and tuple(entity.dxf.extrusion) != (0.0, 0.0, 1.0):
        return None
    # x, y and bulge; where any of these is not 0 the side is an arc.
    points = np.array(entity.get_points("xyb"), float).reshape(-1, 3)
    if points[:, 2].any():
        return None
    points[:, 2] = entity.dxf.elevation
    return points
