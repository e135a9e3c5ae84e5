"""Following: who walks ahead the same way, and keeps somebody below their top speed.

For the tables see `discs`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .discs import ROW

if not cython.compiled:
    from math import sqrt

    from .numbers import Doubles, Numbers, at
else:
    from cython.cimports.libc.math import sqrt
    from cython.cimports.navigation.kernels.numbers import Doubles, Numbers, at

_R: cython.Py_ssize_t = ROW
_X: cython.Py_ssize_t = 2  # where the coefficients of x begin in it
_Y: cython.Py_ssize_t = 6
SLOW: float = 0.05
"""m/s. The direction of whoever is slower is not that of their velocity."""

_SLOW: float = SLOW


def followed(
    near: list[cython.Py_ssize_t],
    tables: list[Numbers],
    radii: Numbers,
    t: float,
    sees: float,
    x: float,
    y: float,
    c: float,
    s: float,
    own: float,
    gap: float,
    ahead: float,
    top_speed: float,
    same_way: float,
    beside: float,
    slow: list[cython.Py_ssize_t],
) -> cython.Py_ssize_t:
    """Return who of those `near` keeps somebody below `top_speed` (m/s) most; -1 for nobody.

    That is at `t` (seconds) for somebody of radius `own` at `x`, `y` who walks in the direction
    with the cosine `c` and the sine `s`: who walks ahead of them, the same way (the cosine between
    the directions is above `same_way`), and leaves them no room for their time `gap` at that speed
    once they have come to it in `ahead` seconds, by the speed over the next that one `sees`. It is
    nobody if somebody ahead comes the other way, at most `beside` metres to either side. `tables`
    and `radii` are everybody's; `slow` receives those ahead who hardly move: they may be among
    those who come, or who are followed.
    """
    found: cython.Py_ssize_t = -1
    least: float = top_speed
    i: cython.Py_ssize_t
    for i in range(len(near)):
        k: cython.Py_ssize_t = near[i]
        table: Numbers = tables[k]
        row: Doubles = at(table)
        o: cython.Py_ssize_t = 0
        # The last row never ends. What was over by then is passed.
        while row[o + 1] <= t:
            o += _R
        u: float = max(t - row[o], 0.0)
        ox: float = _place(row, o + _X, u)
        oy: float = _place(row, o + _Y, u)
        along: float = (ox - x) * c + (oy - y) * s
        away: float = abs((oy - y) * c - (ox - x) * s)
        touch: float = own + at(radii)[k]
        if along <= 0.0 or (away >= beside and away >= touch):
            continue
        vx: float = row[o + 3] + u * (2 * row[o + 4] + u * 3 * row[o + 5])
        vy: float = row[o + 7] + u * (2 * row[o + 8] + u * 3 * row[o + 9])
        speed: float = sqrt(vx * vx + vy * vy)
        # Of somebody who hardly moves the velocity gives no direction; the caller knows their
        # route.
        if speed <= _SLOW or row[o] > t:
            slow.append(near[i])
            continue
        same: float = (vx * c + vy * s) / speed
        # A gap kept before somebody who comes would only draw them into it.
        if same < -same_way and away < beside:
            del slow[:]
            return -1
        if same <= same_way or away >= touch:
            continue
        while row[o + 1] <= t + sees:
            o += _R
        u = t + sees - row[o]
        gone: float = (_place(row, o + _X, u) - ox) * c + (_place(row, o + _Y, u) - oy) * s
        most: float = speed_behind(along, away, touch, gone / sees, gap, ahead)
        if most < least:
            least = most
            found = k
    return found


def speed_behind(
    along: float, away: float, touch: float, walks_on: float, gap: float, ahead: float
) -> float:
    """Return the speed (m/s) at which somebody keeps their distance from who walks ahead of them.

    The other is `along` metres ahead and `away` to the side, goes on at `walks_on` (m/s), and their
    bodies meet at a distance of `touch`. The distance to be kept is that of the time `gap` at this
    speed, once they have come to it in `ahead` seconds.
    """
    # Until the two discs touch, if this one goes straight on.
    room: float = along - sqrt(touch * touch - away * away)
    # What the room will be by then is to be v times the time gap: room + (u - v) * ahead = v * gap.
    # That is the collision-free speed model's v = s / T (A. Tordeux, M. Chraibi and A. Seyfried,
    # "Collision-free speed model for pedestrian dynamics", 2016) for a room that is yet to come.
    # Who is only half in the way needs less of the gap.
    most: float = (room + walks_on * ahead) / (gap * (1.0 - away / touch) + ahead)
    return most


def _place(row: Doubles, o: cython.Py_ssize_t, u: float) -> float:
    """Return a coordinate `u` seconds into a row, of the coefficients that begin at `o`."""
    place: float = row[o] + u * (row[o + 1] + u * (row[o + 2] + u * row[o + 3]))
    return place
