"""Walks along corners in plain numbers: bends, the speeds at them, and braking on the path.

Speeds follow from a backward and a forward pass over the corners, as in time-optimal path tracking
(J. E. Bobrow, S. Dubowsky and J. S. Gibson, "Time-optimal control of robotic manipulators along
specified paths", International Journal of Robotics Research 4, 1985). A walk among others has a
top speed on each segment, and one acceleration for speeding up and slowing down.
"""

from __future__ import annotations

from math import dist, hypot, pow
from typing import TYPE_CHECKING, TypeGuard

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import atan2, cos, isfinite, pi, sin, sqrt, tan

    from .cubics import *
    from .discs import Swath

# `dist`, `hypot` and `pow` are Python's, because those of compilers may have other last bits.

NOWHERE = 1e-9
"""Length in metres (or angle in radians) of the shortest segments and moves."""

DEVIATION = 0.05
"""Maximum distance of a rounded corner from the path in metres."""

HAIR = 1e-6
"""Share of the acceleration in reserve, so that rounding cannot make a profile infeasible."""

_STANDS: float = 1e-9  # m/s; slower people count as standing
_STRAIGHT: float = 1e-6  # sine of the largest turn that counts as none
_PHASES: cython.Py_ssize_t = 4  # maximum number of phases per segment
_NO_SPEED: float = 1e-9  # m/s
_ROUNDING: float = 1e-12  # of a cosine

_NOWHERE: float = NOWHERE
_DEVIATION: float = DEVIATION
_HAIR: float = HAIR

Corner = tuple[float, float]


def bends(points: list[Corner]) -> list[Corner] | None:
    """Return `points` without repetitions and without points on a straight line between others.

    None if a point is not a tuple of two finite floats.
    """
    corners: list[Corner] = []
    n: cython.Py_ssize_t = 0
    for point in points:
        if not is_place(point):
            return None
        if n > 0 and dist(corners[n - 1], point) < _NOWHERE:
            continue
        if n > 1 and _straight(corners[n - 2], corners[n - 1], point):
            corners.pop()
            n -= 1
        corners.append(point)
        n += 1
    return corners


def distinct(points: list[Corner], least: float) -> list[Corner]:
    """Return `points` without those within `least` metres of the previous or of the last one."""
    goal: Corner = points[len(points) - 1]
    apart: list[Corner] = [points[0]]
    k: cython.Py_ssize_t
    for k in range(1, len(points) - 1):
        if _apart(apart[len(apart) - 1], points[k], least) and _apart(points[k], goal, least):
            apart.append(points[k])
    apart.append(goal)
    return apart


def _apart(a: Corner, b: Corner, least: float) -> bool:
    dx: float = b[0] - a[0]
    dy: float = b[1] - a[1]
    return norm(dx, dy) > least


def is_place(point: object) -> TypeGuard[Corner]:
    """Return whether `point` is a tuple of two finite floats."""
    if not isinstance(point, tuple) or len(point) != 2:
        return False
    x, y = point
    return x.__class__ is y.__class__ is float and bool(isfinite(x)) and bool(isfinite(y))


def _straight(a: Corner, b: Corner, c: Corner) -> bool:
    ux: float = b[0] - a[0]
    uy: float = b[1] - a[1]
    wx: float = c[0] - b[0]
    wy: float = c[1] - b[1]
    return ux * wx + uy * wy > 0 and abs(ux * wy - uy * wx) < 1e-9 * hypot(wx, wy)


def lengths_of(corners: list[Corner]) -> list[float]:
    """Return the lengths of the segments between corners (metres)."""
    return [dist(corners[k], corners[k + 1]) for k in range(len(corners) - 1)]


def corner_speed(before: Corner, corner: Corner, after: Corner, acceleration: float) -> float:
    """Return the speed (m/s) of a turn; see `navigation.corner_speed`."""
    ux: float = corner[0] - before[0]
    uy: float = corner[1] - before[1]
    wx: float = after[0] - corner[0]
    wy: float = after[1] - corner[1]
    turn: float = abs(atan2(ux * wy - uy * wx, ux * wx + uy * wy))
    if turn < 1e-9:
        return INFINITY
    if turn > pi - 1e-9:
        return 0.0
    # An arc of radius r inside a corner leaves it by r (1 / cos(turn / 2) − 1), and uses r
    # tan(turn / 2) of both segments. 1 − cos φ is 2 sin² (φ / 2), which is exact for small φ.
    by_deviation: float = _DEVIATION * cos(turn / 2) / (2 * pow(sin(turn / 4), 2))
    by_length: float = min(hypot(ux, uy), hypot(wx, wy)) / 2 / tan(turn / 2)
    return sqrt(acceleration * min(by_deviation, by_length))


