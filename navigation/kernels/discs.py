"""Discs that meet: the first instant at which two centres, or one and any other, come too close.

A table holds the motion of a centre in rows of ten numbers, one after another: begin and end of a
piece (seconds), then the coefficients of its cubics of x and y since it began. The last row is the
final standing, and never ends. For what a row of numbers is see `numbers`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import inf, sqrt

    from .numbers import Doubles, Numbers, at, cut, put, room

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at, cut, put, room

ROW = 10
"""Numbers in a row."""

_R: cython.Py_ssize_t = ROW
_PIECE: cython.Py_ssize_t = 14  # numbers of a piece of a motion
_RESOLUTION: float = 1e-4  # seconds; what is undecided when it is shorter counts as a conflict
_JUST_NOW: float = 1e-3  # seconds; who is too close so soon is so already


def within_bounds(
    boxes: Numbers,
    low_x: float,
    low_y: float,
    high_x: float,
    high_y: float,
    but: cython.Py_ssize_t = -1,
) -> list[cython.Py_ssize_t]:
    """Return who of those with these bounds, `but` one, may come into some: their indices.

    `boxes` holds four numbers for each: least x and y, greatest x and y (metres). Those asked
    about are `low_x`, `low_y`, `high_x` and `high_y`.
    """
    found: list[cython.Py_ssize_t] = []
    b: Doubles = at(boxes)
    k: cython.Py_ssize_t
    for k in range(len(boxes) // 4):
        if (
            b[4 * k] < high_x
            and b[4 * k + 2] > low_x
            and b[4 * k + 1] < high_y
            and b[4 * k + 3] > low_y
            and k != but
        ):
            found.append(k)  # noqa: PERF401
    return found


def swept(pieces: Numbers, begin: float, since: float, x: float, y: float, box: Numbers) -> Numbers:
    """Return the table from `begin` on (seconds) of a motion that stands at `x`, `y` from `since`.

    `pieces` is its table as those of `pieces`. `box` becomes its bounds: least x and y, greatest x
    and y (metres).
    """
    count: cython.Py_ssize_t = len(pieces) // _PIECE
    table: Numbers = room((count + 1) * _R)
    row: Doubles = at(table)
    piece: Doubles = at(pieces)
    bounds: Doubles = at(box)
    bounds[0] = bounds[2] = x
    bounds[1] = bounds[3] = y
    o: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    for k in range(count):
        start: float = piece[k * _PIECE]
        end: float = piece[k * _PIECE + 1]
        if end > begin and end > start:
            put(row, o, piece, k * _PIECE, _R)
            _widen(bounds, 0, row, o + 2, end - start)
            _widen(bounds, 1, row, o + 6, end - start)
            o += _R
    stand(row, o, since, INFINITY, x, y)
    cut(table, o + _R)
    return table


def stand(
    row: Doubles, o: cython.Py_ssize_t, since: float, until: float, x: float, y: float
) -> cython.int:
    """Set the row at `o` to standing at `x`, `y` (metres) from `since` until then (seconds)."""
    k: cython.Py_ssize_t
    row[o] = since
    row[o + 1] = until
    for k in range(2, _R):
        row[o + k] = 0.0
    row[o + 2] = x
    row[o + 6] = y
    return 0


def _widen(
    box: Doubles, axis: cython.Py_ssize_t, row: Doubles, o: cython.Py_ssize_t, u: float
) -> cython.int:
    """Widen bounds along an axis to those of a cubic that lasts `u` seconds."""
    a: float = row[o]
    b: float = row[o + 1]
    c: float = row[o + 2]
    d: float = row[o + 3]
    last: float = a + u * (b + u * (c + u * d))
    low: float = min(a, last)
    high: float = max(a, last)
    # A quadratic turns back where its velocity changes sign between the two ends.
    if d != 0.0 or (c != 0.0 and b * (b + 2 * c * u) < 0.0):
        # It may turn back within the piece: no farther out than its control points.
        third: float = u * b / 3
        one: float = a + third
        two: float = a + 2 * third + u * u * c / 3
        low = min(low, min(one, two))
        high = max(high, max(one, two))
    box[axis] = min(box[axis], low)
    box[axis + 2] = max(box[axis + 2], high)
    return 0


def first_met(
    table: Numbers,
    box: Numbers,
    near: list[cython.Py_ssize_t],
    tables: list[Numbers],
    boxes: Numbers,
    radii: Numbers,
    own: float,
    begin: float,
    when: Numbers,
) -> cython.Py_ssize_t:
    """Return who of those `near` is met first from `begin` (seconds) on; -1 for nobody.

    `table` is the motion of one, `tables` those of all others. To meet one of them is to come
    closer than `own` and their radius of `radii` (metres); who is closer already is met by coming
    closer still. `box` and `boxes` bound the motions: least x and y, greatest x and y, four numbers
    for each. When it is, is `when[0]`.
    """
    first: float = INFINITY
    who: cython.Py_ssize_t = -1
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    t: float
    for i in range(len(near)):
        k = near[i]
        t = met(table, box, tables, boxes, radii, own, begin, first, k)
        if t < first:
            first = t
            who = k
    at(when)[0] = first
    return who


def first_but(
    table: Numbers,
    box: Numbers,
    tables: list[Numbers],
    boxes: Numbers,
    radii: Numbers,
    own: float,
    begin: float,
    apart: bytearray,
) -> cython.Py_ssize_t:
    """Return who of all but those `apart` is met first from `begin` (seconds) on; -1 for nobody.

    `apart` has a byte for each, 0 for who counts. For `table`, `box`, `tables`, `boxes`, `radii`
    and `own` see `first_met`.
    """
    first: float = INFINITY
    who: cython.Py_ssize_t = -1
    a: Doubles = at(box)
    b: Doubles = at(boxes)
    r: Doubles = at(radii)
    k: cython.Py_ssize_t
    for k in range(len(radii)):
        least: float = own + r[k]
        if (
            a[0] - b[4 * k + 2] < least
            and b[4 * k] - a[2] < least
            and a[1] - b[4 * k + 3] < least
            and b[4 * k + 1] - a[3] < least
            and not apart[k]
        ):
            t: float = met(table, box, tables, boxes, radii, own, begin, first, k)
            if t < first:
                first = t
                who = k
    return who


def met(
    table: Numbers,
    box: Numbers,
    tables: list[Numbers],
    boxes: Numbers,
    radii: Numbers,
    own: float,
    begin: float,
    until: float,
    k: cython.Py_ssize_t,
) -> float:
    """Return when the k-th is met before `until`, as `first_met` has it; infinite if never."""
    least: float = own + at(radii)[k]
    a: Doubles = at(box)
    b: Doubles = at(boxes)
    if (
        a[0] - b[4 * k + 2] >= least
        or b[4 * k] - a[2] >= least
        or a[1] - b[4 * k + 3] >= least
        or b[4 * k + 1] - a[3] >= least
    ):
        return INFINITY
    other: Numbers = tables[k]
    t: float = _meeting(table, other, least, begin, until, 0, 0)
    if t <= begin + _JUST_NOW:
        # They are too close to begin with: then what counts is coming closer than they are.
        apart: float = distance(table, other, begin)
        if apart < least + _JUST_NOW:
            t = _meeting(table, other, min(least, apart - 1e-9), begin, until, 0, 0)
    return t


def gone(table: Numbers, since: float, t: float) -> float:
    """Return the metres that a walk along straight legs goes from `since` to `t` (seconds)."""
    total: float = 0.0
    a: Doubles = at(table)
    k: cython.Py_ssize_t
    for k in range(len(table) // _R - 1):
        o: cython.Py_ssize_t = k * _R
        begin: float = a[o]
        if since <= begin < t:
            end: float = a[o + 1]
            u: float = (end if end < t else t) - begin
            # On a straight leg nobody turns back, so that the chord is the way.
            x: float = u * (a[o + 3] + u * a[o + 4])
            y: float = u * (a[o + 7] + u * a[o + 8])
            total += sqrt(x * x + y * y)
    return total


def meeting(one: Numbers, other: Numbers, least: float, begin: float, until: float) -> float:
    """Return the first instant from `begin` to `until` at which two are nearer than `least`.

    Seconds and metres; infinite if there is none. Both tables reach back to `begin`. Never misses
    one; finds one too many only where the two stay within rounding of `least`.
    """
    return _meeting(one, other, least, begin, until, 0, 0)


def distance(one: Numbers, other: Numbers, t: float) -> float:
    """Return the distance of two centres at `t` (seconds), metres."""
    a: Doubles = at(one)
    b: Doubles = at(other)
    i: cython.Py_ssize_t = 0
    j: cython.Py_ssize_t = 0
    # No end of the table is looked for: its last row never ends.
    while a[i + 1] <= t:
        i += _R
    while b[j + 1] <= t:
        j += _R
    u: float = max(t - a[i], 0.0)
    w: float = max(t - b[j], 0.0)
    x: float = a[i + 2] + u * (a[i + 3] + u * (a[i + 4] + u * a[i + 5]))
    y: float = a[i + 6] + u * (a[i + 7] + u * (a[i + 8] + u * a[i + 9]))
    x -= b[j + 2] + w * (b[j + 3] + w * (b[j + 4] + w * b[j + 5]))
    y -= b[j + 6] + w * (b[j + 7] + w * (b[j + 8] + w * b[j + 9]))
    return sqrt(x * x + y * y)


def _meeting(
    one: Numbers,
    other: Numbers,
    least: float,
    begin: float,
    until: float,
    row: cython.Py_ssize_t,
    other_row: cython.Py_ssize_t,
) -> float:
    """See `meeting`."""
    a: Doubles = at(one)
    b: Doubles = at(other)
    i: cython.Py_ssize_t = row * _R
    j: cython.Py_ssize_t = other_row * _R
    while a[i + 1] <= begin:
        i += _R
    while b[j + 1] <= begin:
        j += _R
    t: float = begin
    while t < until:
        a_end: float = a[i + 1]
        b_end: float = b[j + 1]
        x: float = a[i + 2]
        x1: float = a[i + 3]
        x2: float = a[i + 4]
        x3: float = a[i + 5]
        y: float = a[i + 6]
        y1: float = a[i + 7]
        y2: float = a[i + 8]
        y3: float = a[i + 9]
        u: float = t - a[i]
        if u > 0.0:
            x += u * (x1 + u * (x2 + u * x3))
            x1 += u * (2 * x2 + u * 3 * x3)
            x2 += u * 3 * x3
            y += u * (y1 + u * (y2 + u * y3))
            y1 += u * (2 * y2 + u * 3 * y3)
            y2 += u * 3 * y3
        if b_end == INFINITY:  # the other stands
            x -= b[j + 2]
            y -= b[j + 6]
            if a_end == INFINITY:
                return t if x * x + y * y < least * least else INFINITY
        else:
            w: float = t - b[j]
            bx1: float = b[j + 3]
            bx2: float = b[j + 4]
            bx3: float = b[j + 5]
            by1: float = b[j + 7]
            by2: float = b[j + 8]
            by3: float = b[j + 9]
            x -= b[j + 2] + w * (bx1 + w * (bx2 + w * bx3))
            x1 -= bx1 + w * (2 * bx2 + w * 3 * bx3)
            x2 -= bx2 + w * 3 * bx3
            x3 -= bx3
            y -= b[j + 6] + w * (by1 + w * (by2 + w * by3))
            y1 -= by1 + w * (2 * by2 + w * 3 * by3)
            y2 -= by2 + w * 3 * by3
            y3 -= by3
        end: float = a_end if a_end < b_end else b_end
        duration: float = end - t
        # Cheapest first: most stretches are decided by these corners alone.
        apart: cython.bint = False
        if x3 == 0.0 and y3 == 0.0:
            # A quadratic stays between its control points.
            xm: float = x + duration * x1 / 2
            ym: float = y + duration * y1 / 2
            xe: float = x + duration * (x1 + duration * x2)
            ye: float = y + duration * (y1 + duration * y2)
            apart = (
                (x >= least and xm >= least and xe >= least)
                or (x <= -least and xm <= -least and xe <= -least)
                or (y >= least and ym >= least and ye >= least)
                or (y <= -least and ym <= -least and ye <= -least)
            )
        if not apart:
            met: float = _within(x, x1, x2, x3, y, y1, y2, y3, duration, least)
            if met >= 0.0:
                return t + met
        t = end
        if a_end <= t:
            i += _R
        if b_end <= t:
            j += _R
    return INFINITY


def _within(
    x0: float,
    x1: float,
    x2: float,
    x3: float,
    y0: float,
    y1: float,
    y2: float,
    y3: float,
    duration: float,
    least: float,
) -> float:
    """Return the first u from 0 to `duration` at which x, y is within `least` of 0, 0; or -1.

    About the middle of a stretch the position is r + v u + (a/2) u² + (j/6) u³. The distance along
    the straight line r + v u is convex, and the rest can't be longer than (a/2) h² + (j/6) h³
    (as in `Encounter`); a stretch that this leaves undecided is halved. Stretches are `width` long,
    and the one to look at is the k-th of that width. The shortest are a conflict, unless the two
    part in them: who stands as near as may be, and walks away, is undecided however short it is.
    """
    curved: cython.bint = x2 != 0.0 or y2 != 0.0 or x3 != 0.0 or y3 != 0.0
    width: float = duration
    k: cython.Py_ssize_t = 0
    while True:
        half: float = width / 2
        since: float = k * width
        m: float = since + half
        x: float = x0 + m * (x1 + m * (x2 + m * x3))
        y: float = y0 + m * (y1 + m * (y2 + m * y3))
        vx: float = x1 + m * (2 * x2 + m * 3 * x3)
        vy: float = y1 + m * (2 * y2 + m * 3 * y3)
        square: float = vx * vx + vy * vy
        offset: float = 0.0
        if square > 0.0:
            offset = -(x * vx + y * vy) / square
            offset = -half if offset < -half else half if offset > half else offset
        x += vx * offset
        y += vy * offset
        near: float = sqrt(x * x + y * y)
        if curved:
            ax: float = x2 + 3 * x3 * m
            ay: float = y2 + 3 * y3 * m
            bend: float = sqrt(ax * ax + ay * ay) + half * sqrt(x3 * x3 + y3 * y3)
            near -= half * half * bend
            if near < least and width <= _RESOLUTION:
                near = _parting(x0, x1, x2, x3, y0, y1, y2, y3, since, width)
        if near >= least:
            k += 1
            # The next stretch to the right of the halving: as wide as it may be again.
            while k % 2 == 0:
                k //= 2
                width *= 2
            if width >= duration:
                return -1.0
        # A straight line enters the disc within the stretch: when, is known in closed form.
        elif not curved:
            return _entered(x0, x1, y0, y1, duration, least)
        elif width <= _RESOLUTION:
            return since
        else:
            k *= 2
            width = half


def _parting(
    x0: float,
    x1: float,
    x2: float,
    x3: float,
    y0: float,
    y1: float,
    y2: float,
    y3: float,
    since: float,
    width: float,
) -> float:
    """Return a bound on how near x, y is to 0, 0 for `width` seconds, which is exact if it parts.

    Along the direction from 0, 0 to where it is at the beginning, `since`, a cubic stays between
    its control points.
    """
    u: float = since
    x: float = x0 + u * (x1 + u * (x2 + u * x3))
    y: float = y0 + u * (y1 + u * (y2 + u * y3))
    away: float = sqrt(x * x + y * y)
    if away == 0.0:
        return 0.0
    nx: float = x / away
    ny: float = y / away
    # Its derivatives along that direction, each over its factorial, times the width's power.
    one: float = width * (
        nx * (x1 + u * (2 * x2 + u * 3 * x3)) + ny * (y1 + u * (2 * y2 + u * 3 * y3))
    )
    two: float = width * width * (nx * (x2 + u * 3 * x3) + ny * (y2 + u * 3 * y3))
    three: float = width * width * width * (nx * x3 + ny * y3)
    nearer: float = min(one / 3, min((2 * one + two) / 3, one + two + three))
    return away + min(nearer, 0.0)


def _entered(x: float, vx: float, y: float, vy: float, duration: float, least: float) -> float:
    """Return the first u from 0 to `duration` at which x + vx u, y + vy u is within `least`."""
    # The roots of a u² + 2 b u + c; the first is c / (√(b² − a c) − b), with b < 0 where the two
    # come closer: a sum of what is positive, so that nothing cancels.
    c: float = x * x + y * y - least * least
    if c <= 0.0:
        return 0.0
    a: float = vx * vx + vy * vy
    b: float = x * vx + y * vy
    root: float = sqrt(max(b * b - a * c, 0.0))
    return min(max(c / (root - b), 0.0), duration)
