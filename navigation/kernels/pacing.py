"""Walks among others in plain numbers: the table of a walk along a polyline, in closed form.

On each leg the speed rises and falls at one acceleration, so that its phases follow from the speeds
at the corners: the forward and backward pass of D. Verscheure et al., "Time-optimal path tracking
for robots", IEEE Transactions on Automatic Control 54 (2009), for a bound on the acceleration along
the path alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .walks import DEVIATION, NOWHERE

if not cython.compiled:
    from math import atan2, sqrt

    from .cubics import *
    from .discs import Swath

_PHASES: cython.Py_ssize_t = 4  # of a leg, at most
_SHORT: float = NOWHERE
_DEVIATION: float = DEVIATION
_HAIR: float = 1e-9  # m/s
_ROUNDING: float = 1e-12  # of a cosine


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
    """Return where a walk along `corners` goes (x and y of each in turn) from `start` on.

    It sets out at `initial_speed` along the first leg, keeps to each leg's speed of `tops`, or to
    the only one, as soon as `acceleration` lets it, and ends in a rest for good; corners are taken
    as `walk` takes them, and never faster than `max_speed`. It follows on the walk of a `lead`, and
    on a rest if that is over, or else `since`, before the start. None where it can't come to rest,
    or slow down enough for a corner.
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
    """Draw up the walk along the first `count` corners; return its number of pieces, or 0.

    They are at the beginning of `table`, which is made longer where it is too short. `lead` is the
    table of a walk without its final rest; see `walk_swath` for the rest.
    """
    k: cython.Py_ssize_t = planar_count(lead)
    # The legs are noted behind all pieces that there may be.
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
        # Forwards: nor faster than one can have become. Both together are the fastest.
        w: float = min(leg[i + 1].first, sqrt(u * u + 2 * pace.acceleration * leg[i].length))
        k = _walk(row, k, leg[i], u, w, pace.acceleration)
        u = w
    row[k] = rest_piece(row[k].begin, corner[count - 1].x, corner[count - 1].y)
    return k + 1


def _plan(
    corner: Positions, count: cython.Py_ssize_t, tops: Numbers, pace: SpeedLimits, leg: PathLegs
) -> cython.Py_ssize_t:
    """Note the legs of a walk; return how many there are, 0 if there is no such walk."""
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
        if length <= _SHORT:
            length = before
            continue
        dx /= length
        dy /= length
        cap: float = pace.initial_speed
        if legs > 0:
            # One who sets out too fast for a leg can't be asked for less than what braking leaves
            # there.
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
    # Backwards: nowhere faster than what lets one slow down for all that comes.
    after: float = 0.0
    leg[legs] = PathLeg(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, after)
    for k in range(legs - 1, -1, -1):
        p: PathLeg = leg[k]
        after = min(p.first, sqrt(after * after + gain * p.length))
        leg[k] = PathLeg(p.x, p.y, p.c, p.s, p.length, p.top, after)
    return legs if after >= pace.initial_speed - _HAIR else 0


def turned(table: Numbers, heading: float) -> Numbers:
    """Return the table of the motion along a walk: turned to where it goes, final rest left out.

    Until it goes anywhere it is turned by `heading` (radians).
    """
    count: cython.Py_ssize_t = planar_count(table) - 1
    found: Numbers = pose_room(count)
    k: cython.Py_ssize_t
    for k in range(count):
        p: PlanarPiece = planar(table)[k]
        if p.x.v != 0.0 or p.y.v != 0.0:
            heading = atan2(p.y.v, p.x.v)
        elif p.x.a != 0.0 or p.y.a != 0.0:
            heading = atan2(p.y.a, p.x.a)
        poses(found)[k] = PosePiece(p.begin, p.end, p.x, p.y, constant(heading))
    return found


def bend_speed(cosine: float, shorter: float, acceleration: float) -> float:
    """Return the speed (m/s) of a turn between two legs, of which one is `shorter` (metres).

    `cosine` is that of the turn. This is `corner_speed` without an angle: cos(φ / 2) and tan(φ / 2)
    follow from cos φ, which is at hand here. The last bits differ.
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
    """Add the pieces of a leg from speed `u` to `w` from the k-th on; return which comes next.

    That one has its begin already, before and after.
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
    # Up to the peak and down again on what is left of the leg, if its top speed allows.
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
    """Add a phase as the k-th piece, as `_walk`, if it lasts; return which comes next.

    `way` is the distance along the leg.
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
