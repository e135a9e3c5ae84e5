"""Floors from DXF drawings, sorted by layer; curves are flattened and blocks expanded.

Closed outlines bound areas, and so do lines, arcs and splines that meet. The area on the layer (or
in the group of layers) "boundary" bounds the floor, those on others are obstacles, called after
their layer or group. Elevation and thickness are their heights. Layers that are off or frozen, and
what is no shape (texts, dimensions, points), are left out.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from itertools import chain
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..checks import WIDEST
from ..files.fields import are_figures
from ..files.problems import FloorplanError, Problem, UserError
from ..files.reading import no_garbage, require_readable
from ..model import Obstacle
from ..plan import Floorplan
from .drawings import (
    BOUNDARY,
    OUTSIZED,
    Drawn,
    Name,
    Polyline,
    Shape,
    Unread,
    areas_in,
    boundary_problem,
    hatched,
    line,
    numbered,
    place_of,
)

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.math import Matrix44, Vec3


LARGEST_FILE = 64_000_000
"""Bytes: a hall that is drawn in all detail takes a few million."""

DAMAGED = (
    *(ArithmeticError, AttributeError, LookupError, RuntimeError, StopIteration),
    *(TypeError, ValueError),
)
"""Exceptions that ezdxf raises, besides its own, at a drawing that is damaged."""

TOLD = frozenset(("TEXT", "MTEXT", "POINT", "DIMENSION", "LEADER", "MULTILEADER", "TOLERANCE"))
"""Kinds of entities that need not be read: they are no shapes, and nothing hangs on them."""

_ENTITY, _HANDLE, _COMMENT = 0, 5, 999
"""Codes of tags: an entity begins, its handle, nothing."""


def open_drawing(path: Path) -> Drawing:
    """Return the drawing in the file at `path`; `FloorplanError` if there is none."""
    try:
        from ezdxf.filemanagement import readfile
        from ezdxf.lldxf.const import DXFError
    except ImportError:
        message = "DXF drawings can't be read without ezdxf; pip install 'floorwalker[floorplans]'"
        raise FloorplanError.of(path, message) from None
    require_readable(path, FloorplanError, LARGEST_FILE)
    try:
        with redirect_stdout(io.StringIO()):  # ezdxf prints some of its warnings
            try:
                return _without_texts(path)
            except (DXFError, OSError, *DAMAGED):
                return readfile(path)  # which says with the line where it is damaged
    except (DXFError, *DAMAGED) as why:
        message = f"is not a DXF drawing: {str(why) or 'it ends too early'}"
        raise FloorplanError.of(path, message) from None
    except OSError as why:
        # ezdxf says this without a system's reason of a file that it does not recognise.
        message = f"can't be read: {why.strerror}" if why.strerror else "is not a DXF drawing"
        raise FloorplanError.of(path, message) from None


class _Tag(NamedTuple):
    """A tag as ezdxf takes it from a reader of its own."""

    code: int
    value: str


def _without_texts(path: Path) -> Drawing:
    """Return the drawing in the text file at `path`; any exception if there is none."""
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
    """Return codes and values of the tags that are read: not those of texts that have a handle.

    Entities without handles are numbered as they are read, and a floor on top of the drawing may
    name these numbers.
    """
    if _COMMENT in codes:
        kept = [k for k, code in enumerate(codes) if code != _COMMENT]
        codes, values = [codes[k] for k in kept], [values[k] for k in kept]
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


SAGITTA = 1e-3
"""Metres. How far a drawn arc may be from the corners that stand for it."""

MOST_COPIES = 10_000
"""Copies of a block that one insert puts in rows and columns."""

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


class _Entity:
    """An entity of a drawing; what it is made of is worked out once, however often it stands."""

    def __init__(self, entity: Any) -> None:
        self.entity = entity
        self.kind: str = entity.dxftype()
        known = entity.dxf.is_supported("layer")  # not for kinds that ezdxf does not know
        self.layer = str(entity.dxf.get("layer", "0")) if known else "0"

    @cached_property
    def handle(self) -> str:
        """Its handle, or that of the entity in a block that it is a copy of."""
        entity = self.entity
        source = entity if entity.dxf.handle else entity.source_of_copy
        return str(getattr(getattr(source, "dxf", None), "handle", None) or "")

    @property
    def closed(self) -> bool:
        """Whether it is drawn as a closed line, wherever its ends are."""
        if self.kind in ("LWPOLYLINE", "POLYLINE"):
            return bool(self.entity.is_closed)
        return self.kind in ("CIRCLE", "SOLID", "TRACE", "3DFACE")

    @property
    def thickness(self) -> float:
        """How high it is drawn, in units of the drawing."""
        dxf = self.entity.dxf
        return float(dxf.get("thickness", 0.0)) if dxf.is_supported("thickness") else 0.0

    @cached_property
    def straight(self) -> NDArray[np.float64] | None:
        """Corners (N, 3) of a line, or of a level polyline of lines only; None of others."""
        if self.kind not in STRAIGHT:
            return None
        dxf = self.entity.dxf
        if self.kind == "LINE":
            return np.array((dxf.start.xyz, dxf.end.xyz))
        if dxf.hasattr("extrusion") and tuple(dxf.extrusion) != (0.0, 0.0, 1.0):
            return None
        # x, y and bulge; where any of these is not 0 the side is an arc.
        points = np.array(self.entity.get_points("xyb"), float).reshape(-1, 3)
        if len(points) < 2 or points[:, 2].any():
            return None
        points[:, 2] = dxf.elevation
        return points

    @cached_property
    def steps(self) -> list[tuple[Matrix44, NDArray[np.float64]]]:
        """The transforms, also as (4, 4), that put the block of an insert into its place."""
        insert = self.entity
        several = insert.multi_insert() if insert.mcount > 1 else (insert,)
        steps = [one.matrix44() for one in several]
        return [(step, np.array([*step]).reshape(4, 4)) for step in steps]


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

    def named(self, one: _Entity) -> str:
        """Return the name of an entity in the block."""
        name = f"{one.kind} {one.handle}".rstrip()
        return f"{self.within}, {name}" if self.within else name

    def block(
        self, name: str, layer: str, within: str, step: Matrix44, matrix: NDArray[np.float64]
    ) -> _Inserted:
        """Return the block of this name, which `step`, the `matrix` (4, 4), puts into this one."""
        at = matrix if self.at is None else matrix @ self.at
        blocks = self.blocks | {name.casefold()}
        return _Inserted(layer, within, blocks, (step, *self.steps), at)


_MODEL_SPACE = _Inserted()
_XYZ = attrgetter("xyz")


class Reader:
    """Reads the shapes of a drawing with a unit of `metre` metres.

    `layers` are those with something on them that is not switched off.
    """

    def __init__(self, drawing: Drawing, metre: float, drawn: Drawn) -> None:
        self.layers: set[str] = set()
        self._drawing = drawing
        self._metre = metre
        self._drawn = drawn
        self._blocks: dict[str, list[_Entity]] = {}
        self.group_of = lru_cache(None)(drawn.group_of)
        """The name of the group of a layer, None if it is in none."""
        hidden = {
            layer.dxf.name.casefold(): (layer.is_off() or layer.is_frozen(), layer.is_frozen())
            for layer in drawing.layers
        }
        self._hidden = lru_cache(None)(lambda layer: hidden.get(layer.casefold(), (False, False)))

    def shapes(self) -> Iterator[Shape]:
        """Yield the shapes of the model space, and the entities that are not read."""
        return self._read(map(_Entity, self._drawing.modelspace()), _MODEL_SPACE)

    def _read(self, entities: Iterable[_Entity], block: _Inserted) -> Iterator[Shape]:
        for one in entities:
            kind, layer = one.kind, one.layer
            if block.layer is not None and layer == "0":
                layer = block.layer  # so AutoCAD draws what a block has on the layer 0
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
            elif block.at is None:
                yield from self._traced(one, layer, name)
            elif one.straight is not None and not one.thickness:
                # ezdxf's matrices act on rows from the right, with the translation in the last row.
                corners = one.straight @ block.at[:3, :3] + block.at[3, :3]
                yield line(layer, name, corners * self._metre, one.closed, 0.0)
            else:
                yield from self._put(one.entity, layer, name, block)

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
        for step, matrix in one.steps:
            inserted = within.block(name, layer, place, step, matrix)
            yield from self._read(self._blocks[name], inserted)

    def _put(self, entity: Any, layer: str, name: Name, block: _Inserted) -> Iterator[Shape]:
        """Yield what a curve of a block is where the block stands: drawn out at its size there."""
        from ezdxf.transform import copies

        parts = [entity]
        # One after the other: each keeps right angles, together they may not.
        for step in block.steps:
            try:
                log, parts = copies(parts, step)
                why = log[0].error.name.lower().replace("_", " ") if len(log) else ""
            except ValueError as damage:
                why = str(damage)
            if why:
                yield Unread(layer, name, f"can't be put where its block is: {why}")
                return
        for part in parts:
            yield from self._traced(_Entity(part), layer, name)

    def _traced(self, one: _Entity, layer: str, name: Name) -> Iterator[Shape]:
        if one.kind in PARTED:
            for part in one.entity.virtual_entities():
                yield self._line(_Entity(part), layer, name)
        elif one.kind in HATCHES:
            yield from self._hatch(one.entity, layer, name)
        else:
            yield self._line(one, layer, name)

    def _line(self, one: _Entity, layer: str, name: Name) -> Shape:
        kind, entity = one.kind, one.entity
        refuse = partial(Unread, layer, name)
        if kind not in LINES | OUTLINES:
            return refuse(why="can't be read as an outline: draw polylines, lines or circles")
        if kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline):
            return refuse(why="is a mesh; only plain outlines can be read")
        corners = one.straight
        if corners is None:
            from ezdxf.path import make_path

            path = make_path(entity)
            if why := self._unfit(path):
                return refuse(why=why)
            corners = self._flat(path)
        if len(corners) < 2:
            return refuse(why="has no length")
        metre = self._metre
        return line(layer, name, corners * metre, one.closed, one.thickness * metre)

    def _hatch(self, hatch: Any, layer: str, name: Name) -> Iterator[Shape]:
        if self._drawn.groups is None:
            why = "hatches are read only from layers that `layers` names"
            yield Unread(layer, name, why, False)
            return
        from ezdxf.path import from_hatch

        paths = [*from_hatch(hatch)]
        if why := next(filter(None, map(self._unfit, paths)), ""):
            yield Unread(layer, name, why)
            return
        outlines = [outline * self._metre for outline in map(self._flat, paths)]
        yield from hatched(layer, name, [one for one in outlines if len(one) >= 3])

    def _unfit(self, path: Any) -> str:
        """Return why a path of ezdxf's can't be drawn out, which takes for ever at any size.

        A curve stays within its control points.
        """
        points = map(_XYZ, path.control_vertices())
        places = np.fromiter(chain.from_iterable(points), float).reshape(-1, 3) * self._metre
        if not are_figures(places).all():
            return OUTSIZED
        if len(places) and np.ptp(places, axis=0).max() > WIDEST:
            return f"is more than {WIDEST:,.0f} m long"
        return ""

    def _flat(self, path: Any) -> NDArray[np.float64]:
        """Return the corners (N, 3) that stand for a path of ezdxf's, in units of the drawing."""
        # ezdxf flattens arcs, bulges and splines to within this distance.
        corners: Iterable[Vec3] = path.flattening(SAGITTA / self._metre)
        return np.fromiter(chain.from_iterable(map(_XYZ, corners)), float).reshape(-1, 3)


