"""Pieces of motions: states at an instant, continuity, and axes that change at times of their own.

A table has for each piece its begin and end, and four coefficients each of x, y and rotation.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .odometer import WIDTH

if not cython.compiled:
    from math import atan2, copysign, sqrt

    from .numbers import Doubles, at, grow
    from .odometer import row_at
else:
    from cython.cimports.libc.math import atan2, copysign, sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, at, grow
    from cython.cimports.navigation.kernels.odometer import row_at

Triple = tuple[float, float, float]

_INFINITE: float = float("inf")
_WIDTH: cython.Py_ssize_t = WIDTH
_SHORTEST: float = 1e-12  # seconds; nothing changes its course for less


def state(table: list[float], t: float) -> tuple[Triple, Triple, Triple]:
    """Return position, velocity and acceleration of a motion at `t` (seconds), held within it."""
    row: cython.Py_ssize_t = row_at(table, _WIDTH, t)
    moving: cython.bint = table[0] <= t < table[len(table) - _WIDTH + 1]
    return evaluate(table, max(row, 0), t, moving)


def evaluate(
    table: list[float], row: cython.Py_ssize_t, t: float, moving: bool
) -> tuple[Triple, Triple, Triple]:
    """Return position, velocity and acceleration of a piece at `t`, held within it."""
    o: cython.Py_ssize_t = row * _WIDTH
    begin: float = table[o]
    u: float = min(max(t, begin), table[o + 1]) - begin
    vx: float = table[o + 3]
    ax: float = table[o + 4]
    jx: float = table[o + 5]
    vy: float = table[o + 7]
    ay: float = table[o + 8]
    jy: float = table[o + 9]
    vr: float = table[o + 11]
    ar: float = table[o + 12]
    jr: float = table[o + 13]
    at = (
        table[o + 2] + u * (vx + u * (ax + u * jx)),
        table[o + 6] + u * (vy + u * (ay + u * jy)),
        table[o + 10] + u * (vr + u * (ar + u * jr)),
    )
    if not moving:
        return at, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    velocity = (
        vx + u * (2 * ax + u * 3 * jx),
        vy + u * (2 * ay + u * 3 * jy),
        vr + u * (2 * ar + u * 3 * jr),
    )
    return at, velocity, (2 * ax + 6 * u * jx, 2 * ay + 6 * u * jy, 2 * ar + 6 * u * jr)


def value_at(table: list[float], o: cython.Py_ssize_t, t: float) -> float:
    """Return the value at `t` (seconds) of the cubic whose coefficients begin at `o`.

    Its piece is that of the row which `o` is in; it is held within that.
    """
    row: cython.Py_ssize_t = o - o % _WIDTH
    begin: float = table[row]
    u: float = min(max(t, begin), table[row + 1]) - begin
    value: float = table[o] + u * (table[o + 1] + u * (table[o + 2] + u * table[o + 3]))
    return value


def rate_at(table: list[float], o: cython.Py_ssize_t, t: float) -> float:
    """Return the derivative of `value_at`."""
    row: cython.Py_ssize_t = o - o % _WIDTH
    begin: float = table[row]
    u: float = min(max(t, begin), table[row + 1]) - begin
    value: float = table[o + 1] + u * (2 * table[o + 2] + u * 3 * table[o + 3])
    return value


def bend_at(table: list[float], o: cython.Py_ssize_t, t: float) -> float:
    """Return the second derivative of `value_at`."""
    row: cython.Py_ssize_t = o - o % _WIDTH
    begin: float = table[row]
    u: float = min(max(t, begin), table[row + 1]) - begin
    value: float = 2 * table[o + 2] + 6 * u * table[o + 3]
    return value


def breaks(table: list[float], tolerance: float) -> list[int]:
    """Return the rows that end before they begin, or do not begin where the one before ended.

    That is when it ended, and no farther from it than `tolerance` metres.
    """
    found: list[int] = []
    k: cython.Py_ssize_t
    for k in range(len(table) // _WIDTH):
        o: cython.Py_ssize_t = k * _WIDTH
        if table[o + 1] < table[o]:
            found.append(k)
        elif k > 0:
            p: cython.Py_ssize_t = o - _WIDTH
            if table[p + 1] != table[o] or _parted(table, p, table, o) > tolerance:
                found.append(k)
    return found


def _parted(
    table: list[float], p: cython.Py_ssize_t, after: list[float], o: cython.Py_ssize_t
) -> float:
    """Return how far from the end of the piece at `p` the one at `o` begins (metres)."""
    u: float = table[p + 1] - table[p]
    dx: float = table[p + 2] + u * (table[p + 3] + u * (table[p + 4] + u * table[p + 5]))
    dy: float = table[p + 6] + u * (table[p + 7] + u * (table[p + 8] + u * table[p + 9]))
    dx -= after[o + 2]
    dy -= after[o + 6]
    return sqrt(dx * dx + dy * dy)


def phases_of(
    state: list[float],
    durations: list[float],
    accelerations: list[float],
    jerks: list[float],
) -> list[float]:
    """Return an axis's phases, from position, velocity and acceleration on: rows of `merge_axes`.

    Without a jerk limit the acceleration jumps between phases; position and velocity don't.
    """
    rows: list[float] = []
    c0: float = state[0]
    c1: float = state[1]
    k: cython.Py_ssize_t
    for k in range(len(durations)):
        u: float = durations[k]
        if u <= 0.0:
            continue
        c2: float = accelerations[k] / 2
        c3: float = jerks[k] / 6
        rows.append(u)
        rows.append(c0)
        rows.append(c1)
        rows.append(c2)
        rows.append(c3)
        c0 = c0 + u * (c1 + u * (c2 + u * c3))
        c1 = c1 + u * (2 * c2 + u * 3 * c3)
    if not rows:
        return [0.0, state[0], state[1], state[2] / 2, 0.0]
    return rows


def scaled(rows: list[float], begin: float, share: float) -> list[float]:
    """Return the rows of an axis that goes by a share of another's, from `begin` on."""
    found: list[float] = []
    k: cython.Py_ssize_t
    for k in range(0, len(rows), 5):
        found.append(rows[k])
        found.append(begin + share * rows[k + 1])
        found.append(share * rows[k + 2])
        found.append(share * rows[k + 3])
        found.append(share * rows[k + 4])
    return found


