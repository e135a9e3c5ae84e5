"""Motions as tables: states at a time, parts, continuity, and axes with separate phases."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import POSE_WIDTH, Place, flat

if not cython.compiled:
    from math import atan2, copysign, sqrt

    from .cubics import *

Triple = tuple[float, float, float]

_WIDTH: cython.Py_ssize_t = POSE_WIDTH
_SHORTEST: float = 1e-12  # seconds; shorter differences between ends of phases are rounding


def state(table: Numbers, t: float) -> tuple[Triple, Triple, Triple]:
    """Return position, velocity and acceleration of a motion at `t` (s), limited to its span."""
    row: PosePieces = poses(table)
    moving: cython.bint = row[0].begin <= t < end_of(table)
    return evaluate(table, max(pose_at(table, t), 0), t, moving)


def evaluate(
    table: Numbers, row: cython.Py_ssize_t, t: float, moving: bool
) -> tuple[Triple, Triple, Triple]:
    """Return position, velocity and acceleration of a piece at `t`, limited to its span."""
    piece: PosePiece = poses(table)[row]
    x: Cubic = piece.x
    y: Cubic = piece.y
    r: Cubic = piece.rotation
    u: float = elapsed(piece.begin, piece.end, t)
    position = value(x, u), value(y, u), value(r, u)
    if not moving:
        return position, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    velocity = slope(x, u), slope(y, u), slope(r, u)
    return position, velocity, (second_slope(x, u), second_slope(y, u), second_slope(r, u))


def instant(table: Numbers, t: float) -> PosePiece:
    """Return the piece of a motion from `t` (s) on, or a rest before and after the motion."""
    piece: PosePiece = poses(table)[max(pose_at(table, t), 0)]
    if not poses(table)[0].begin <= t < end_of(table):
        return _rest_at(piece, t, t)
    u: float = elapsed(piece.begin, piece.end, t)
    return PosePiece(t, piece.end, shift(piece.x, u), shift(piece.y, u), shift(piece.rotation, u))


def breaks(table: Numbers, tolerance: float) -> list[int]:
    """Return the pieces that end before they begin, or do not continue the previous one.

    A piece must begin when the previous one ends, and at most `tolerance` metres from its end.
    """
    broken: list[int] = []
    row: PosePieces = poses(table)
    k: cython.Py_ssize_t
    for k in range(pose_count(table)):
        p: PosePiece = row[k]
        if p.end < p.begin or (
            k > 0 and (row[k - 1].end != p.begin or _gap(row[k - 1], p) > tolerance)
        ):
            broken.append(k)
    return broken


def _gap(piece: PosePiece, after: PosePiece) -> float:
    """Return the distance between the end of a piece and the begin of another (metres)."""
    u: float = piece.end - piece.begin
    return norm(value(piece.x, u) - after.x.p, value(piece.y, u) - after.y.p)


def rest(begin: float, end: float, x: float, y: float, rotation: float) -> Numbers:
    """Return the table of a rest at `x`, `y` (metres) from `begin` to `end` (seconds).

    The body is turned by `rotation` (radians).
    """
    table: Numbers = pose_room(1)
    poses(table)[0] = PosePiece(begin, end, constant(x), constant(y), constant(rotation))
    return table


def phases_of(
    state: list[float],
    durations: list[float],
    accelerations: list[float],
    jerks: list[float],
) -> Numbers:
    """Return the phases of an axis from position, velocity and acceleration on.

    Without a jerk limit, only the acceleration jumps between phases.
    """
    table: Numbers = phase_room(max(len(durations), 1))
    row: Phases = phases(table)
    count: cython.Py_ssize_t = 0
    c: Cubic = Cubic(state[0], state[1], state[2] / 2, 0.0)
    k: cython.Py_ssize_t
    for k in range(len(durations)):
        if durations[k] > 0.0:
            c = Cubic(c.p, c.v, accelerations[k] / 2, jerks[k] / 6)
            row[count] = Phase(durations[k], c)
            count += 1
            c = shift(c, durations[k])
    if count == 0:
        row[0] = Phase(0.0, c)
        count = 1
    phase_cut(table, count)
    return table


def scaled(table: Numbers, begin: float, share: float) -> Numbers:
    """Return the phases of an axis that moves from `begin` on by a share of another's motion."""
    phases_of_share: Numbers = phase_room(phase_count(table))
    k: cython.Py_ssize_t
    for k in range(phase_count(table)):
        phase: Phase = phases(table)[k]
        phases(phases_of_share)[k] = Phase(phase.duration, along(begin, share, phase.c))
    return phases_of_share


