"""Car-following of pedestrians: the leader that keeps a person below their top speed.

The speed behind a leader is that of the collision-free speed model (A. Tordeux, M. Chraibi and
A. Seyfried, "Collision-free speed model for pedestrian dynamics", Traffic and Granular Flow '15,
2016), for a room that is yet to come.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import cython
else:
    from . import uncompiled as cython

from .numbers import numbers

if not cython.compiled:
    from math import sqrt

    from .committed import CommittedMotions
    from .cubics import *

_SLOW: float = 0.05  # m/s; the direction of whoever is slower is not that of their velocity


class ChoiceParameters:
    """Parameters of the choice, from an object with these attributes and lists of numbers."""

    def __init__(self, given: Any) -> None:
        self.stride: float = given.stride
        self.farthest: float = given.farthest
        self.looks_around: float = given.looks_around
        self.detours = numbers(given.detours)
        self.widths = numbers(given.widths)
        self.widest: float = given.widest
        self.paces = numbers(given.paces)
        self.delays = numbers(given.delays)
        self.parts = numbers(given.parts)
        self.shortest: float = given.shortest
        self.phantom: float = given.phantom
        self.files = numbers(given.files)
        self.faster: float = given.faster
        self.beside_after: float = given.beside_after
        self.past: float = given.past
        self.other_side: float = given.other_side
        self.brush: float = given.brush
        self.alike: float = given.alike
        self.closes_in: float = given.closes_in
        self.sees: float = given.sees
        self.least_speed: float = given.least_speed
        self.same_way: float = given.same_way
        self.closes_up: float = given.closes_up


class Passer:
    """Person `me` of those on a floor, who passes others.

    At up to `top_speed` (m/s). `radius` and `comfort`, the distance that they keep where there is
    room, are in metres, `time_gap` and `foresight` in seconds (see `Manners`); `usual` is the side
    on which they pass, 1 for the left, -1 for the right.
    """

    def __init__(
        self,
        me: int,
        top_speed: float,
        radius: float,
        comfort: float,
        time_gap: float,
        foresight: float,
        usual: float,
    ) -> None:
        self.me = me
        self.top_speed = top_speed
        self.radius = radius
        self.comfort = comfort
        self.time_gap = time_gap
        self.foresight = foresight
        self.usual = usual


class CarFollowing:
    """Search for the leader of a person among committed `motions`."""

    def __init__(self, motions: CommittedMotions, who: Passer, given: ChoiceParameters) -> None:
        self.motions = motions
        self.who = who
        self.given = given

    def leader(self, near: list[cython.Py_ssize_t], t: float, here: CoursePlace) -> Leader:
        """Return whom of those `near` they follow at `t`, who walks on; nobody if none limits them.

        In `closes_in` seconds they have come to the distance of their time gap, times their speed,
        beyond the bodies; who is beside the path of the one ahead keeps less. Who stands, or goes
        another way, is not followed, and nobody keeps a gap into which somebody who comes the other
        way would step: that jams aisles.
        """
        top: Leader = Leader(-1, self.who.top_speed, 0.0)
        if self.who.time_gap <= 0.0:
            return top
        found: Leader = top
        slow: list[cython.Py_ssize_t] = []
        k: cython.Py_ssize_t = self.followed(near, t, here, slow)
        if k >= 0:
            found = self.behind(k, t, here)
            if found.speed == INFINITY:
                found = top
        # A person who has just started may be followed too, along their route.
        motions: CommittedMotions = self.motions
        same_way: float = self.given.same_way
        i: cython.Py_ssize_t
        for i in range(len(slow)):
            k = slow[i]
            if motions.rests(k) > t and motions.cosine(k, t, here.c, here.s) > same_way:
                other: Leader = self.behind(k, t, here)
                if other.speed < found.speed:
                    found = other
        if found.who < 0:
            return top
        for i in range(len(slow)):
            k = slow[i]
            there: Position = motions.place(k, t)
            away: float = abs(left_of(here, there.x, there.y))
            if (
                away < self.given.closes_up
                and motions.cosine(k, t, here.c, here.s) < -self.given.same_way
            ):
                return top
        return Leader(found.who, max(found.speed, self.given.least_speed), found.walks_on)

    def speed_at(self, near: list[cython.Py_ssize_t], t: float, here: CoursePlace) -> float:
        """Return how fast (m/s) they would come on from a place at `t` (seconds), behind others."""
        slow: list[cython.Py_ssize_t] = []
        k: cython.Py_ssize_t = self.followed(near, t, here, slow)
        speed: float = INFINITY if k < 0 else self.behind(k, t, here).speed
        return self.who.top_speed if speed == INFINITY else max(speed, self.given.least_speed)

    def followed(
        self,
        near: list[cython.Py_ssize_t],
        t: float,
        here: CoursePlace,
        slow: list[cython.Py_ssize_t],
    ) -> cython.Py_ssize_t:
        """Return the index of the leader that limits speed most, or -1.

        A leader is one of those `near` who walks ahead, in the same direction, and leaves no room
        for the time gap at the top speed, by the leader's speed over the next seconds. There is no
        leader if a person ahead comes the other way, at most `closes_up` metres to either side.
        `slow` receives the people ahead who hardly move: they may be leaders, or come the other
        way.
        """
        given: ChoiceParameters = self.given
        found: cython.Py_ssize_t = -1
        least: float = self.who.top_speed
        i: cython.Py_ssize_t
        for i in range(len(near)):
            k: cython.Py_ssize_t = near[i]
            table: Numbers = self.motions.tables[k]
            n: cython.Py_ssize_t = planar_from(table, 0, t)
            piece: PlanarPiece = planar(table)[n]
            u: float = max(t - piece.begin, 0.0)
            ox: float = value(piece.x, u)
            oy: float = value(piece.y, u)
            along: float = ahead_of(here, ox, oy)
            away: float = abs(left_of(here, ox, oy))
            touch: float = self.who.radius + at(self.motions.radii)[k]
            if along <= 0.0 or (away >= given.closes_up and away >= touch):
                continue
            vx: float = slope(piece.x, u)
            vy: float = slope(piece.y, u)
            speed: float = norm(vx, vy)
            # The velocity of a person who hardly moves gives no direction; the route does.
            if speed <= _SLOW or piece.begin > t:
                slow.append(k)
                continue
            same: float = (vx * here.c + vy * here.s) / speed
            # A gap kept before a person who comes would only draw them into it.
            if same < -given.same_way and away < given.closes_up:
                del slow[:]
                return -1
            if same <= given.same_way or away >= touch:
                continue
            piece = planar(table)[planar_from(table, n, t + given.sees)]
            u = t + given.sees - piece.begin
            walked: float = (value(piece.x, u) - ox) * here.c + (value(piece.y, u) - oy) * here.s
            most: float = self._speed_behind(along, away, touch, walked / given.sees)
            if most < least:
                least = most
                found = k
        return found

    def behind(self, k: cython.Py_ssize_t, t: float, here: CoursePlace) -> Leader:
        """Return the k-th as a leader from `here`; of infinite speed who is not in the way."""
        there: Position = self.motions.place(k, t)
        away: float = abs(left_of(here, there.x, there.y))
        touch: float = self.who.radius + at(self.motions.radii)[k]
        if away >= touch:
            return Leader(k, INFINITY, 0.0)
        along: float = ahead_of(here, there.x, there.y)
        then: Position = self.motions.place(k, t + self.given.sees)
        walked: float = (then.x - there.x) * here.c + (then.y - there.y) * here.s
        walks_on: float = walked / self.given.sees
        return Leader(k, self._speed_behind(along, away, touch, walks_on), walks_on)

    def _speed_behind(self, along: float, away: float, touch: float, walks_on: float) -> float:
        """Return the speed (m/s) at which they keep the distance from a leader.

        The other is `along` metres ahead and `away` to the side, goes on at `walks_on` (m/s), and
        their bodies meet at a distance of `touch`. The distance to be kept is that of the time gap
        at this speed, once they have come to it in `closes_in` seconds.
        """
        # Until the two discs touch, if this one goes straight on.
        room: float = along - sqrt(touch * touch - away * away)
        # What the room will be by then is to be v times the time gap: room + (u - v) * ahead =
        # v * gap. That is the model's v = s / T for a room that is yet to come. A leader who is
        # only half in the way needs less of the gap.
        ahead: float = self.given.closes_in
        return (room + walks_on * ahead) / (self.who.time_gap * (1.0 - away / touch) + ahead)
