"""Arcs of vehicles: velocities along axes that turn with the vehicle, as cubics of time.

Where the vehicle does not turn, the cubics are exact. Where it drives and turns at once, they are
Hermite's between places and velocities on the arc, which are integrated by Gauss's rule.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .kernels.braking import braking
from .machines import AxisLimits, AxisState
from .motion import Cubic, Piece, shift, still, value

ARC = 1e-5
"""Metres. The spline of an arc stays this close to it."""

_HASTE = 1e-3, 1e-6
"""m/s. Largest error of the speed on an arc: where the vehicle is slow, and at its top speed."""

_SHARE = 0.9999
"""Share of the top speeds that a twist uses at most, so that arcs need few cubics."""

_BEND = 0.5
"""Radians. A cubic of an arc turns by no more."""

_NODES, _WEIGHTS = (half.tolist() for half in np.polynomial.legendre.leggauss(6))

NO_TIME = 1e-12
"""Seconds. Shorter phases are left out."""

Pose = tuple[float, float, float]
"""x, y in metres, rotation in radians."""

_Quadratic = tuple[float, float, float]
"""Coefficients c of c[0] + c[1] u + c[2] u²."""

Phase = tuple[float, _Quadratic]
"""Duration (s) of a phase, and its velocity."""


def profile(now: AxisState, target: float, seconds: float, limits: AxisLimits) -> list[Phase]:
    """Return the velocity of an axis that changes to `target`, and stops after `seconds`."""
    most = _SHARE * limits.max_speed
    phases = _change(now.velocity, now.acceleration, min(max(target, -most), most), limits)
    if seconds <= 0:
        return _change(now.velocity, now.acceleration, 0.0, limits)
    kept: list[Phase] = []
    left, velocity, acceleration = seconds, now.velocity, now.acceleration
    for duration, (v, a, j) in [*phases, (math.inf, (min(max(target, -most), most), 0.0, 0.0))]:
        lasts = min(duration, left)
        kept.append((lasts, (v, a, j)))
        velocity, acceleration = v + lasts * (a + lasts * j), a + 2 * lasts * j
        left -= lasts
        if left <= 0:
            break
    return kept + _change(velocity, acceleration, 0.0, limits)


def _change(velocity: float, acceleration: float, target: float, limits: AxisLimits) -> list[Phase]:
    """Return the fastest change of an axis's velocity: a stop, seen from the target velocity."""
    rows = braking(0.0, velocity - target, acceleration, limits.max_acceleration, limits.max_jerk)
    return [
        (rows[k], (rows[k + 2] + target, 2 * rows[k + 3], 3 * rows[k + 4]))
        for k in range(0, len(rows), 5)
        if rows[k] > NO_TIME
    ]


def pieces_of_axes(
    pose: Pose, axes: Sequence[Sequence[Phase]], start: float, top_speed: float
) -> list[Piece]:
    """Return the pieces of a motion whose axes in the vehicle's frame have these velocities."""
    ends = [0.0]
    for phases in axes:
        t = 0.0
        for duration, _ in phases:
            t += duration
            ends.append(t)
    ends = sorted(ends)
    pieces: list[Piece] = []
    for begin, end in pairwise([0.0, *(b for a, b in pairwise(ends) if b - a > NO_TIME)]):
        ahead, aside, turning = (_at(phases, begin) for phases in axes)
        part = _part(pose, (ahead, aside, turning), start + begin, start + end, top_speed)
        pieces += part
        last = part[-1]
        u = last.end - last.begin
        pose = (value(last.x, u), value(last.y, u), value(last.rotation, u))
    return pieces or [still(pose, start, start)]


def _at(phases: Sequence[Phase], t: float) -> _Quadratic:
    """Return the velocity from `t` on; 0 after the last phase."""
    begin = 0.0
    for duration, (v, a, j) in phases:
        if t < begin + duration - NO_TIME:
            u = max(t - begin, 0.0)
            return (v + u * (a + u * j), a + 2 * u * j, j)
        begin += duration
    return (0.0, 0.0, 0.0)


