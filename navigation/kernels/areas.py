"""Areas that a polygon covers on a motion: unions of convex polygons that always contain it.

A polygon contains the moving one in every pose between two samples. On a straight line, it is the
hull of both ends. On a curve, samples are at most `TURN` apart, and corners are farther away by the
factor 1 / cos(`TURN` / 2), so that the chords between them contain their arcs. A turn on the spot
covers the polygon at both of its ends, and the sectors of the corners between them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import ceil, cos, sin

    from .convex import hull, is_apart
    from .cubics import *

TURN: float = 0.1  # radians; longest step between samples of a turn
_STEP: float = 0.1  # seconds; longest step between samples of a curve
_GROUP: float = 0.25  # radians, and metres; samples of a curve this close share a polygon
_SECTOR: float = 3.0  # radians; longest part of a turn whose sectors are convex
_STRAIGHT: float = 1e-6  # metres; tolerance of straight lines
_RESTS: float = 1e-6  # m/s and rad/s; slower machines are at rest


def end_of_part(table: Numbers, now: float, seconds: float) -> float:
    """Return the end (s) of the next part of a motion: at rest, or after `seconds`."""
    row: PosePieces = poses(table)
    k: cython.Py_ssize_t
    for k in range(pose_count(table)):
        piece: PosePiece = row[k]
        u: float = piece.end - piece.begin
        if piece.end > now + 1.5 * seconds:
            break
        if (
            piece.end > now
            and u > 0.0
            and abs(slope(piece.x, u)) < _RESTS
            and abs(slope(piece.y, u)) < _RESTS
            and abs(slope(piece.rotation, u)) < _RESTS
        ):
            return piece.end
    return min(now + seconds, end_of(table))


def poses_along(table: Numbers, begin: float, end: float) -> Numbers:
    """Return poses along a motion: ends of pieces, and samples of curves and turns."""
    row: PosePieces = poses(table)
    first: cython.Py_ssize_t = max(pose_at(table, begin), 0)
    sampled: Numbers = placement_room(1)
    here: PosePiece = row[first]
    u: float = elapsed(here.begin, here.end, begin)
    sample: Placements = placements_of(sampled)
    sample[0] = Placement(value(here.x, u), value(here.y, u), value(here.rotation, u))
    total: cython.Py_ssize_t = 1
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    for k in range(first, pose_count(table)):
        piece: PosePiece = row[k]
        a: float = max(piece.begin, begin)
        b: float = min(piece.end, end)
        if piece.begin >= end:
            break
        if a >= b:
            continue
        count: cython.Py_ssize_t = _samples(piece, b - a)
        placement_grow(sampled, total + count)
        sample = placements_of(sampled)
        for i in range(1, count + 1):
            u = a + (b - a) * i / count - piece.begin
            sample[total] = Placement(
                value(piece.x, u), value(piece.y, u), value(piece.rotation, u)
            )
            total += 1
    return sampled


def _samples(piece: PosePiece, seconds: float) -> cython.Py_ssize_t:
    """Return the number of samples of a piece: one on a line without a reversal."""
    x: Cubic = piece.x
    y: Cubic = piece.y
    r: Cubic = piece.rotation
    u: float = piece.end - piece.begin
    if r.v == 0.0 and r.a == 0.0 and r.j == 0.0:
        bend: float = max(
            max(abs(x.v * y.a - y.v * x.a) * u * u * u, abs(x.v * y.j - y.v * x.j) * u * u * u * u),
            abs(x.a * y.j - y.a * x.j) * u * u * u * u * u,
        )
        ahead: float = x.v * slope(x, u) + y.v * slope(y, u)
        if bend <= _STRAIGHT * _STRAIGHT and ahead >= -_STRAIGHT:
            return 1
    turned: float = abs(r.v) * u + abs(r.a) * u * u + abs(r.j) * u * u * u
    count: cython.Py_ssize_t = int(ceil(turned * seconds / max(u, 1e-9) / TURN))
    if not is_at_rest(x, y):
        count = max(count, int(ceil(seconds / _STEP)))
    return max(count, 1)


def is_on_line(sampled: Numbers) -> bool:
    """Return whether poses are on a line, or a turn on the spot."""
    last: cython.Py_ssize_t = placement_count(sampled) - 1
    return last < 2 or _share_line(sampled, 0, last) or _share_place(sampled, 0, last, INFINITY)


def swept(sampled: Numbers, corners: Numbers, wider: Numbers, turns: bool) -> list[Numbers]:
    """Return convex polygons that contain a polygon with these `corners` in poses and between.

    `wider` are the corners for curves. `turns` is true if the polygon contains its axis.
    """
    polygons: list[Numbers] = []
    pose: Placements = placements_of(sampled)
    count: cython.Py_ssize_t = placement_count(sampled)
    first: cython.Py_ssize_t = 0
    last: cython.Py_ssize_t
    k: cython.Py_ssize_t
    while first == 0 or first < count - 1:
        # Poses on a line, of a turn on the spot, or nearby on a curve share polygons.
        line: bool = count == 1 or pose[first].rotation == pose[first + 1].rotation
        turn: bool = not line and turns and _share_place(sampled, first, first + 1, _SECTOR)
        last = min(first + 1, count - 1)
        while last + 1 < count:
            if line:
                shared: bool = _share_line(sampled, first, last + 1)
            elif turn:
                shared = _share_place(sampled, first, last + 1, _SECTOR)
            else:
                shared = _are_near(pose[first], pose[last + 1])
            if not shared:
                break
            last += 1
        if turn:
            _add_sectors(polygons, sampled, first, last, corners, wider)
        else:
            points: Numbers = room(0)
            for k in range(first, last + 1):
                points.extend(_placed(pose[k], corners if line else wider))
            polygons.append(hull(points))
        if count == 1:
            break
        first = last
    return polygons


def _placed(pose: Placement, corners: Numbers) -> Numbers:
    """Return the corners of a polygon in a pose."""
    c: float = cos(pose.rotation)
    s: float = sin(pose.rotation)
    placed: Numbers = position_room(position_count(corners))
    k: cython.Py_ssize_t
    for k in range(position_count(corners)):
        p: Position = positions_of(corners)[k]
        positions_of(placed)[k] = Position(
            pose.x + (c * p.x - s * p.y), pose.y + (s * p.x + c * p.y)
        )
    return placed


def _add_sectors(
    polygons: list[Numbers],
    sampled: Numbers,
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    corners: Numbers,
    wider: Numbers,
) -> cython.int:
    """Add the polygons of a turn on the spot: at both of its ends, and of each corner."""
    pose: Placements = placements_of(sampled)
    least: cython.Py_ssize_t = first
    most: cython.Py_ssize_t = first
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    for k in range(first, last + 1):
        least = k if pose[k].rotation < pose[least].rotation else least
        most = k if pose[k].rotation > pose[most].rotation else most
    polygons.append(hull(_placed(pose[least], corners)))
    polygons.append(hull(_placed(pose[most], corners)))
    for i in range(position_count(wider)):
        points: Numbers = room(0)
        points.extend((pose[first].x, pose[first].y))
        for k in range(first, last + 1):
            corner: Position = positions_of(_placed(pose[k], wider))[i]
            points.extend((corner.x, corner.y))
        points = hull(points)
        if position_count(points) > 2:  # a corner hardly moves in a small turn
            polygons.append(points)
    return 0


def _are_near(a: Placement, b: Placement) -> bool:
    """Return whether two poses of a curve share a polygon."""
    near: bool = abs(b.x - a.x) + abs(b.y - a.y) < _GROUP
    return near and abs(b.rotation - a.rotation) < _GROUP


def _share_line(sampled: Numbers, first: cython.Py_ssize_t, last: cython.Py_ssize_t) -> bool:
    """Return whether poses have one rotation and lie on a line."""
    pose: Placements = placements_of(sampled)
    a: Placement = pose[first]
    dx: float = pose[last].x - a.x
    dy: float = pose[last].y - a.y
    length: float = norm(dx, dy)
    k: cython.Py_ssize_t
    for k in range(first, last + 1):
        if pose[k].rotation != a.rotation or (
            abs(dx * (pose[k].y - a.y) - dy * (pose[k].x - a.x)) > _STRAIGHT * length
        ):
            return False
    return True


def _share_place(
    sampled: Numbers, first: cython.Py_ssize_t, last: cython.Py_ssize_t, limit: float
) -> bool:
    """Return whether poses are a turn on the spot by less than `limit` radians."""
    pose: Placements = placements_of(sampled)
    low: float = pose[first].rotation
    high: float = pose[first].rotation
    k: cython.Py_ssize_t
    for k in range(first, last + 1):
        if abs(pose[k].x - pose[first].x) + abs(pose[k].y - pose[first].y) >= _STRAIGHT:
            return False
        low = min(low, pose[k].rotation)
        high = max(high, pose[k].rotation)
    return high - low < limit


class Polygons:
    """Union of convex polygons, counterclockwise."""

    def __init__(self, polygons: list[Numbers]) -> None:
        self.polygons = polygons
        self.bounds: Numbers = room(0)
        polygon: Numbers
        for polygon in polygons:
            self.bounds.extend(row_of_box(box_around(polygon, position_count(polygon))))

    def extent(self) -> tuple[float, float, float, float]:
        """Return minimum x and y, maximum x and y (metres)."""
        box: BoundingBox = boxes_of(self.bounds)[0]
        k: cython.Py_ssize_t
        for k in range(1, box_count(self.bounds)):
            box = united(box, boxes_of(self.bounds)[k])
        return box.low_x, box.low_y, box.high_x, box.high_y

    def meet(self, other: Polygons) -> bool:
        """Return whether both unions have a common point."""
        i: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for i in range(len(self.polygons)):
            for k in range(len(other.polygons)):
                if (
                    are_within(boxes_of(self.bounds)[i], boxes_of(other.bounds)[k], _STRAIGHT)
                    and not is_apart(self.polygons[i], other.polygons[k])
                    and not is_apart(other.polygons[k], self.polygons[i])
                ):
                    return True
        return False