def merge_axes(axes: list[list[float]], start: float) -> list[float]:
    """Return the table of a motion from `start` on whose three axes have phases of their own.

    An axis has a row of a duration and four coefficients for each phase, and is at rest after the
    last. The motion is cut where one of them changes.
    """
    table: list[float] = []
    rows: list[int] = [0, 0, 0]
    begins: list[float] = [0.0, 0.0, 0.0]
    phases: list[float]
    axis: cython.Py_ssize_t
    row: cython.Py_ssize_t
    begin: float = start
    lower: float = 0.0
    while True:
        # The next change after `lower` is the end of a phase that one of the axes is in then.
        upper: float = _INFINITE
        for axis in range(3):
            phases = axes[axis]
            row = rows[axis]
            at: float = begins[axis]
            while row < len(phases) and at + phases[row] <= lower:
                at += phases[row]
                row += 5
            rows[axis] = row
            begins[axis] = at
            if row < len(phases):
                upper = min(upper, at + phases[row])
        if upper == _INFINITE:
            return table
        # Axes that end together do so but for rounding: a sliver goes to the next piece, which
        # begins where the last one ended.
        if upper - lower >= _SHORTEST or not table:
            table.append(begin)
            begin = start + upper
            table.append(begin)
            for axis in range(3):
                phases = axes[axis]
                row = rows[axis]
                if row >= len(phases):
                    row -= 5
                    _append_shifted(table, phases, row, phases[row], False)
                else:
                    _append_shifted(table, phases, row, lower - begins[axis], True)
        lower = upper


def _append_shifted(
    table: list[float], phases: list[float], row: cython.Py_ssize_t, u: float, moving: bool
) -> cython.int:
    """Append the cubic of a phase as seen from `u` seconds after it began."""
    c1: float = phases[row + 2]
    c2: float = phases[row + 3]
    c3: float = phases[row + 4]
    table.append(phases[row + 1] + u * (c1 + u * (c2 + u * c3)))
    if moving:
        table.append(c1 + u * (2 * c2 + u * 3 * c3))
        table.append(c2 + u * 3 * c3)
        table.append(c3)
    else:
        table.append(0.0)
        table.append(0.0)
        table.append(0.0)
    return 0


def walked_and_stood(table: list[float], since: float, until: float) -> tuple[float, float]:
    """Return how far a walk goes (metres), and how long it stands from `since` to `until` (s).

    Its pieces are straight and never turn back: each is as long as its chord.
    """
    walked: float = 0.0
    stood: float = 0.0
    o: cython.Py_ssize_t
    for o in range(0, len(table), _WIDTH):
        begin: float = table[o]
        end: float = table[o + 1]
        u: float = end - begin
        dx: float = u * (table[o + 3] + u * (table[o + 4] + u * table[o + 5]))
        dy: float = u * (table[o + 7] + u * (table[o + 8] + u * table[o + 9]))
        if (
            table[o + 3] != 0.0
            or table[o + 4] != 0.0
            or table[o + 5] != 0.0
            or table[o + 7] != 0.0
            or table[o + 8] != 0.0
            or table[o + 9] != 0.0
        ):
            walked += sqrt(dx * dx + dy * dy)
        else:
            stood += max(min(end, until) - max(begin, since), 0.0)
    return walked, stood


