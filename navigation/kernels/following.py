"""Car-following of pedestrians: the leader that keeps a person below their top speed.

The speed behind a leader is that of the collision-free speed model (A. Tordeux, M. Chraibi and
A. Seyfried, "Collision-free speed model for pedestrian dynamics", Traffic and Granular Flow '15,
2016), for a room that is yet to come. Motions are tables of `PlanarPiece`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

if not cython.compiled:
    from math import sqrt

    from .cubics import *
    from .numbers import *

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
    """Return the index of the leader that limits speed most, or -1.

    At `t` (seconds) the follower of radius `own` is at `x`, `y`, walks in the direction with the
    cosine `c` and the sine `s`, and is at most `top_speed` (m/s) fast. A leader is one of those
    `near` who walks ahead, in the same direction (the cosine between
    the directions is above `same_way`), and leaves no room for the time `gap` at that speed after
    `ahead` seconds, by the leader's speed over the next seconds, as many as one `sees`. There is no
    leader if a person ahead comes the other way, at most `beside` metres to either side. `tables`
    and `radii` are those of all people. `slow` receives the people ahead who hardly move: they may
    be leaders, or come the other way.
    """
    found: cython.Py_ssize_t = -1
    least: float = top_speed
    i: cython.Py_ssize_t
    for i in range(len(near)):
        k: cython.Py_ssize_t = near[i]
        table: Numbers = tables[k]
        n: cython.Py_ssize_t = planar_from(table, 0, t)
        piece: PlanarPiece = planar(table)[n]
        u: float = max(t - piece.begin, 0.0)
        ox: float = value(piece.x, u)
        oy: float = value(piece.y, u)
        along: float = (ox - x) * c + (oy - y) * s
        away: float = abs((oy - y) * c - (ox - x) * s)
        touch: float = own + at(radii)[k]
        if along <= 0.0 or (away >= beside and away >= touch):
            continue
        vx: float = slope(piece.x, u)
        vy: float = slope(piece.y, u)
        speed: float = norm(vx, vy)
        # The velocity of a person who hardly moves gives no direction; the caller knows their
        # route.
        if speed <= _SLOW or piece.begin > t:
            slow.append(near[i])
            continue
        same: float = (vx * c + vy * s) / speed
        # A gap kept before a person who comes would only draw them into it.
        if same < -same_way and away < beside:
            del slow[:]
            return -1
        if same <= same_way or away >= touch:
            continue
        piece = planar(table)[planar_from(table, n, t + sees)]
        u = t + sees - piece.begin
        walked: float = (value(piece.x, u) - ox) * c + (value(piece.y, u) - oy) * s
        most: float = speed_behind(along, away, touch, walked / sees, gap, ahead)
        if most < least:
            least = most
            found = k
    return found


def speed_behind(
    along: float, away: float, touch: float, walks_on: float, gap: float, ahead: float
) -> float:
    """Return the speed (m/s) at which a follower keeps the distance from a leader.

    The other is `along` metres ahead and `away` to the side, goes on at `walks_on` (m/s), and their
    bodies meet at a distance of `touch`. The distance to be kept is that of the time `gap` at this
    speed, once they have come to it in `ahead` seconds.
    """
    # Until the two discs touch, if this one goes straight on.
    room: float = along - sqrt(touch * touch - away * away)
    # What the room will be by then is to be v times the time gap: room + (u - v) * ahead = v * gap.
    # That is the model's v = s / T for a room that is yet to come.
    # A leader who is only half in the way needs less of the gap.
    most: float = (room + walks_on * ahead) / (gap * (1.0 - away / touch) + ahead)
    return most