def merge_axes(axes: list[Numbers], start: float) -> Numbers:
    """Return the table of a motion from `start` on of three axes with separate phases.

    An axis is at rest after its last phase. The motion is divided where an axis changes.
    """
    axis: cython.Py_ssize_t
    limit: cython.Py_ssize_t = 0
    for axis in range(3):
        limit += phase_count(axes[axis])
    table: Numbers = pose_room(limit)  # an axis changes at the end of every piece
    count: cython.Py_ssize_t = 0
    now: list[cython.Py_ssize_t] = [0, 0, 0]
    begins: Numbers = room(3)
    since: Doubles = at(begins)
    since[0] = since[1] = since[2] = 0.0
    begin: float = start
    lower: float = 0.0
    while True:
        # The next change after `lower` is the earliest end of a current phase.
        upper: float = INFINITY
        for axis in range(3):
            phase: Phases = phases(axes[axis])
            k: cython.Py_ssize_t = now[axis]
            last: cython.Py_ssize_t = phase_count(axes[axis])
            while k < last and since[axis] + phase[k].duration <= lower:
                since[axis] += phase[k].duration
                k += 1
            now[axis] = k
            if k < last:
                upper = min(upper, since[axis] + phase[k].duration)
        if upper == INFINITY:
            pose_cut(table, count)
            return table
        # Axes that end together differ by rounding. The next piece absorbs such a sliver, because
        # it begins where the last one ended.
        if upper - lower >= _SHORTEST or count == 0:
            poses(table)[count] = PosePiece(
                begin,
                start + upper,
                _axis_from(axes[0], now[0], lower - since[0]),
                _axis_from(axes[1], now[1], lower - since[1]),
                _axis_from(axes[2], now[2], lower - since[2]),
            )
            begin = start + upper
            count += 1
        lower = upper


def _axis_from(table: Numbers, k: cython.Py_ssize_t, u: float) -> Cubic:
    """Return the cubic of an axis from `u` seconds after the begin of a phase, or of its rest."""
    if k < phase_count(table):
        return shift(phases(table)[k].c, u)
    last: Phase = phases(table)[k - 1]
    return constant(value(last.c, last.duration))


def walked_and_stood(table: Numbers, since: float, until: float) -> tuple[float, float]:
    """Return the length of a walk from `since` on (m), and its time at rest until `until` (s).

    Its pieces are straight and never turn back, so each is as long as its chord.
    """
    walked: float = 0.0
    stood: float = 0.0
    k: cython.Py_ssize_t
    for k in range(pose_count(table)):
        p: PosePiece = poses(table)[k]
        if p.end < since:
            continue
        if is_at_rest(p.x, p.y):
            stood += max(min(p.end, until) - max(p.begin, since), 0.0)
            continue
        dx: float = gain(p.x, p.end - p.begin)
        dy: float = gain(p.y, p.end - p.begin)
        if p.begin < since:
            dx -= gain(p.x, since - p.begin)
            dy -= gain(p.y, since - p.begin)
        walked += norm(dx, dy)
    return walked, stood


class Pack:
    """Compressed pieces: a bit mask of the numbers that are stored, and these numbers.

    A begin equal to the previous end and zeros are left out, which is half of a walk. A negative
    zero is stored.
    """

    def __init__(self) -> None:
        self.count = 0
        self.packed = array("d")
        self.last: Numbers = room(0)

    def add(self, table: Numbers, begin: float, end: float, tolerance: float) -> bool:
        """Add a motion from `begin` to `end` (s): see `between`.

        Return whether it begins farther than `tolerance` metres from the last end.
        """
        before: Numbers = self.last
        after: Numbers = between(table, begin, end)
        packed: Numbers = room(len(after) + pose_count(after))
        a: Doubles = at(after)
        b: Doubles = at(packed)
        last: cython.Py_ssize_t = pose_count(before) - 1
        ended: float = poses(before)[last].end if last >= 0 else 0.0
        i: cython.Py_ssize_t = 0
        j: cython.Py_ssize_t = 0
        k: cython.Py_ssize_t
        piece: cython.Py_ssize_t
        for piece in range(pose_count(after)):
            mask: cython.int = 0
            bits: cython.Py_ssize_t = i
            i += 1
            for k in range(_WIDTH):
                usual: float = 0.0 if k > 0 else ended
                if a[j] != usual or copysign(1.0, a[j]) != copysign(1.0, usual):
                    mask |= 1 << k
                    b[i] = a[j]
                    i += 1
                j += 1
            b[bits] = mask
            ended = poses(after)[piece].end
        cut(packed, i)
        self.packed.extend(packed)
        self.count += pose_count(after)
        self.last = after
        return last >= 0 and _gap(poses(before)[last], poses(after)[0]) > tolerance

    def pieces(self) -> Numbers:
        """Return the table of all motions."""
        table: Numbers = pose_room(self.count)
        a: Doubles = at(table)
        b: Doubles = at(self.packed)
        ended: float = 0.0
        i: cython.Py_ssize_t = 0
        j: cython.Py_ssize_t = 0
        k: cython.Py_ssize_t
        piece: cython.Py_ssize_t
        for piece in range(self.count):
            mask: cython.int = int(b[i])
            i += 1
            for k in range(_WIDTH):
                a[j] = 0.0 if k > 0 else ended
                if mask & (1 << k):
                    a[j] = b[i]
                    i += 1
                j += 1
            ended = poses(table)[piece].end
        return table


