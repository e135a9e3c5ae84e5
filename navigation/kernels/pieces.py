"""Pieces of motions: states at an instant, continuity, and axes that change at times of their own.

A table has for each piece its begin and end, and four coefficients each of x, y and rotation, all
in one row of `numbers`.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .odometer import WIDTH

if not cython.compiled:
    from math import atan2, copysign, sqrt

    from .numbers import Doubles, Numbers, at, cut, put, room
    from .odometer import row_at
else:
    from cython.cimports.libc.math import atan2, copysign, sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at, cut, put, room
    from cython.cimports.navigation.kernels.odometer import row_at

Triple = tuple[float, float, float]

_INFINITE: float = float("inf")
_WIDTH: cython.Py_ssize_t = WIDTH
_SHORTEST: float = 1e-12  # seconds; nothing changes its course for less


def state(table: Numbers, t: float) -> tuple[Triple, Triple, Triple]:
    """Return position, velocity and acceleration of a motion at `t` (seconds), held within it."""
    c: Doubles = at(table)
    row: cython.Py_ssize_t = row_at(c, len(table) // _WIDTH, _WIDTH, t)
    moving: cython.bint = c[0] <= t < c[len(table) - _WIDTH + 1]
    return evaluate(table, max(row, 0), t, moving)


def evaluate(
    table: Numbers, row: cython.Py_ssize_t, t: float, moving: bool
) -> tuple[Triple, Triple, Triple]:
    """Return position, velocity and acceleration of a piece at `t`, held within it."""
    c: Doubles = at(table)
    o: cython.Py_ssize_t = row * _WIDTH
    begin: float = c[o]
    u: float = min(max(t, begin), c[o + 1]) - begin
    vx: float = c[o + 3]
    ax: float = c[o + 4]
    jx: float = c[o + 5]
    vy: float = c[o + 7]
    ay: float = c[o + 8]
    jy: float = c[o + 9]
    vr: float = c[o + 11]
    ar: float = c[o + 12]
    jr: float = c[o + 13]
    place = (
        c[o + 2] + u * (vx + u * (ax + u * jx)),
        c[o + 6] + u * (vy + u * (ay + u * jy)),
        c[o + 10] + u * (vr + u * (ar + u * jr)),
    )
    if not moving:
        return place, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    velocity = (
        vx + u * (2 * ax + u * 3 * jx),
        vy + u * (2 * ay + u * 3 * jy),
        vr + u * (2 * ar + u * 3 * jr),
    )
    return place, velocity, (2 * ax + 6 * u * jx, 2 * ay + 6 * u * jy, 2 * ar + 6 * u * jr)


def value_at(table: Doubles, o: cython.Py_ssize_t, t: float) -> float:
    """Return the value at `t` (seconds) of the cubic whose coefficients begin at `o`.

    Its piece is that of the row which `o` is in; it is held within that.
    """
    row: cython.Py_ssize_t = o - o % _WIDTH
    begin: float = table[row]
    u: float = min(max(t, begin), table[row + 1]) - begin
    value: float = table[o] + u * (table[o + 1] + u * (table[o + 2] + u * table[o + 3]))
    return value


def rate_at(table: Doubles, o: cython.Py_ssize_t, t: float) -> float:
    """Return the derivative of `value_at`."""
    row: cython.Py_ssize_t = o - o % _WIDTH
    begin: float = table[row]
    u: float = min(max(t, begin), table[row + 1]) - begin
    value: float = table[o + 1] + u * (2 * table[o + 2] + u * 3 * table[o + 3])
    return value


def bend_at(table: Doubles, o: cython.Py_ssize_t, t: float) -> float:
    """Return the second derivative of `value_at`."""
    row: cython.Py_ssize_t = o - o % _WIDTH
    begin: float = table[row]
    u: float = min(max(t, begin), table[row + 1]) - begin
    value: float = 2 * table[o + 2] + 6 * u * table[o + 3]
    return value


def breaks(table: Numbers, tolerance: float) -> list[int]:
    """Return the rows that end before they begin, or do not begin where the one before ended.

    That is when it ended, and no farther from it than `tolerance` metres.
    """
    found: list[int] = []
    c: Doubles = at(table)
    k: cython.Py_ssize_t
    for k in range(len(table) // _WIDTH):
        o: cython.Py_ssize_t = k * _WIDTH
        if c[o + 1] < c[o]:
            found.append(k)
        elif k > 0:
            p: cython.Py_ssize_t = o - _WIDTH
            if c[p + 1] != c[o] or _parted(c, p, c, o) > tolerance:
                found.append(k)
    return found


def _parted(table: Doubles, p: cython.Py_ssize_t, after: Doubles, o: cython.Py_ssize_t) -> float:
    """Return how far from the end of the piece at `p` the one at `o` begins (metres)."""
    u: float = table[p + 1] - table[p]
    dx: float = table[p + 2] + u * (table[p + 3] + u * (table[p + 4] + u * table[p + 5]))
    dy: float = table[p + 6] + u * (table[p + 7] + u * (table[p + 8] + u * table[p + 9]))
    dx -= after[o + 2]
    dy -= after[o + 6]
    return sqrt(dx * dx + dy * dy)


def rest(begin: float, end: float, x: float, y: float, rotation: float) -> Numbers:
    """Return the table of standing at `x`, `y` (metres) from `begin` to `end` (seconds).

    It is turned by `rotation` (radians).
    """
    table: Numbers = room(_WIDTH)
    row: Doubles = at(table)
    k: cython.Py_ssize_t
    for k in range(_WIDTH):
        row[k] = 0.0
    row[0] = begin
    row[1] = end
    row[2] = x
    row[6] = y
    row[10] = rotation
    return table


def phases_of(
    state: list[float],
    durations: list[float],
    accelerations: list[float],
    jerks: list[float],
) -> Numbers:
    """Return an axis's phases, from position, velocity and acceleration on: rows of `merge_axes`.

    Without a jerk limit the acceleration jumps between phases; position and velocity don't.
    """
    rows: Numbers = room(5 * max(len(durations), 1))
    row: Doubles = at(rows)
    o: cython.Py_ssize_t = 0
    c0: float = state[0]
    c1: float = state[1]
    k: cython.Py_ssize_t
    for k in range(len(durations)):
        u: float = durations[k]
        if u <= 0.0:
            continue
        c2: float = accelerations[k] / 2
        c3: float = jerks[k] / 6
        row[o] = u
        row[o + 1] = c0
        row[o + 2] = c1
        row[o + 3] = c2
        row[o + 4] = c3
        o += 5
        c0 = c0 + u * (c1 + u * (c2 + u * c3))
        c1 = c1 + u * (2 * c2 + u * 3 * c3)
    if o == 0:
        row[0] = 0.0
        row[1] = c0
        row[2] = c1
        row[3] = state[2] / 2
        row[4] = 0.0
        o = 5
    cut(rows, o)
    return rows


def scaled(rows: Numbers, begin: float, share: float) -> Numbers:
    """Return the rows of an axis that goes by a share of another's, from `begin` on."""
    found: Numbers = room(len(rows))
    a: Doubles = at(rows)
    b: Doubles = at(found)
    k: cython.Py_ssize_t
    for k in range(0, len(rows), 5):
        b[k] = a[k]
        b[k + 1] = begin + share * a[k + 1]
        b[k + 2] = share * a[k + 2]
        b[k + 3] = share * a[k + 3]
        b[k + 4] = share * a[k + 4]
    return found


