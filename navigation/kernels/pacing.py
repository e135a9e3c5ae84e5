"""Walks among others in plain numbers: the table of a walk along a polyline, in closed form.

On each leg the speed rises and falls at one acceleration, so that its phases follow from the speeds
at the corners: the forward and backward pass of D. Verscheure et al., "Time-optimal path tracking
for robots", IEEE Transactions on Automatic Control 54 (2009), for a bound on the acceleration along
the path alone. For the tables see `discs`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import ROW
from .numbers import POSE_WIDTH
from .walks import DEVIATION, NOWHERE

if not cython.compiled:
    from math import atan2, inf, sqrt

    from .discs import stand
    from .numbers import Doubles, Numbers, at, cut, grow, put, room

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, atan2, sqrt
    from cython.cimports.navigation.kernels.discs import stand
    from cython.cimports.navigation.kernels.numbers import (
        Doubles,
        Numbers,
        at,
        cut,
        grow,
        put,
        room,
    )

_R: cython.Py_ssize_t = ROW
_PIECE: cython.Py_ssize_t = POSE_WIDTH
# Numbers of a leg: x and y, direction, length, top speed, the highest speed at its beginning.
_LEG: cython.Py_ssize_t = 7
_PHASES: cython.Py_ssize_t = 4  # of a leg, at most
_SHORT: float = NOWHERE
_DEVIATION: float = DEVIATION
_HAIR: float = 1e-9  # m/s
_ROUNDING: float = 1e-12  # of a cosine


def walk_table(
    corners: Numbers,
    tops: Numbers,
    since: float,
    start: float,
    initial_speed: float,
    max_speed: float,
    acceleration: float,
    lead: Numbers,
) -> Numbers:
    """Return the table of a walk along `corners` (x and y of each in turn) from `start` on.

    It sets out at `initial_speed` along the first leg, keeps to each leg's speed of `tops`, or to
    the only one, as soon as `acceleration` lets it, and ends in a standing for ever; corners are
    taken as `walk` takes them, and never faster than `max_speed`. It follows on the rows of a
    `lead`, and on standing if they are over `since` before the start. Empty where it can't come to
    rest, or slow down enough for a corner.
    """
    table: Numbers = room(0)
    end: cython.Py_ssize_t = draw(
        corners,
        len(corners),
        tops,
        since,
        start,
        initial_speed,
        max_speed,
        acceleration,
        lead,
        table,
    )
    cut(table, end)
    return table


def draw(
    corners: Numbers,
    count: cython.Py_ssize_t,
    tops: Numbers,
    since: float,
    start: float,
    initial_speed: float,
    max_speed: float,
    acceleration: float,
    lead: Numbers,
    table: Numbers,
) -> cython.Py_ssize_t:
    """Draw up a `walk_table` of the first `count` numbers of `corners`; return its length, or 0.

    It is at the beginning of `table`, which is made longer where it is too short.
    """
    o: cython.Py_ssize_t = len(lead)
    # The legs are noted behind all rows that there may be.
    plan: cython.Py_ssize_t = o + _R * (_PHASES * (count // 2) + 2)
    grow(table, plan + _LEG * (count // 2 + 1))
    row: Doubles = at(table)
    corner: Doubles = at(corners)
    legs: cython.Py_ssize_t = _plan(
        corner, count, tops, initial_speed, max_speed, acceleration, row, plan
    )
    if legs == 0:
        return 0
    put(row, 0, at(lead), 0, o)
    if since < start:
        stand(row, o, since, start, corner[0], corner[1])
        o += _R
    row[o] = start
    u: float = initial_speed
    w: float
    k: cython.Py_ssize_t
    for k in range(legs):
        i: cython.Py_ssize_t = plan + _LEG * k
        # Forwards: nor faster than one can have become. Both together are the fastest.
        w = min(row[i + _LEG + 6], sqrt(u * u + 2 * acceleration * row[i + 4]))
        o = _walk(row, o, i, u, w, acceleration)
        u = w
    stand(row, o, row[o], INFINITY, corner[count - 2], corner[count - 1])
    return o + _R


def _plan(
    corner: Doubles,
    count: cython.Py_ssize_t,
    tops: Numbers,
    initial_speed: float,
    max_speed: float,
    acceleration: float,
    leg: Doubles,
    i: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Note the legs of a walk from `i` on; return how many there are, 0 where it can't be."""
    top_of: Doubles = at(tops)
    each: cython.Py_ssize_t = 1 if len(tops) > 1 else 0
    gain: float = 2 * acceleration
    gone: float = 0.0
    c: float = 0.0
    s: float = 0.0
    length: float = 0.0
    top: float = INFINITY
    first: cython.Py_ssize_t = i
    k: cython.Py_ssize_t
    for k in range(0, count - 2, 2):
        dx: float = corner[k + 2] - corner[k]
        dy: float = corner[k + 3] - corner[k + 1]
        before: float = length
        length = sqrt(dx * dx + dy * dy)
        if length <= _SHORT:
            length = before
            continue
        dx /= length
        dy /= length
        cap: float = initial_speed
        if i > first:
            # One who sets out too fast for a leg can't be asked for less than what braking leaves
            # there.
            slowed: float = sqrt(max(initial_speed * initial_speed - gain * gone, 0.0))
            cap = min(max_speed, max(min(top, top_of[k // 2 * each]), slowed))
            shorter: float = before if before < length else length
            cap = min(cap, bend_speed(c * dx + s * dy, shorter, acceleration))
        c = dx
        s = dy
        top = top_of[k // 2 * each]
        gone += length
        leg[i] = corner[k]
        leg[i + 1] = corner[k + 1]
        leg[i + 2] = c
        leg[i + 3] = s
        leg[i + 4] = length
        leg[i + 5] = top
        leg[i + 6] = cap
        i += _LEG
    legs: cython.Py_ssize_t = (i - first) // _LEG
    if legs == 0:
        return 0
    # Backwards: nowhere faster than what lets one slow down for all that comes.
    after: float = 0.0
    leg[i + 6] = after
    for k in range(legs - 1, -1, -1):
        i = first + _LEG * k
        after = min(leg[i + 6], sqrt(after * after + gain * leg[i + 4]))
        leg[i + 6] = after
    return legs if after >= initial_speed - _HAIR else 0


def turned(table: Numbers, heading: float) -> Numbers:
    """Return the table of the motion along a walk: turned to where it goes, standing left out.

    Its rows are those of `pieces`; until it goes anywhere it is turned by `heading` (radians).
    """
    count: cython.Py_ssize_t = len(table) // _R - 1
    found: Numbers = room(_PIECE * count)
    row: Doubles = at(table)
    piece: Doubles = at(found)
    k: cython.Py_ssize_t
    for k in range(count):
        o: cython.Py_ssize_t = k * _R
        p: cython.Py_ssize_t = k * _PIECE
        if row[o + 3] != 0.0 or row[o + 7] != 0.0:
            heading = atan2(row[o + 7], row[o + 3])
        elif row[o + 4] != 0.0 or row[o + 8] != 0.0:
            heading = atan2(row[o + 8], row[o + 4])
        put(piece, p, row, o, _R)
        piece[p + 10] = heading
        piece[p + 11] = piece[p + 12] = piece[p + 13] = 0.0
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
    row: Doubles,
    o: cython.Py_ssize_t,
    i: cython.Py_ssize_t,
    u: float,
    w: float,
    acceleration: float,
) -> cython.Py_ssize_t:
    """Add the rows of the leg at `i` from speed `u` to `w` at `o`; return where the next one is.

    When it begins stands there already, and when it is over then stands there.
    """
    length: float = row[i + 4]
    top: float = row[i + 5]
    gone: float = 0.0
    level: float = max(top, w)
    if u > level:  # still slowing down
        duration: float = (u - level) / acceleration
        o = _phase(row, o, i, gone, duration, u, -acceleration)
        gone = duration * (u + level) / 2
        u = level
    if level > top:
        top = level
    left: float = max(length - gone, 0.0)
    # Up to the peak and down again on what is left of the leg, if its top speed allows.
    peak: float = sqrt(max((2 * acceleration * left + u * u + w * w) / 2, 0.0))
    peak = max(max(min(peak, top), u), w)
    rising: float = (peak - u) / acceleration
    falling: float = (peak - w) / acceleration
    o = _phase(row, o, i, gone, rising, u, acceleration)
    gone += rising * (u + peak) / 2
    slowing: float = falling * (peak + w) / 2
    cruise: float = max((length - gone - slowing) / peak, 0.0)
    o = _phase(row, o, i, gone, cruise, peak, 0.0)
    gone += cruise * peak
    return _phase(row, o, i, gone, falling, peak, -acceleration)


def _phase(
    row: Doubles,
    o: cython.Py_ssize_t,
    i: cython.Py_ssize_t,
    gone: float,
    duration: float,
    v: float,
    acceleration: float,
) -> cython.Py_ssize_t:
    """Add the row of a phase that begins `gone` metres along a leg, as `_walk`, if it lasts."""
    end: float = row[o] + duration
    if end <= row[o]:
        return o
    c: float = row[i + 2]
    s: float = row[i + 3]
    half: float = acceleration / 2
    row[o + 1] = end
    row[o + 2] = row[i] + gone * c
    row[o + 3] = v * c
    row[o + 4] = half * c
    row[o + 5] = 0.0
    row[o + 6] = row[i + 1] + gone * s
    row[o + 7] = v * s
    row[o + 8] = half * s
    row[o + 9] = 0.0
    row[o + _R] = end
    return o + _R
