"""Arcs of vehicles: velocities along axes that turn with the vehicle, as cubics of time.

If the vehicle does not turn, the cubics are exact. If it drives and turns, they are Hermite's
between places and velocities on the arc, which are integrated by Gauss's rule.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .braking import braking

if not cython.compiled:
    from math import ceil, cos, pow, sin, sqrt

    from .cubics import *
    from .pieces import between, merge_axes

_ARC: float = 1e-5  # metres; maximum error of the spline of an arc
_HASTE: float = 1e-3  # m/s; maximum error of the speed on an arc if the vehicle is slow,
_LEAST_HASTE: float = 1e-6  # and at its top speed
_SHARE: float = 0.9999  # maximum share of the top speeds for a twist, so that arcs need few cubics
_BEND: float = 0.5  # radians; maximum turn within a cubic
_CHANGE: float = sqrt(3.0) / 216
_SHORTEST: float = 1e-12  # seconds; shorter phases are left out

# Positive nodes of Gauss's rule on an interval of length 2, and their weights.
_NODE_1: float = 0.23861918608319693
_NODE_2: float = 0.6612093864662645
_NODE_3: float = 0.932469514203152
_WEIGHT_1: float = 0.46791393457269137
_WEIGHT_2: float = 0.36076157304813894
_WEIGHT_3: float = 0.17132449237916975


def twist_axis(
    velocity: float,
    acceleration: float,
    target: float,
    seconds: float,
    top: float,
    rate: float,
    jerk: float,
) -> Numbers:
    """Return the phases of an axis that changes to a velocity, and stops after `seconds`.

    Its speed, acceleration and jerk are at most `top`, `rate` and `jerk`. A change of velocity is a
    stop relative to the target.
    """
    table: Numbers = phase_room(7)
    row: Phases = phases(table)
    count: cython.Py_ssize_t = 0
    steady: float = min(max(target, -_SHARE * top), _SHARE * top)
    change: Numbers = braking(0.0, velocity - steady, acceleration, rate, jerk)
    left: float = seconds
    k: cython.Py_ssize_t
    for k in range(phase_count(change) + 1):
        if left <= _SHORTEST:
            break
        phase: Phase = Phase(left, Cubic(0.0, steady, 0.0, 0.0))
        if k < phase_count(change):
            c: Cubic = phases(change)[k].c
            duration: float = phases(change)[k].duration
            if duration <= _SHORTEST:
                continue
            phase = Phase(min(duration, left), Cubic(0.0, c.v + steady, c.a, c.j))
        row[count] = phase
        count += 1
        velocity = slope(phase.c, phase.duration)
        acceleration = second_slope(phase.c, phase.duration)
        left -= phase.duration
    stop: Numbers = braking(0.0, velocity, acceleration, rate, jerk)
    for k in range(phase_count(stop)):
        if phases(stop)[k].duration > _SHORTEST:
            row[count] = phases(stop)[k]
            count += 1
    if count == 0:
        row[0] = Phase(0.0, constant(0.0))
        count = 1
    phase_cut(table, count)
    return table


def arc_table(
    axes: list[Numbers],
    since: float,
    x: float,
    y: float,
    rotation: float,
    start: float,
    top_speed: float,
) -> Numbers:
    """Return the table of a vehicle from the phases of its axes ahead, aside and of turning.

    It begins `since` seconds after the axes, at `x`, `y` and `rotation`, at the time `start`. The
    table is empty if the axes are at rest from then on.
    """
    stretches: Numbers = merge_axes(axes, 0.0)
    if pose_count(stretches) > 0 and since > 0.0:
        stretches = between(stretches, since, max(since, end_of(stretches)))
    row: PosePieces = poses(stretches)
    rows: cython.Py_ssize_t = pose_count(stretches)
    k: cython.Py_ssize_t
    total: cython.Py_ssize_t = 0
    for k in range(rows):
        total += _cubics_of(row[k], top_speed)
    table: Numbers = pose_room(total)
    pieces: PosePieces = poses(table)
    n: cython.Py_ssize_t = 0
    for k in range(rows):
        part: PosePiece = row[k]
        count: cython.Py_ssize_t = _cubics_of(part, top_speed)
        heading: Cubic = Cubic(rotation, part.rotation.v, part.rotation.a, part.rotation.j)
        begin: float = start + (part.begin - since)
        length: float = part.end - part.begin
        end: float = start + (part.end - since)
        i: cython.Py_ssize_t
        for i in range(count):
            low: float = length * i / count
            high: float = length * (i + 1) / count
            pieces[n] = PosePiece(
                begin + low if i > 0 else begin,
                begin + high if i + 1 < count else end,
                constant(x),
                constant(y),
                heading,
            )
            if not _rests(part.x) or not _rests(part.y):
                pieces[n] = _driven(pieces[n], part, low, high)
            n += 1
            last: PosePiece = pieces[n - 1]
            x = value(last.x, last.end - last.begin)
            y = value(last.y, last.end - last.begin)
        rotation = value(heading, length)
    return table


def _driven(piece: PosePiece, part: PosePiece, low: float, high: float) -> PosePiece:
    """Return the piece of a drive from `low` to `high` (s) within a part of constant jerks.

    The place of `piece` is that at its begin. Its heading is relative to the begin of the part.
    """
    heading: Cubic = piece.rotation
    if _rests(part.rotation):
        c: float = cos(heading.p)
        s: float = sin(heading.p)
        a: Cubic = part.x
        b: Cubic = part.y
        return PosePiece(
            piece.begin,
            piece.end,
            Cubic(piece.x.p, a.v * c - b.v * s, a.a * c - b.a * s, a.j * c - b.j * s),
            Cubic(piece.y.p, a.v * s + b.v * c, a.a * s + b.a * c, a.j * s + b.j * c),
            heading,
        )
    h: float = high - low
    middle: float = (low + high) / 2
    # The nodes, and the ends.
    n1: Position = _velocity(part, heading, middle - _NODE_3 * h / 2)
    n2: Position = _velocity(part, heading, middle - _NODE_2 * h / 2)
    n3: Position = _velocity(part, heading, middle - _NODE_1 * h / 2)
    n4: Position = _velocity(part, heading, middle + _NODE_1 * h / 2)
    n5: Position = _velocity(part, heading, middle + _NODE_2 * h / 2)
    n6: Position = _velocity(part, heading, middle + _NODE_3 * h / 2)
    v: Position = _velocity(part, heading, low)
    w: Position = _velocity(part, heading, high)
    return PosePiece(
        piece.begin,
        piece.end,
        _hermite(piece.x.p, v.x, w.x, h, _gauss(n1.x, n2.x, n3.x, n4.x, n5.x, n6.x) * (h / 2)),
        _hermite(piece.y.p, v.y, w.y, h, _gauss(n1.y, n2.y, n3.y, n4.y, n5.y, n6.y) * (h / 2)),
        shift(heading, low),
    )


def _gauss(a: float, b: float, c: float, d: float, e: float, f: float) -> float:
    """Return the integral of a function from -1 to 1 from its values at the nodes."""
    outer: float = _WEIGHT_3 * a + _WEIGHT_2 * b + _WEIGHT_1 * c
    return outer + _WEIGHT_1 * d + _WEIGHT_2 * e + _WEIGHT_3 * f


def _hermite(p: float, v: float, w: float, h: float, step: float) -> Cubic:
    """Return the cubic over h seconds from p to p + `step` with velocities v and w at the ends."""
    bend: float = 3 * step / (h * h) - (2 * v + w) / h
    twist: float = -2 * step / (h * h * h) + (v + w) / (h * h)
    return Cubic(p, v, bend, twist)


def _velocity(part: PosePiece, heading: Cubic, u: float) -> Position:
    """Return the velocity over the floor."""
    ahead: float = slope(part.x, u)
    aside: float = slope(part.y, u)
    angle: float = value(heading, u)
    c: float = cos(angle)
    s: float = sin(angle)
    return Position(ahead * c - aside * s, ahead * s + aside * c)


def _cubics_of(part: PosePiece, top_speed: float) -> cython.Py_ssize_t:
    """Return the number of cubics for an arc.

    The error of Hermite's cubic over h seconds is at most h⁴ M / 384, and that of its velocity √3
    h³ M / 216, with M the maximum fourth derivative of the place (A. Quarteroni, R. Sacco and F.
    Saleri, "Numerical Mathematics", 2nd edition 2007, 8.4). With the velocity U exp(i θ) in complex
    numbers, that is |3 i ω U'' + 3 i ω' U' + i ω'' U - 3 ω² U' - 3 ω ω' U - i ω³ U|, of which the
    real terms change the speed of a differential drive.
    """
    a: Cubic = part.x
    b: Cubic = part.y
    w: Cubic = part.rotation
    length: float = part.end - part.begin
    if (_rests(a) and _rests(b)) or _rests(w):
        return 1
    speed: float = norm(_top_speed(a, length), _top_speed(b, length))
    turn: float = _top_speed(w, length)
    pull: float = norm(_top_acceleration(a, length), _top_acceleration(b, length))
    spin: float = _top_acceleration(w, length)
    jerk: float = 6 * norm(a.j, b.j)
    twist: float = 6 * abs(w.j)
    along: float = 3 * turn * turn * pull + 3 * turn * spin * speed
    across: float = 3 * turn * jerk + 3 * spin * pull + twist * speed + turn * turn * turn * speed
    if not _rests(b):
        along += across
    haste: float = min(max(top_speed - speed, _LEAST_HASTE), _HASTE)
    per_second: float = max(
        max(
            sqrt(sqrt((along + across) / (384 * _ARC))),
            pow(2 * along * _CHANGE / haste, 1.0 / 3.0),
        ),
        max(sqrt(sqrt(2 * (along + across) * turn * _CHANGE / haste)), turn / _BEND),
    )
    count: cython.Py_ssize_t = int(ceil(length * per_second))
    return max(count, 1)


def _rests(c: Cubic) -> bool:
    """Return whether an axis does not move."""
    return c.v == 0.0 and c.a == 0.0 and c.j == 0.0


def _top_speed(c: Cubic, length: float) -> float:
    """Return the maximum speed of an axis in a stretch."""
    greatest: float = max(abs(slope(c, 0.0)), abs(slope(c, length)))
    if c.j != 0.0 and 0.0 < -c.a / (3 * c.j) < length:
        greatest = max(greatest, abs(slope(c, -c.a / (3 * c.j))))
    return greatest


def _top_acceleration(c: Cubic, length: float) -> float:
    """Return the maximum acceleration of an axis in a stretch."""
    return max(abs(second_slope(c, 0.0)), abs(second_slope(c, length)))
