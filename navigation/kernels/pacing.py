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

from .walks import DEVIATION, NOWHERE

if not cython.compiled:
    from math import atan2, inf, sqrt

    INFINITY = inf
else:
    from cython.cimports.libc.math import INFINITY, atan2, sqrt

_SHORT: float = NOWHERE
_DEVIATION: float = DEVIATION
_HAIR: float = 1e-9  # m/s


def walk_table(
    corners: list[float],
    tops: list[float],
    start: float,
    initial_speed: float,
    max_speed: float,
    acceleration: float,
    table: list[float],
) -> bool:
    """Add the rows of a walk along `corners` (x and y of each in turn) from `start` on to `table`.

    It sets out at `initial_speed` along the first leg, keeps to each leg's speed of `tops` as soon
    as `acceleration` lets it, and ends in a standing for ever; corners are taken as `walk` takes
    them, and never faster than `max_speed`. Return False, and leave the table, where it can't come
    to rest, or slow down enough for a corner.
    """
    gain: float = 2 * acceleration
    legs: list[float] = []  # of each: x and y where it begins, direction, length, top speed
    caps: list[float] = []  # the highest speed at which each may begin
    gone: float = 0.0
    c: float = 0.0
    s: float = 0.0
    length: float = 0.0
    k: cython.Py_ssize_t
    x: float
    y: float
    dx: float
    dy: float
    before: float
    slowed: float
    cap: float
    shorter: float
    top: float = INFINITY
    for k in range(0, len(corners) - 2, 2):
        x = corners[k]
        y = corners[k + 1]
        dx = corners[k + 2] - x
        dy = corners[k + 3] - y
        before = length
        length = sqrt(dx * dx + dy * dy)
        if length <= _SHORT:
            length = before
            continue
        dx /= length
        dy /= length
        if len(caps) == 0:
            caps.append(initial_speed)
        else:
            # One who sets out too fast for a leg can't be asked for less than what braking leaves
            # there.
            slowed = sqrt(max(initial_speed * initial_speed - gain * gone, 0.0))
            cap = tops[k // 2]
            cap = min(max_speed, max(min(top, cap), slowed))
            shorter = before if before < length else length
            caps.append(min(cap, bend_speed(c * dx + s * dy, shorter, acceleration)))
        c = dx
        s = dy
        top = tops[k // 2]
        gone += length
        legs.append(x)
        legs.append(y)
        legs.append(c)
        legs.append(s)
        legs.append(length)
        legs.append(top)
    count: cython.Py_ssize_t = len(caps)
    if count == 0:
        return False
    caps.append(0.0)
    speed: float
    # Backwards: nowhere faster than what lets one slow down for all that comes.
    for k in range(count - 1, -1, -1):
        speed = caps[k + 1]
        length = legs[6 * k + 4]
        cap = caps[k]
        caps[k] = min(cap, sqrt(speed * speed + gain * length))
    cap = caps[0]
    if cap < initial_speed - _HAIR:
        return False
    u: float = initial_speed
    t: float = start
    w: float
    for k in range(count):
        length = legs[6 * k + 4]
        cap = caps[k + 1]
        # Forwards: nor faster than one can have become. Both together are the fastest.
        w = min(cap, sqrt(u * u + gain * length))
        x = legs[6 * k]
        y = legs[6 * k + 1]
        c = legs[6 * k + 2]
        s = legs[6 * k + 3]
        top = legs[6 * k + 5]
        t = _leg(table, t, x, y, c, s, length, u, w, top, acceleration)
        u = w
    x = corners[len(corners) - 2]
    y = corners[len(corners) - 1]
    _add(table, t, INFINITY, x, 0.0, 0.0, y, 0.0, 0.0)
    return True


def turned(table: list[float], heading: float) -> list[float]:
    """Return the table of the motion along a walk: turned to where it goes, standing left out.

    Its rows are those of `pieces`; until it goes anywhere it is turned by `heading` (radians).
    """
    found: list[float] = []
    o: cython.Py_ssize_t
    for o in range(0, len(table) - 10, 10):
        if table[o + 3] != 0.0 or table[o + 7] != 0.0:
            heading = atan2(table[o + 7], table[o + 3])
        elif table[o + 4] != 0.0 or table[o + 8] != 0.0:
            heading = atan2(table[o + 8], table[o + 4])
        found.extend(table[o : o + 10])
        found.append(heading)
        found.append(0.0)
        found.append(0.0)
        found.append(0.0)
    return found


def bend_speed(cosine: float, shorter: float, acceleration: float) -> float:
    """Return the speed (m/s) of a turn between two legs, of which one is `shorter` (metres).

    `cosine` is that of the turn. This is `corner_speed` without an angle: cos(φ / 2) and tan(φ / 2)
    follow from cos φ, which is at hand here. The last bits differ.
    """
    half: float = sqrt(max((1 + cosine) / 2, 0.0))  # the cosine of half the turn
    if half >= 1.0:
        return INFINITY
    by_deviation: float = _DEVIATION * half / (1 - half)
    by_length: float = shorter / 2 * half / sqrt(1 - half * half)
    return sqrt(acceleration * min(by_deviation, by_length))


def _leg(
    table: list[float],
    t: float,
    x: float,
    y: float,
    c: float,
    s: float,
    length: float,
    u: float,
    w: float,
    top: float,
    acceleration: float,
) -> float:
    """Add the rows of a leg in direction c, s from speed `u` to `w`; return when it is over."""
    gone: float = 0.0
    level: float = max(top, w)
    duration: float
    if u > level:  # still slowing down
        duration = (u - level) / acceleration
        t = _phase(table, t, x, y, c, s, gone, duration, u, -acceleration)
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
    t = _phase(table, t, x, y, c, s, gone, rising, u, acceleration)
    gone += rising * (u + peak) / 2
    slowing: float = falling * (peak + w) / 2
    cruise: float = max((length - gone - slowing) / peak, 0.0)
    t = _phase(table, t, x, y, c, s, gone, cruise, peak, 0.0)
    gone += cruise * peak
    return _phase(table, t, x, y, c, s, gone, falling, peak, -acceleration)


def _phase(
    table: list[float],
    t: float,
    x: float,
    y: float,
    c: float,
    s: float,
    gone: float,
    duration: float,
    v: float,
    acceleration: float,
) -> float:
    """Add the row of a phase that begins `gone` metres along a leg; return when it is over."""
    end: float = t + duration
    if end > t:
        half: float = acceleration / 2
        _add(table, t, end, x + gone * c, v * c, half * c, y + gone * s, v * s, half * s)
    return end


def _add(
    table: list[float],
    begin: float,
    end: float,
    x: float,
    vx: float,
    ax: float,
    y: float,
    vy: float,
    ay: float,
) -> int:
    """Add a row to a table."""
    table.append(begin)
    table.append(end)
    table.append(x)
    table.append(vx)
    table.append(ax)
    table.append(0.0)
    table.append(y)
    table.append(vy)
    table.append(ay)
    table.append(0.0)
    return 0


def stand(table: list[float], since: float, until: float, x: float, y: float) -> None:
    """Add standing at x, y (metres) from `since` until then (seconds) to a table."""
    _add(table, since, until, x, 0.0, 0.0, y, 0.0, 0.0)