def between(table: Numbers, begin: float, end: float) -> Numbers:
    """Return the table of a motion from `begin` to `end` (s), rests included."""
    row: PosePieces = poses(table)
    rows: cython.Py_ssize_t = pose_count(table)
    motion: Numbers = pose_room(rows + 2)
    pieces: PosePieces = poses(motion)
    count: cython.Py_ssize_t = 0
    last: float = end_of(table)
    k: cython.Py_ssize_t
    if begin < row[0].begin:
        pieces[0] = _rest_at(row[0], begin, min(row[0].begin, end))
        count = 1
    for k in range(rows):
        p: PosePiece = row[k]
        if p.begin >= end:
            break
        if begin >= p.end:
            continue
        if begin > p.begin:
            u: float = begin - p.begin
            p = PosePiece(begin, p.end, shift(p.x, u), shift(p.y, u), shift(p.rotation, u))
        pieces[count] = PosePiece(p.begin, min(end, p.end), p.x, p.y, p.rotation)
        count += 1
    if end > last or count == 0:
        # After its end, a motion rests where the last piece that has begun ends.
        since: float = max(begin, last) if end > last else begin
        k = rows - 1
        while k > 0 and row[k].begin > since:
            k -= 1
        pieces[count] = _rest_at(row[k], since, end)
        count += 1
    pose_cut(motion, count)
    return motion


def _rest_at(piece: PosePiece, begin: float, end: float) -> PosePiece:
    """Return a rest from `begin` to `end` at the place of a piece at `begin`."""
    u: float = elapsed(piece.begin, piece.end, begin)
    return PosePiece(
        begin,
        end,
        constant(value(piece.x, u)),
        constant(value(piece.y, u)),
        constant(value(piece.rotation, u)),
    )


def along_legs(
    corners: list[Place],
    lengths: list[float],
    speeds: list[float],
    top: float,
    rate: float,
    start: float,
) -> Numbers:
    """Return the table of the fastest walk through `corners`.

    It has the given speed at each of them (m/s), at most `top` between them, and changes speed at
    `rate` (m/s²). `lengths` are those of the segments (m), and it begins at `start` (s). Its
    rotation is the heading.
    """
    table: Numbers = pose_room(3 * len(lengths))
    row: PosePieces = poses(table)
    places: Numbers = flat(corners)
    corner: Positions = positions_of(places)
    count: cython.Py_ssize_t = 0
    begin: float = start
    k: cython.Py_ssize_t
    for k in range(len(lengths)):
        x: float = corner[k].x
        y: float = corner[k].y
        dx: float = corner[k + 1].x - x
        dy: float = corner[k + 1].y - y
        length: float = lengths[k]
        first: float = speeds[k]
        last: float = speeds[k + 1]
        # Speed squared changes by 2 · rate · metres. Up to the peak and down to the last speed fill
        # the segment if (2 p² − first² − last²) / (2 · rate) is its length.
        peak: float = min(top, sqrt((first * first + last * last) / 2 + rate * length))
        peak = max(peak, last)
        change: float = copysign(rate, peak - first)
        rising: float = (peak - first) / change
        falling: float = (peak - last) / rate
        steady: float = length - (first + peak) / 2 * rising - (peak + last) / 2 * falling
        walked: float = 0.0
        phase: cython.int
        for phase in range(3):
            duration: float = rising
            way: Cubic = Cubic(walked, first, change / 2, 0.0)
            if phase == 1:
                duration = max(steady, 0.0) / peak
                way = Cubic(walked, peak, 0.0, 0.0)
            elif phase == 2:
                duration = falling
                way = Cubic(walked, peak, -rate / 2, 0.0)
            if duration > 0.0:
                row[count] = PosePiece(
                    begin,
                    begin + duration,
                    along(x, dx / length, way),
                    along(y, dy / length, way),
                    constant(atan2(dy, dx)),
                )
                count += 1
                begin += duration
                walked += gain(way, duration)
    pose_cut(table, count)
    return table