def _part(
    pose: Pose,
    velocity: tuple[_Quadratic, _Quadratic, _Quadratic],
    begin: float,
    end: float,
    top_speed: float,
) -> list[Piece]:
    """Return the pieces of a stretch in which each axis's velocity is one quadratic."""
    ahead, aside, turning = velocity
    x, y, rotation = pose
    heading = _integral(rotation, turning)
    if not any(ahead + aside):
        return [Piece(begin, end, constant(x), constant(y), heading)]
    c, s = math.cos(rotation), math.sin(rotation)
    if not any(turning):
        vx = tuple(p * c - q * s for p, q in zip(ahead, aside, strict=True))
        vy = tuple(p * s + q * c for p, q in zip(ahead, aside, strict=True))
        return [Piece(begin, end, _integral(x, vx), _integral(y, vy), heading)]
    count = _count(velocity, end - begin, top_speed)
    times = [begin + (end - begin) * k / count for k in range(count)]
    place = complex(x, y)
    pieces = []
    for since, until in pairwise((*times, end)):
        low, high = since - begin, until - begin
        h, middle = high - low, (low + high) / 2
        step = sum(
            weight * _velocity(ahead, aside, heading, middle + node * h / 2)
            for node, weight in zip(_NODES, _WEIGHTS, strict=True)
        ) * (h / 2)
        v, w = _velocity(ahead, aside, heading, low), _velocity(ahead, aside, heading, high)
        # Hermite's cubic: place and velocity at both ends are those of the arc.
        bend, twist = 3 * step / h**2 - (2 * v + w) / h, -2 * step / h**3 + (v + w) / h**2
        along_x = (place.real, v.real, bend.real, twist.real)
        along_y = (place.imag, v.imag, bend.imag, twist.imag)
        pieces.append(Piece(since, until, along_x, along_y, shift(heading, low)))
        place += step
    return pieces


def _velocity(ahead: _Quadratic, aside: _Quadratic, heading: Cubic, u: float) -> complex:
    """Return the velocity over the floor as a complex number."""
    along = complex(
        ahead[0] + u * (ahead[1] + u * ahead[2]), aside[0] + u * (aside[1] + u * aside[2])
    )
    angle = value(heading, u)
    return along * complex(math.cos(angle), math.sin(angle))


def _count(
    velocity: tuple[_Quadratic, _Quadratic, _Quadratic], duration: float, top_speed: float
) -> int:
    """Return into how many cubics an arc is divided.

    Hermite's cubic over h seconds is off by h⁴ M / 384 at most, and its velocity by √3 h³ M / 216,
    with M the greatest fourth derivative of the place (A. Quarteroni, R. Sacco and F. Saleri,
    "Numerical Mathematics", 2nd edition 2007, 8.4). With the velocity U exp(i θ) in complex
    numbers, that is |3 i ω U'' + 3 i ω' U' + i ω'' U - 3 ω² U' - 3 ω ω' U - i ω³ U|, of which the
    real terms change the speed of a differential drive.
    """
    (a, b, w) = velocity
    speed, turn = math.hypot(_most(a, duration), _most(b, duration)), _most(w, duration)
    pull = math.hypot(_most_slope(a, duration), _most_slope(b, duration))
    spin, jerk, twist = _most_slope(w, duration), 2 * math.hypot(a[2], b[2]), 2 * abs(w[2])
    along = 3 * turn**2 * pull + 3 * turn * spin * speed
    across = 3 * turn * jerk + 3 * spin * pull + twist * speed + turn**3 * speed
    if any(b):
        along += across
    slow, fast = _HASTE
    haste = min(max(top_speed - speed, fast), slow)
    per_second: float = max(
        ((along + across) / (384 * ARC)) ** (1 / 4),
        (2 * along * _CHANGE / haste) ** (1 / 3),
        (2 * (along + across) * turn * _CHANGE / haste) ** (1 / 4),
        turn / _BEND,
    )
    return max(1, math.ceil(duration * per_second))


_CHANGE = math.sqrt(3) / 216


def _most(velocity: _Quadratic, duration: float) -> float:
    """Return the greatest speed of an axis in a stretch."""
    v, a, j = velocity
    ends = [0.0, duration]
    if j and 0 < -a / (2 * j) < duration:
        ends.append(-a / (2 * j))
    return max(abs(v + u * (a + u * j)) for u in ends)


def _most_slope(velocity: _Quadratic, duration: float) -> float:
    return max(abs(velocity[1]), abs(velocity[1] + 2 * duration * velocity[2]))


def _integral(begin: float, velocity: Sequence[float]) -> Cubic:
    return (begin, velocity[0], velocity[1] / 2, velocity[2] / 3)


def constant(value: float) -> Cubic:
    """Return the cubic that has this value at all times."""
    return (value, 0.0, 0.0, 0.0)