@no_garbage()
def load_dxf(path: Path, drawn: Drawn) -> Floorplan:
    """Return the floorplan in the DXF file at `path`; `FloorplanError` lists all its problems."""
    file = str(path)
    drawing = open_drawing(path)
    notices: list[Problem] = []
    metre = _metre(drawing, drawn, file, notices)
    reader = Reader(drawing, metre, drawn)
    shapes: dict[str, list[Polyline]] = {}
    problems: list[Problem] = []
    try:
        with np.errstate(all="ignore"):  # figures that nothing comes of are refused
            for found in reader.shapes():
                if isinstance(found, Polyline):
                    shapes.setdefault(str(reader.group_of(found.layer)), []).append(found)
                else:
                    to = problems if found.wanted else notices
                    to.append(Problem(found.why, place_of(found)))
    except DAMAGED as why:
        raise FloorplanError.of(path, f"has a damaged entity: {why}") from None
    areas: list[Obstacle] = []
    for name, held in shapes.items():
        for area in areas_in(name, held, drawn):
            if isinstance(area, Problem):
                problems.append(area)
            else:
                areas.append(area)
    problems += drawn.unmatched(reader.layers)
    bounding = [area for area in areas if area.name == BOUNDARY]
    if drawn.boundary is None and len(bounding) != 1 and not problems:
        problems.append(boundary_problem(len(bounding), areas, drawn))
    if problems:
        raise FloorplanError(file, problems)
    return Floorplan(
        name=path.stem,
        source=f"{path.name} (DXF)",
        boundary=bounding[0].footprint if drawn.boundary is None else drawn.boundary,
        obstacles=numbered([area for area in areas if area.name != BOUNDARY]),
        notices=tuple(notices),
    )


def _metre(drawing: Drawing, drawn: Drawn, file: str, notices: list[Problem]) -> float:
    """Return the length of a unit of the drawing in metres; notice where there is a doubt."""
    from ezdxf.enums import InsertUnits
    from ezdxf.units import conversion_factor

    try:
        unit = InsertUnits(drawing.units)
        named = unit != InsertUnits.Unitless
        own = float(conversion_factor(unit, InsertUnits.Meters)) if named else 1.0
    except (ValueError, TypeError):
        if drawn.metre is not None:
            return drawn.metre
        message = f"its unit ($INSUNITS = {drawing.units}) is not known; use metres"
        raise FloorplanError.of(file, message) from None
    if drawn.metre is None:
        if not named:
            message = "the drawing gives no unit ($INSUNITS), metres are assumed"
            notices.append(Problem(f"{message}; a floor on top of it can give `units`"))
        return own
    if named and abs(own - drawn.metre) > 1e-9:
        message = f"the drawing gives {unit.name.lower()} as its unit ($INSUNITS)"
        notices.append(Problem(f"{message}; the `units` of the floor on top of it count"))
    return drawn.metre