def corner_speeds(
    corners: list[Corner],
    lengths: list[float],
    max_speed: float,
    acceleration: float,
    initial_speed: float,
) -> list[float]:
    """Return the speed at every corner, within its own limit and the acceleration.

    The list is empty if the path is too short to slow down from the initial speed.
    """
    speeds: list[float] = [initial_speed]
    k: cython.Py_ssize_t
    for k in range(1, len(lengths)):
        top: float = corner_speed(corners[k - 1], corners[k], corners[k + 1], acceleration)
        speeds.append(min(top, max_speed))
    speeds.append(0.0)
    gain: float = 2 * acceleration * (1 - _HAIR)
    # Backwards for slowing down, forwards for speeding up. Together they give the maximum.
    for k in range(len(lengths) - 1, -1, -1):
        speeds[k] = min(speeds[k], sqrt(pow(speeds[k + 1], 2) + gain * lengths[k]))
    if speeds[0] < initial_speed * (1 - _HAIR):
        return []
    for k in range(len(lengths)):
        speeds[k + 1] = min(speeds[k + 1], sqrt(pow(speeds[k], 2) + gain * lengths[k]))
    return speeds


def ends_after(table: Numbers, t: float) -> list[Corner]:
    """Return the ends of those pieces of a motion that last beyond `t` (s)."""
    ends: list[Corner] = []
    k: cython.Py_ssize_t
    for k in range(pose_count(table)):
        piece: PosePiece = poses(table)[k]
        u: float = piece.end - piece.begin
        if piece.end > t:
            ends.append((value(piece.x, u), value(piece.y, u)))
    return ends


def leg_before(
    table: Numbers, since: float, t: float, before_x: float, before_y: float
) -> tuple[float, float]:
    """Return the straight segment on which a body arrives at its place at `t` (s): see `leg_to`."""
    row: PosePieces = poses(table)
    k: cython.Py_ssize_t = pose_count(table) - 1
    while k > 0 and row[k].begin >= t:
        k -= 1
    piece: PosePiece = row[k]
    if not piece.begin < t <= piece.end:
        return 0.0, 0.0
    u: float = t - piece.begin
    vx: float = slope(piece.x, u)
    vy: float = slope(piece.y, u)
    speed: float = norm(vx, vy)
    if speed < _STANDS:
        return 0.0, 0.0
    end: float = t
    length: float = 0.0
    while k >= 0 and end > since and length < speed:
        piece = row[k]
        begin: float = piece.begin if piece.begin > since else since
        u = (begin + end) / 2 - piece.begin
        if not _same_way(slope(piece.x, u), slope(piece.y, u), vx, vy):
            break
        u = begin - piece.begin
        w: float = end - piece.begin
        length += norm(gain(piece.x, w) - gain(piece.x, u), gain(piece.y, w) - gain(piece.y, u))
        end = begin
        k -= 1
    if end <= since and _same_way(before_x, before_y, vx, vy):
        length += norm(before_x, before_y)
    share: float = min(length / speed, 1.0)
    return share * vx, share * vy


def _same_way(wx: float, wy: float, vx: float, vy: float) -> bool:
    """Return whether two velocities, or segments, have the same direction."""
    along: float = wx * vx + wy * vy
    return along > 0.0 and abs(wx * vy - wy * vx) <= _STRAIGHT * along


