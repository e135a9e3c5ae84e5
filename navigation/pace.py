"""Walks in closed form along paths, as `walk`'s, for those who change their pace all the time.

A person among others weighs many courses before taking one, and slows down to speeds below the
one they have. On each leg the speed rises and falls at one acceleration, so that its phases follow
from the speeds at the corners: the forward and backward pass of D. Verscheure et al., "Time-optimal
path tracking for robots", IEEE Transactions on Automatic Control 54 (2009), for a bound on the
length of the acceleration along the path alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from .motion import Motion, Piece
from .walk import corner_speed

Corner = tuple[float, float]

SHORT = 1e-9
"""Metres. Legs shorter than this are left out."""

_HAIR = 1e-9


def paced(
    corners: Sequence[Corner],
    start: float,
    *,
    initial_speed: float = 0.0,
    top_speed: float | Sequence[float],
    max_speed: float,
    max_acceleration: float,
) -> Motion | None:
    """Return a walk along `corners` (x, y in metres) from `start` (seconds) to rest at the last.

    It sets out at `initial_speed` along the first leg, and keeps to `top_speed` as soon as
    `max_acceleration` lets it; corners are taken as `walk` takes them, and never faster than
    `max_speed` (m/s, m/s²). `top_speed` may be a speed for each leg. None where it can't come to
    rest, or slow down enough for a corner.
    """
    legs = [(a, b, math.dist(a, b)) for a, b in itertools.pairwise(corners)]
    given = [top_speed] * len(legs) if isinstance(top_speed, float | int) else top_speed
    tops = [top for leg, top in zip(legs, given, strict=True) if leg[2] > SHORT]
    legs = [leg for leg in legs if leg[2] > SHORT]
    if not legs:
        return None
    gain = 2 * max_acceleration
    caps, gone = [initial_speed], 0.0
    for k, ((a, b, length), (_, c, _)) in enumerate(itertools.pairwise(legs)):
        gone += length
        slowed = math.sqrt(max(initial_speed * initial_speed - gain * gone, 0.0))
        bend = corner_speed(a, b, c, max_acceleration)
        caps.append(min(bend, max_speed, max(min(tops[k], tops[k + 1]), slowed)))
    caps.append(0.0)
    for k in range(len(legs) - 1, -1, -1):
        caps[k] = min(caps[k], math.sqrt(caps[k + 1] ** 2 + gain * legs[k][2]))
    if caps[0] < initial_speed - _HAIR:
        return None
    caps[0] = initial_speed
    pieces: list[Piece] = []
    t = float(start)
    for k, (a, b, length) in enumerate(legs):
        u = caps[k]
        w = caps[k + 1] = min(caps[k + 1], math.sqrt(u * u + gain * length))
        t = _on_leg(pieces, a, b, length, t, _speeds(u, w, length, tops[k], max_acceleration))
    return Motion(tuple(pieces))


def _speeds(
    u: float, w: float, length: float, top: float, acceleration: float
) -> list[tuple[float, float, float]]:
    """Return the (duration, speed, acceleration) of the phases from speed `u` to `w`."""
    peak = math.sqrt(max((2 * acceleration * length + u * u + w * w) / 2, 0.0))
    if u > top or w > top:  # still slowing down
        peak = max(u, w, min(top, peak))
        level = max(top, w)
        if u > level:
            slowing = (u - level) / acceleration
            rest = length - slowing * (u + level) / 2
            return [
                (slowing, u, -acceleration),
                *_speeds(level, w, max(rest, 0.0), level, acceleration),
            ]
        top = level
    peak = max(min(peak, top), u, w)
    rising, falling = (peak - u) / acceleration, (peak - w) / acceleration
    cruise = (length - rising * (u + peak) / 2 - falling * (peak + w) / 2) / peak
    phases = [
        (rising, u, acceleration),
        (max(cruise, 0.0), peak, 0.0),
        (falling, peak, -acceleration),
    ]
    return [phase for phase in phases if phase[0] > 0.0]


def _on_leg(
    pieces: list[Piece],
    a: Corner,
    b: Corner,
    length: float,
    start: float,
    phases: list[tuple[float, float, float]],
) -> float:
    """Add the pieces of the phases on the leg from `a` to `b`; return when it is over."""
    c, s = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    heading = (math.atan2(s, c), 0.0, 0.0, 0.0)
    gone = 0.0
    for duration, v, acc in phases:
        end = start + duration
        if end > start:
            half = acc / 2
            x, y = a[0] + gone * c, a[1] + gone * s
            along_x, along_y = (x, v * c, half * c, 0.0), (y, v * s, half * s, 0.0)
            pieces.append(Piece(start, end, along_x, along_y, heading))
        gone += duration * (v + acc * duration / 2)
        start = end
    return start