def merge_axes(axes: list[Numbers], start: float) -> Numbers:
    """Return the table of a motion from `start` on whose three axes have phases of their own.

    An axis has a row of a duration and four coefficients for each phase, and is at rest after the
    last. The motion is cut where one of them changes.
    """
    phases: Numbers
    phase: Doubles
    most: cython.Py_ssize_t = 0
    axis: cython.Py_ssize_t
    for axis in range(3):
        phases = axes[axis]
        most += len(phases) // 5
    table: Numbers = room(_WIDTH * most)  # one of the axes changes at the end of every piece
    c: Doubles = at(table)
    o: cython.Py_ssize_t = 0
    rows: list[int] = [0, 0, 0]
    begins: Numbers = room(3)
    b: Doubles = at(begins)
    b[0] = b[1] = b[2] = 0.0
    row: cython.Py_ssize_t
    begin: float = start
    lower: float = 0.0
    while True:
        # The next change after `lower` is the end of a phase that one of the axes is in then.
        upper: float = _INFINITE
        for axis in range(3):
            phases = axes[axis]
            row = rows[axis]
            phase = at(phases)
            since: float = b[axis]
            while row < len(phases) and since + phase[row] <= lower:
                since += phase[row]
                row += 5
            rows[axis] = row
            b[axis] = since
            if row < len(phases):
                upper = min(upper, since + phase[row])
        if upper == _INFINITE:
            cut(table, o)
            return table
        # Axes that end together do so but for rounding: a sliver goes to the next piece, which
        # begins where the last one ended.
        if upper - lower >= _SHORTEST or o == 0:
            c[o] = begin
            begin = start + upper
            c[o + 1] = begin
            for axis in range(3):
                phases = axes[axis]
                phase = at(phases)
                row = rows[axis]
                k: cython.Py_ssize_t = o + 2 + 4 * axis
                if row >= len(phases):
                    row -= 5
                    _shift(c, k, phase, row, phase[row], False)
                else:
                    _shift(c, k, phase, row, lower - b[axis], True)
            o += _WIDTH
        lower = upper