class Pack:
    """Pieces without their zeros: which numbers of each are there, as bits, and those numbers.

    Half of the numbers of a walk are 0. A negative zero is none: it stays what it is.
    """

    def __init__(self) -> None:
        self.masks = array("H")
        self.kept = array("d")
        self.count = 0
        none: list[float] = []
        self.last = none

    def add(self, table: list[float], begin: float, end: float, tolerance: float) -> bool:
        """Add a motion from `begin` to `end` (seconds), as `cut` has it.

        Return whether it begins farther than `tolerance` metres from where the last one ended.
        """
        added: list[float] = cut(table, begin, end)
        last: cython.Py_ssize_t = self.count
        most: cython.Py_ssize_t = last + len(added)
        if most > len(self.kept):
            grow(self.kept, most + most // 8)
        kept: Doubles = at(self.kept)
        row: cython.Py_ssize_t
        k: cython.Py_ssize_t
        for row in range(len(added) // _WIDTH):
            mask: cython.int = 0
            for k in range(_WIDTH):
                number: float = added[row * _WIDTH + k]
                if number != 0.0 or copysign(1.0, number) < 0.0:
                    mask |= 1 << k
                    kept[last] = number
                    last += 1
            self.masks.append(mask)
        self.count = last
        before: list[float] = self.last
        self.last = added[len(added) - _WIDTH :]
        jumps: bool = len(before) > 0 and _parted(before, 0, added, 0) > tolerance
        return jumps

    def pieces(self) -> list[float]:
        """Return the table of all that was added."""
        table: list[float] = []
        nothing: Any = 0.0  # one for all of them
        kept: Doubles = at(self.kept)
        o: cython.Py_ssize_t = 0
        k: cython.Py_ssize_t
        for one in self.masks:
            mask: cython.int = one
            for k in range(_WIDTH):
                if mask & (1 << k):
                    table.append(kept[o])
                    o += 1
                else:
                    table.append(nothing)
        return table


def cut(table: list[float], begin: float, end: float) -> list[float]:
    """Return the table of a motion from `begin` to `end` (seconds), standing included."""
    found: list[float] = []
    first: float = table[0]
    last: float = table[len(table) - _WIDTH + 1]
    if begin < first:
        _append_still(found, table, 0, begin, begin, min(first, end))
    o: cython.Py_ssize_t
    row: cython.Py_ssize_t
    for row in range(len(table) // _WIDTH):
        o = row * _WIDTH
        since: float = table[o]
        until: float = table[o + 1]
        if since >= end:
            break
        if begin >= until:
            continue
        if begin <= since:
            found.extend(table[o : o + _WIDTH])
            found[len(found) - _WIDTH + 1] = min(end, until)
            continue
        u: float = begin - since
        found.append(begin)
        found.append(min(end, until))
        _append_later(found, table, o + 2, u)
        _append_later(found, table, o + 6, u)
        _append_later(found, table, o + 10, u)
    if end > last or not found:
        # After its end a motion stands; the last piece that has begun says where.
        stands: float = max(begin, last) if end > last else begin
        o = len(table) - _WIDTH
        while o > 0 and table[o] > stands:
            o -= _WIDTH
        _append_still(found, table, o, stands, stands, end)
    return found


def _append_still(
    found: list[float],
    table: list[float],
    o: cython.Py_ssize_t,
    t: float,
    begin: float,
    end: float,
) -> cython.int:
    """Append standing from `begin` to `end` where the piece at `o` is at `t`, held within it."""
    since: float = table[o]
    u: float = min(max(t, since), table[o + 1]) - since
    found.append(begin)
    found.append(end)
    k: cython.Py_ssize_t
    for k in range(o + 2, o + _WIDTH, 4):
        found.append(table[k] + u * (table[k + 1] + u * (table[k + 2] + u * table[k + 3])))
        found.append(0.0)
        found.append(0.0)
        found.append(0.0)
    return 0


def _append_later(
    found: list[float], table: list[float], k: cython.Py_ssize_t, u: float
) -> cython.int:
    """Append the cubic at `k`, counted from `u` seconds later."""
    c1: float = table[k + 1]
    c2: float = table[k + 2]
    c3: float = table[k + 3]
    found.append(table[k] + u * (c1 + u * (c2 + u * c3)))
    found.append(c1 + u * (2 * c2 + u * 3 * c3))
    found.append(c2 + u * 3 * c3)
    found.append(c3)
    return 0


def along_legs(
    corners: list[float],
    lengths: list[float],
    speeds: list[float],
    top: float,
    rate: float,
    start: float,
) -> list[float]:
    """Return the table of the fastest walk through `corners` (x and y of each in turn).

    It has the given speed at each of them (m/s), `top` at most, and speeds up and slows down at
    `rate` (m/s²); `lengths` are those of the legs (metres), and it begins at `start` (seconds). Its
    rotation is the heading.
    """
    table: list[float] = []
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
                table.append(begin)
                table.append(end)
                table.append(x + gone * c)
                table.append(speed * c)
                table.append(half * c)
                # No jerk; the product gives the zero the sign that it has where pieces are made one
                # by one.
                table.append(0.0 * c)
                table.append(y + gone * s)
                table.append(speed * s)
                table.append(half * s)
                table.append(0.0 * s)
                table.append(heading)
                table.append(0.0)
                table.append(0.0)
                table.append(0.0)
                begin = end
                gone += duration * (speed + duration * slope / 2)
    return table