def first_metres(corners: list[Corner], length: float) -> list[Corner]:
    """Return the first `length` metres of a path, or all of it, with an error of at most 1e-9 m."""
    path: list[Corner] = [corners[0]]
    k: cython.Py_ssize_t
    for k in range(len(corners) - 1):
        a: Corner = corners[k]
        b: Corner = corners[k + 1]
        leg: float = dist(a, b)
        if leg >= length + _NOWHERE:
            share: float = length / leg
            path.append((a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
            break
        path.append(b)
        length -= leg
        if length <= _NOWHERE:
            break
    return path


def braking(corners: list[Corner], lengths: list[float], speed: float, start: float) -> Numbers:
    """Return the table of braking from `speed` (m/s) at `start` (s) along all of `corners`.

    The deceleration is constant, and the end is at rest. `lengths` are those of the segments.
    """
    table: Numbers = pose_room(len(lengths))
    left: float = sum(lengths)
    # From the rounded lengths, so that the motion ends exactly at the last corner.
    deceleration: float = pow(speed, 2) / (2 * left)
    k: cython.Py_ssize_t
    for k in range(len(lengths)):
        a: Corner = corners[k]
        b: Corner = corners[k + 1]
        dx: float = b[0] - a[0]
        dy: float = b[1] - a[1]
        left -= lengths[k]
        slower: float = 0.0
        if k + 1 < len(lengths):
            slower = sqrt(max(2 * deceleration * left, 0.0))
        end: float = start + (speed - slower) / deceleration
        way: Cubic = Cubic(0.0, speed, -deceleration / 2, 0.0)
        poses(table)[k] = PosePiece(
            start,
            end,
            along(a[0], dx / lengths[k], way),
            along(a[1], dy / lengths[k], way),
            constant(atan2(dy, dx)),
        )
        start = end
        speed = slower
    return table


def walk_swath(
    corners: Numbers,
    tops: Numbers,
    since: float,
    start: float,
    initial_speed: float,
    max_speed: float,
    acceleration: float,
    lead: Swath | None,
) -> Swath | None:
    """Return the swath of a walk along `corners` (x and y of each in turn) from `start` on.

    It begins at `initial_speed` along the first segment, and ends at rest. `tops` has the top speed
    of each segment, or one for all, which is reached as soon as `acceleration` permits. Corners are
    those of `walk`, and the speed is at most `max_speed`. The walk follows that of a `lead` and a
    rest, or a rest from `since` on. The result is None if the person cannot come to rest or slow
    down enough for a corner.
    """
    pace: SpeedLimits = SpeedLimits(start, initial_speed, max_speed, acceleration)
    before: Numbers = room(0)
    box: BoundingBox = box_around(corners, position_count(corners))
    if lead is not None:
        before = lead.walk
        since = lead.rests
        box = united(box, boxes_of(lead.box)[0])
    table: Numbers = room(0)
    count: cython.Py_ssize_t = position_count(corners)
    pieces: cython.Py_ssize_t = draw_walk(corners, count, tops, pace, since, before, table)
    if pieces == 0:
        return None
    planar_cut(table, pieces)
    return Swath(table, row_of_box(box))


def draw_walk(
    corners: Numbers,
    count: cython.Py_ssize_t,
    tops: Numbers,
    pace: SpeedLimits,
    since: float,
    lead: Numbers,
    table: Numbers,
) -> cython.Py_ssize_t:
    """Write the walk along the first `count` corners. Return its number of pieces, or 0.

    They are at the beginning of `table`, which grows if it is too short. `lead` is the table of a
    walk without its final rest. See `walk_swath` for the other arguments.
    """
    k: cython.Py_ssize_t = planar_count(lead)
    # The segments are stored behind the maximum number of pieces.
    leg: PathLegs = planar_space(table, k + _PHASES * count + 2, count + 1)
    row: PlanarPieces = planar(table)
    corner: Positions = positions_of(corners)
    legs: cython.Py_ssize_t = _plan(corner, count, tops, pace, leg)
    if legs == 0:
        return 0
    planar_put(table, lead)
    if since < pace.start:
        row[k] = PlanarPiece(since, pace.start, constant(corner[0].x), constant(corner[0].y))
        k += 1
    row[k] = rest_piece(pace.start, corner[0].x, corner[0].y)
    u: float = pace.initial_speed
    i: cython.Py_ssize_t
    for i in range(legs):
        # Forwards: no faster than the acceleration permits.
        w: float = min(leg[i + 1].first, sqrt(u * u + 2 * pace.acceleration * leg[i].length))
        k = _walk(row, k, leg[i], u, w, pace.acceleration)
        u = w
    row[k] = rest_piece(row[k].begin, corner[count - 1].x, corner[count - 1].y)
    return k + 1


def _plan(
    corner: Positions, count: cython.Py_ssize_t, tops: Numbers, pace: SpeedLimits, leg: PathLegs
) -> cython.Py_ssize_t:
    """Write the segments of a walk. Return their number, or 0 if there is no such walk."""
    top_of: Doubles = at(tops)
    each: cython.Py_ssize_t = 1 if len(tops) > 1 else 0
    gain: float = 2 * pace.acceleration
    walked: float = 0.0
    c: float = 0.0
    s: float = 0.0
    length: float = 0.0
    top: float = INFINITY
    legs: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    for k in range(count - 1):
        here: Position = corner[k]
        dx: float = corner[k + 1].x - here.x
        dy: float = corner[k + 1].y - here.y
        before: float = length
        length = norm(dx, dy)
        if length <= _NOWHERE:
            length = before
            continue
        dx /= length
        dy /= length
        cap: float = pace.initial_speed
        if legs > 0:
            # If the initial speed is too high for a segment, the limit there is the speed that
            # remains after braking.
            square: float = pace.initial_speed * pace.initial_speed - gain * walked
            slowed: float = sqrt(max(square, 0.0))
            cap = min(pace.max_speed, max(min(top, top_of[k * each]), slowed))
            shorter: float = before if before < length else length
            cap = min(cap, bend_speed(c * dx + s * dy, shorter, pace.acceleration))
        c = dx
        s = dy
        top = top_of[k * each]
        walked += length
        leg[legs] = PathLeg(here.x, here.y, c, s, length, top, cap)
        legs += 1
    if legs == 0:
        return 0
    # Backwards: slow enough for all limits that follow.
    after: float = 0.0
    leg[legs] = PathLeg(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, after)
    for k in range(legs - 1, -1, -1):
        p: PathLeg = leg[k]
        after = min(p.first, sqrt(after * after + gain * p.length))
        leg[k] = PathLeg(p.x, p.y, p.c, p.s, p.length, p.top, after)
    return legs if after >= pace.initial_speed - _NO_SPEED else 0


def turned(table: Numbers, heading: float) -> Numbers:
    """Return the motion along a walk, turned to its direction, without the final rest.

    Its rotation is `heading` (radians) until it moves.
    """
    count: cython.Py_ssize_t = planar_count(table) - 1
    motion: Numbers = pose_room(count)
    k: cython.Py_ssize_t
    for k in range(count):
        p: PlanarPiece = planar(table)[k]
        if p.x.v != 0.0 or p.y.v != 0.0:
            heading = atan2(p.y.v, p.x.v)
        elif p.x.a != 0.0 or p.y.a != 0.0:
            heading = atan2(p.y.a, p.x.a)
        poses(motion)[k] = PosePiece(p.begin, p.end, p.x, p.y, constant(heading))
    return motion


def bend_speed(cosine: float, shorter: float, acceleration: float) -> float:
    """Return the speed (m/s) of a turn between two segments, the shorter of `shorter` metres.

    `cosine` is that of the turn. This is `corner_speed` without an angle: cos(φ / 2) and tan(φ / 2)
    follow from cos φ, which the caller has. The last bits differ.
    """
    half: float = sqrt(max((1 + cosine) / 2, 0.0))  # the cosine of half the turn
    if half > 1.0 - _ROUNDING:
        return INFINITY
    by_deviation: float = _DEVIATION * half / (1 - half)
    by_length: float = shorter / 2 * half / sqrt(1 - half * half)
    return sqrt(acceleration * min(by_deviation, by_length))


def _walk(
    row: PlanarPieces,
    k: cython.Py_ssize_t,
    leg: PathLeg,
    u: float,
    w: float,
    acceleration: float,
) -> cython.Py_ssize_t:
    """Add the pieces of a segment from speed `u` to `w` from row k on. Return the next row.

    The begin of the next row is always set.
    """
    top: float = leg.top
    walked: float = 0.0
    level: float = max(top, w)
    if u > level:  # still slowing down
        duration: float = (u - level) / acceleration
        k = _add_phase(row, k, leg, duration, Cubic(walked, u, -acceleration / 2, 0.0))
        walked = duration * (u + level) / 2
        u = level
    if level > top:
        top = level
    left: float = max(leg.length - walked, 0.0)
    # Up to the peak and down again on the rest of the segment, if the top speed permits.
    peak: float = sqrt(max((2 * acceleration * left + u * u + w * w) / 2, 0.0))
    peak = max(max(min(peak, top), u), w)
    rising: float = (peak - u) / acceleration
    falling: float = (peak - w) / acceleration
    k = _add_phase(row, k, leg, rising, Cubic(walked, u, acceleration / 2, 0.0))
    walked += rising * (u + peak) / 2
    slowing: float = falling * (peak + w) / 2
    cruise: float = max((leg.length - walked - slowing) / peak, 0.0)
    k = _add_phase(row, k, leg, cruise, Cubic(walked, peak, 0.0, 0.0))
    walked += cruise * peak
    return _add_phase(row, k, leg, falling, Cubic(walked, peak, -acceleration / 2, 0.0))


def _add_phase(
    row: PlanarPieces, k: cython.Py_ssize_t, leg: PathLeg, duration: float, way: Cubic
) -> cython.Py_ssize_t:
    """Add a phase as the k-th piece if its duration is positive. Return the next row.

    `way` is the distance along the segment. See `_walk`.
    """
    begin: float = row[k].begin
    end: float = begin + duration
    if end <= begin:
        return k
    x: Cubic = Cubic(leg.x + way.p * leg.c, way.v * leg.c, way.a * leg.c, 0.0)
    y: Cubic = Cubic(leg.y + way.p * leg.s, way.v * leg.s, way.a * leg.s, 0.0)
    row[k] = PlanarPiece(begin, end, x, y)
    row[k + 1] = rest_piece(end, 0.0, 0.0)
    return k + 1
