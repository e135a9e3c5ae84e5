"""Corners of entities of DXF drawings, within a distance of the drawn curve."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable, Iterator
from itertools import chain, groupby, pairwise
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from ..checks import WIDEST
from ..files.fields import LARGEST
from ..files.problems import UserError
from .drawings import OUTSIZED, wall

if TYPE_CHECKING:
    from ezdxf.math import BSpline

Floats = NDArray[np.float64]

SAGITTA = 1e-3
"""Metres. Maximum distance between a drawn curve and its corners."""

SPLINES = frozenset(("SPLINE", "HELIX"))
POLYLINES = frozenset(("LWPOLYLINE", "POLYLINE"))

_FRAME = 16
"""Flag of vertices that only control a spline and are not drawn."""

_QUARTER = 2.73e-4
"""Error of a cubic Bézier curve for a quarter of a circle, in radii."""

_AROUND = 12
"""Number of fit points added at both ends of a closed spline. The influence of each is a quarter
of that of the previous one."""

_MOST_CORNERS = 1_000_000

_ROUNDS = 12
"""Maximum number of refinements of a spline. Splines with gaps would need more."""

_XYZ = attrgetter("xyz")


def corners_of(entity: Any, distance: float) -> Floats:
    """Return the corners (N, 3) of an entity, within `distance` of it in units of the drawing.

    `UserError` if it is too large.
    """
    from ezdxf.path import make_path

    kind = entity.dxftype()
    if kind in SPLINES:
        return _spline(*_curve(entity), distance)
    if kind == "POLYLINE":
        entity.vertices[:] = [v for v in entity.vertices if not v.dxf.flags & _FRAME]
    return _drawn_out(make_path(entity, segments=_segments(entity, distance)), distance)


def _drawn_out(path: Any, distance: float) -> Floats:
    _require_size(path.control_vertices(), distance)
    return _array(path.flattening(distance))


def _array(points: Iterable[Any]) -> Floats:
    return np.fromiter(chain.from_iterable(map(_XYZ, points)), float).reshape(-1, 3)


def _require_size(points: Iterable[Any], distance: float) -> None:
    """Raise `UserError` if the control points of a curve are too far apart to be flattened."""
    places = _array(points) * (SAGITTA / distance)
    if not (np.abs(places) <= LARGEST).all():
        raise UserError(OUTSIZED)
    if len(places) and np.ptp(places, axis=0).max() > WIDEST:
        raise UserError(f"is more than {WIDEST:,.0f} m long")


def _segments(entity: Any, distance: float) -> int:
    """Return the number of segments in which ezdxf draws arcs. One is a curve per quarter."""
    kind, dxf = entity.dxftype(), entity.dxf
    angle, count = math.tau, 1
    if kind in ("CIRCLE", "ARC"):
        radius = abs(float(dxf.radius))
    elif kind == "ELLIPSE":
        radius = float(dxf.major_axis.magnitude)
    elif kind in POLYLINES and entity.has_arc:
        points = vertices(entity)
        chord = np.hypot(*(np.roll(points[:, :2], -1, axis=0) - points[:, :2]).T)
        bulge = np.maximum(np.abs(points[:, 4]), 1e-6)  # ezdxf draws flatter arcs as lines
        radii = chord * (1 + bulge**2) / (4 * bulge)
        radius = float(np.max(radii, where=points[:, 4] != 0, initial=0.0))
        angle, count = 4 * math.atan(bulge.max()), 3  # one curve per three segments
    else:
        return 1
    # The error falls with the sixth power of the angle, and may be a tenth of the distance.
    off = 10 * _QUARTER * radius / distance
    if not 1 < off < math.inf:
        return 1
    return count * math.ceil(float(off ** (1 / 6)) * angle / (math.pi / 2))


def _curve(spline: Any) -> tuple[BSpline, float, float]:
    """Return the curve of a spline, and the parameters between which it is drawn."""
    from ezdxf.math import Vec3, fit_points_to_cad_cv

    if not spline.closed or spline.control_point_count():
        return _domain(spline.construction_tool())
    points = np.array([Vec3(point).xyz for point in spline.fit_points])
    if (points[0] == points[-1]).all():
        points = points[:-1]
    # A curve with several turns is as smooth in its middle turn as at its ends.
    around = points[np.arange(-_AROUND, len(points) + _AROUND + 1) % len(points)]
    chords = np.linalg.norm(np.diff(around, axis=0), axis=1).cumsum()
    begin, end = (chords[[_AROUND - 1, _AROUND + len(points) - 1]] / chords[-1]).tolist()
    return fit_points_to_cad_cv(around.tolist()), begin, end


def _domain(curve: BSpline) -> tuple[BSpline, float, float]:
    """Return a curve and its domain, the knots between which all control points have influence."""
    knots = curve.knots()
    return curve, knots[curve.degree], knots[curve.count]


def _spline(curve: BSpline, begin: float, end: float, distance: float) -> Floats:
    """Return the corners (N, 3) of a curve between two parameters."""
    _require_size(curve.control_points, distance)
    times = np.unique([begin, *(knot for knot in curve.knots() if begin < knot < end), end])
    parts = np.full(len(times) - 1, 4)
    for _ in range(_ROUNDS):
        if parts.sum() > _MOST_CORNERS:
            raise UserError(f"takes more than {_MOST_CORNERS:,} corners")
        times = np.interp(np.arange(parts.sum() + 1), [0, *parts.cumsum()], times)
        corners = _array(curve.points(times))
        chords, thirds = np.diff(corners, axis=0), np.diff(times) / 3
        # Test at two parameters, because a curve may cross its chord in the middle.
        away = np.max(
            [
                _from_line(_array(curve.points(at)) - corners[:-1], chords)
                for at in (times[:-1] + thirds, times[1:] - thirds)
            ],
            axis=0,
        )
        # A parabola deviates by an eighth more in its middle.
        parts = np.ceil(np.sqrt(np.minimum(away * 9 / 8 / distance, 64.0**2))).astype(int)
        parts = np.maximum(parts, 1)
        if parts.max(initial=1) == 1:
            break
    return corners


def _from_line(points: Floats, along: Floats) -> Floats:
    """Return the distances of `points` (N, 3) from lines through 0 in directions `along`."""
    length = np.maximum((along**2).sum(axis=1), 1e-300)
    share = (points * along).sum(axis=1) / length
    distances: Floats = np.linalg.norm(points - share[:, None] * along, axis=1)
    return distances


def vertices(polyline: Any) -> Floats:
    """Return x, y, the widths at begin and end of the side, and the bulge of vertices (N, 5)."""
    dxf = polyline.dxf
    if polyline.dxftype() == "LWPOLYLINE":
        points = np.array(polyline.lwpoints.values, float).reshape(-1, 5)
        if not points[:, 2:4].any():
            points[:, 2:4] = dxf.get("const_width", 0.0)
        return points
    usual = {name: dxf.get(f"default_{name}", 0.0) for name in ("start_width", "end_width")}
    rows = [
        (
            *v.dxf.location.vec2,
            *(v.dxf.get(name, usual[name]) for name in usual),
            v.dxf.get("bulge", 0),
        )
        for v in polyline.vertices
        if not v.dxf.flags & _FRAME
    ]
    return np.array(rows, float).reshape(-1, 5)


def covered(polyline: Any, corners: Floats, distance: float) -> shapely.Geometry | None:
    """Return the area of a polyline with width, or None without width.

    `corners` (N, 3) are within `distance` of the polyline.
    """
    points = vertices(polyline)
    if not points[:, 2:4].any():
        return None
    if np.ptp(points[:, 2:4]) == 0:
        return wall(corners[:, :2], polyline.is_closed, points[0, 2], "flat")
    if polyline.is_closed:
        points = np.append(points, points[:1], axis=0)
    walls = []
    for (begin, end), sides in groupby(pairwise(points), lambda side: (*side[0][2:4],)):
        lines = [_side(polyline, *side, distance) for side in sides]
        if begin == end:
            walls.append(wall(np.concatenate(lines), False, begin, "flat"))
        else:
            walls += [_tapered(line, begin, end) for line in lines]
    return shapely.union_all(walls)


def _side(polyline: Any, start: Floats, stop: Floats, distance: float) -> Floats:
    """Return the corners (N, 2) of the side between two vertices of a polyline."""
    from ezdxf.entities.lwpolyline import LWPolyline

    extrusion = polyline.dxf.get("extrusion", (0, 0, 1))
    side = LWPolyline.new(dxfattribs={"extrusion": extrusion})
    side.append_points([(*end[[0, 1, 4]],) for end in (start, stop)], format="xyb")
    return corners_of(side, distance)[:, :2]


def _tapered(line: Floats, begin: float, end: float) -> shapely.Geometry:
    """Return the area of a line (N, 2) whose width changes linearly from `begin` to `end`."""
    along = np.gradient(line, axis=0) if len(line) > 1 else line
    across = np.column_stack([-along[:, 1], along[:, 0]])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    way = np.append(0, np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum())
    half = (np.interp(way, [0, way[-1]], [begin, end]) / 2)[:, None]
    outline = np.concatenate([line + half * across, (line - half * across)[::-1]])
    return shapely.make_valid(shapely.polygons(outline))


def hatch_outlines(hatch: Any, distance: float) -> list[Floats]:
    """Return the outlines (N, 3) of a hatch. See `corners_of`."""
    paths = copy.deepcopy(hatch.paths)
    paths.polyline_to_edge_paths()  # with bulges
    outlines: list[Floats] = []
    for path in paths:
        if hasattr(path, "edges"):
            outlines += _loops([_edge(edge, distance)[:, :2] for edge in path.edges], distance)
        else:
            outlines.append(np.array(path.vertices, float).reshape(-1, 3)[:, :2])
    ocs, height = hatch.ocs(), float(hatch.dxf.elevation.z)
    axes = np.array((ocs.ux.xyz, ocs.uy.xyz, ocs.uz.xyz))
    return [np.insert(outline, 2, height, axis=1) @ axes for outline in outlines]


def _loops(edges: list[Floats], distance: float) -> Iterator[Floats]:
    """Yield the outlines of successive edges (N, 2), each in either direction."""

    def gap(place: Floats, edge: Floats) -> float:
        return float(np.linalg.norm(edge[[0, -1]] - place, axis=1).min())

    edges = [edge for edge in edges if len(edge)]
    loop = np.empty((0, 2))
    for edge, following in zip(edges, [*edges[1:], *edges[-1:]], strict=True):
        if len(loop):
            turned = gap(loop[-1], edge[-1:]) < gap(loop[-1], edge[:1])
        else:
            turned = gap(edge[0], following) < gap(edge[-1], following)
        loop = np.append(loop, edge[::-1] if turned else edge, axis=0)
        if gap(loop[0], loop[-1:]) < 1e-3 * distance:
            yield loop
            loop = np.empty((0, 2))
    if len(loop):
        yield loop


def _edge(edge: Any, distance: float) -> Floats:
    """Return the corners (N, 3) of an edge of a hatch."""
    from ezdxf.entities.boundary_paths import ArcEdge, LineEdge, SplineEdge
    from ezdxf.math import Z_AXIS, ConstructionEllipse, Vec3, fit_points_to_cad_cv

    if isinstance(edge, LineEdge):
        return _array((Vec3(edge.start), Vec3(edge.end)))
    if isinstance(edge, SplineEdge):
        if edge.control_points:
            return _spline(*_domain(edge.construction_tool()), distance)
        tangents = [edge.start_tangent, edge.end_tangent]
        curve = fit_points_to_cad_cv(edge.fit_points, tangents if all(tangents) else None)
        return _spline(*_domain(curve), distance)
    if isinstance(edge, ArcEdge):
        ends = edge.start_angle, edge.end_angle
        ellipse = ConstructionEllipse.from_arc(Vec3(edge.center), edge.radius, Z_AXIS, *ends)
    else:
        ellipse = edge.construction_tool()
    _require_size((ellipse.center, ellipse.center + 2 * ellipse.major_axis), distance)
    return _array(ellipse.flattening(distance, 8))