def _shift(
    table: Doubles,
    k: cython.Py_ssize_t,
    phases: Doubles,
    row: cython.Py_ssize_t,
    u: float,
    moving: bool,
) -> cython.int:
    """Set the cubic at `k` to that of a phase as seen from `u` seconds after it began."""
    c1: float = phases[row + 2]
    c2: float = phases[row + 3]
    c3: float = phases[row + 4]
    table[k] = phases[row + 1] + u * (c1 + u * (c2 + u * c3))
    if moving:
        table[k + 1] = c1 + u * (2 * c2 + u * 3 * c3)
        table[k + 2] = c2 + u * 3 * c3
        table[k + 3] = c3
    else:
        table[k + 1] = table[k + 2] = table[k + 3] = 0.0
    return 0


def walked_and_stood(table: Numbers, since: float, until: float) -> tuple[float, float]:
    """Return how far a walk goes from `since` on (m), and how long it stands until `until` (s).

    The pieces of its `table` are straight and never turn back: each is as long as its chord.
    """
    c: Doubles = at(table)
    walked: float = 0.0
    stood: float = 0.0
    k: cython.Py_ssize_t
    for k in range(len(table) // _WIDTH):
        o: cython.Py_ssize_t = k * _WIDTH
        begin: float = c[o]
        end: float = c[o + 1]
        if end < since:
            continue
        u: float = end - begin
        dx: float = u * (c[o + 3] + u * (c[o + 4] + u * c[o + 5]))
        dy: float = u * (c[o + 7] + u * (c[o + 8] + u * c[o + 9]))
        if begin < since:
            u = since - begin
            dx -= u * (c[o + 3] + u * (c[o + 4] + u * c[o + 5]))
            dy -= u * (c[o + 7] + u * (c[o + 8] + u * c[o + 9]))
        if (
            c[o + 3] != 0.0
            or c[o + 4] != 0.0
            or c[o + 5] != 0.0
            or c[o + 7] != 0.0
            or c[o + 8] != 0.0
            or c[o + 9] != 0.0
        ):
            walked += sqrt(dx * dx + dy * dy)
        else:
            stood += max(min(end, until) - max(begin, since), 0.0)
    return walked, stood


class Pack:
    """Pieces without what says nothing: which numbers of each are there, as bits, and those.

    Half of the numbers of a walk are 0, and a piece begins when the one before it ends. A negative
    zero is none: it stays what it is.
    """

    def __init__(self) -> None:
        self.count = 0
        self.kept = array("d")
        self.last: Numbers = room(0)

    def add(self, table: Numbers, begin: float, end: float, tolerance: float) -> bool:
        """Add a motion from `begin` to `end` (seconds), as `between` has it.

        Return whether it begins farther than `tolerance` metres from where the last one ended.
        """
        before: Numbers = self.last
        after: Numbers = between(table, begin, end)
        kept: Numbers = room(len(after) // _WIDTH * (_WIDTH + 1))
        a: Doubles = at(after)
        b: Doubles = at(kept)
        last: cython.Py_ssize_t = len(before) - _WIDTH
        ended: float = at(before)[last + 1] if last >= 0 else 0.0
        i: cython.Py_ssize_t = 0
        k: cython.Py_ssize_t
        o: cython.Py_ssize_t = 0
        while o < len(after):
            mask: cython.int = 0
            bits: cython.Py_ssize_t = i
            i += 1
            number: float = a[o]
            if number != ended or copysign(1.0, number) != copysign(1.0, ended):
                mask = 1
                b[i] = number
                i += 1
            for k in range(1, _WIDTH):
                number = a[o + k]
                if number != 0.0 or copysign(1.0, number) < 0.0:
                    mask |= 1 << k
                    b[i] = number
                    i += 1
            b[bits] = mask
            ended = a[o + 1]
            o += _WIDTH
        cut(kept, i)
        self.kept.extend(kept)
        self.count += len(after) // _WIDTH
        self.last = after
        jumps: bool = last >= 0 and _parted(at(before), last, a, 0) > tolerance
        return jumps

    def pieces(self) -> Numbers:
        """Return the table of all that was added."""
        table: Numbers = room(_WIDTH * self.count)
        a: Doubles = at(table)
        b: Doubles = at(self.kept)
        ended: float = 0.0
        i: cython.Py_ssize_t = 0
        k: cython.Py_ssize_t
        o: cython.Py_ssize_t = 0
        while o < len(table):
            mask: cython.int = int(b[i])
            i += 1
            for k in range(_WIDTH):
                if mask & (1 << k):
                    a[o + k] = b[i]
                    i += 1
                else:
                    a[o + k] = 0.0 if k else ended
            ended = a[o + 1]
            o += _WIDTH
        return table


def between(table: Numbers, begin: float, end: float) -> Numbers:
    """Return the table of a motion from `begin` to `end` (seconds), standing included."""
    a: Doubles = at(table)
    rows: cython.Py_ssize_t = len(table) // _WIDTH
    first: float = a[0]
    last: float = a[len(table) - _WIDTH + 1]
    found: Numbers = room(_WIDTH * (rows + 2))
    b: Doubles = at(found)
    count: cython.Py_ssize_t = 0
    o: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    if begin < first:
        _stand(b, 0, a, 0, begin, begin, min(first, end))
        count = _WIDTH
    row: cython.Py_ssize_t
    for row in range(rows):
        o = row * _WIDTH
        since: float = a[o]
        until: float = a[o + 1]
        if since >= end:
            break
        if begin >= until:
            continue
        if begin <= since:
            put(b, count, a, o, _WIDTH)
        else:
            b[count] = begin
            for k in range(2, _WIDTH, 4):
                _set_later(b, count + k, a, o + k, begin - since)
        b[count + 1] = min(end, until)
        count += _WIDTH
    if end > last or count == 0:
        # After its end a motion stands; the last piece that has begun says where.
        stands: float = max(begin, last) if end > last else begin
        o = len(table) - _WIDTH
        while o > 0 and a[o] > stands:
            o -= _WIDTH
        _stand(b, count, a, o, stands, stands, end)
        count += _WIDTH
    cut(found, count)
    return found


def _stand(
    found: Doubles,
    count: cython.Py_ssize_t,
    table: Doubles,
    o: cython.Py_ssize_t,
    t: float,
    begin: float,
    end: float,
) -> cython.int:
    """Set standing from `begin` to `end` where the piece at `o` is at `t`, held within it."""
    since: float = table[o]
    u: float = min(max(t, since), table[o + 1]) - since
    found[count] = begin
    found[count + 1] = end
    k: cython.Py_ssize_t
    for k in range(2, _WIDTH, 4):
        c1: float = table[o + k + 1]
        c2: float = table[o + k + 2]
        c3: float = table[o + k + 3]
        found[count + k] = table[o + k] + u * (c1 + u * (c2 + u * c3))
        found[count + k + 1] = found[count + k + 2] = found[count + k + 3] = 0.0
    return 0


def _set_later(
    found: Doubles, k: cython.Py_ssize_t, table: Doubles, o: cython.Py_ssize_t, u: float
) -> cython.int:
    """Set the cubic at `k` to the one at `o`, counted from `u` seconds later."""
    c1: float = table[o + 1]
    c2: float = table[o + 2]
    c3: float = table[o + 3]
    found[k] = table[o] + u * (c1 + u * (c2 + u * c3))
    found[k + 1] = c1 + u * (2 * c2 + u * 3 * c3)
    found[k + 2] = c2 + u * 3 * c3
    found[k + 3] = c3
    return 0


def along_legs(
    corners: list[float],
    lengths: list[float],
    speeds: list[float],
    top: float,
    rate: float,
    start: float,
) -> Numbers:
    """Return the table of the fastest walk through `corners` (x and y of each in turn).

    It has the given speed at each of them (m/s), `top` at most, and speeds up and slows down at
    `rate` (m/s²); `lengths` are those of the legs (metres), and it begins at `start` (seconds). Its
    rotation is the heading.
    """
    table: Numbers = room(3 * _WIDTH * len(lengths))  # a leg has three phases at most
    row: Doubles = at(table)
    o: cython.Py_ssize_t = 0
    begin: float = start
    k: cython.Py_ssize_t
    for k in range(len(lengths)):
        x: float = corners[2 * k]
        y: float = corners[2 * k + 1]
        dx: float = corners[2 * k + 2] - x
        dy: float = corners[2 * k + 3] - y
        length: float = lengths[k]
        c: float = dx / length
        s: float = dy / length
        heading: float = atan2(dy, dx)
        first: float = speeds[k]
        last: float = speeds[k + 1]
        # Speed squared changes by 2 · rate · metres: up to the peak and down to the last speed take
        # the leg whole where (2 p² − first² − last²) / (2 · rate) is its length.
        peak: float = min(top, sqrt((first * first + last * last) / 2 + rate * length))
        peak = max(peak, last)
        change: float = copysign(rate, peak - first)
        rising: float = (peak - first) / change
        falling: float = (peak - last) / rate
        steady: float = length - (first + peak) / 2 * rising - (peak + last) / 2 * falling
        gone: float = 0.0
        phase: cython.int
        for phase in range(3):
            duration: float = rising
            speed: float = first
            slope: float = change
            if phase == 1:
                duration = max(steady, 0.0) / peak
                speed = peak
                slope = 0.0
            elif phase == 2:
                duration = falling
                speed = peak
                slope = -rate
            if duration > 0.0:
                half: float = slope / 2
                end: float = begin + duration
                row[o] = begin
                row[o + 1] = end
                row[o + 2] = x + gone * c
                row[o + 3] = speed * c
                row[o + 4] = half * c
                # No jerk; the product gives the zero the sign that it has where pieces are made one
                # by one.
                row[o + 5] = 0.0 * c
                row[o + 6] = y + gone * s
                row[o + 7] = speed * s
                row[o + 8] = half * s
                row[o + 9] = 0.0 * s
                row[o + 10] = heading
                row[o + 11] = row[o + 12] = row[o + 13] = 0.0
                o += _WIDTH
                begin = end
                gone += duration * (speed + duration * slope / 2)
    cut(table, o)
    return table
