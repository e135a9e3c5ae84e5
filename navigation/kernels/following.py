"""Car-following of pedestrians: the leader that keeps a person below their top speed.

The speed behind a leader is that of the collision-free speed model (A. Tordeux, M. Chraibi and
A. Seyfried, "Collision-free speed model for pedestrian dynamics", Traffic and Granular Flow '15,
2016), evaluated for the distance at a later time.
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

_SLOW: float = 0.05  # m/s; the velocity of slower people gives no direction


class ChoiceParameters:
    """Parameters of the choice, read from an object with these attributes and lists of numbers."""

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
    """Person with index `index` who passes others.

    `top_speed` is in m/s, `radius` and the preferred additional distance `comfort` in metres,
    `time_gap` and `foresight` in seconds (see `Manners`). `usual` is the preferred side, 1 for left
    and -1 for right.
    """

    def __init__(
        self,
        index: int,
        top_speed: float,
        radius: float,
        comfort: float,
        time_gap: float,
        foresight: float,
        usual: float,
    ) -> None:
        self.index = index
        self.top_speed = top_speed
        self.radius = radius
        self.comfort = comfort
        self.time_gap = time_gap
        self.foresight = foresight
        self.usual = usual


class CarFollowing:
    """Search for the leader of a person among committed `motions`."""

    def __init__(
        self, motions: CommittedMotions, walker: Passer, parameters: ChoiceParameters
    ) -> None:
        self.motions = motions
        self.walker = walker
        self.parameters = parameters

    def leader(self, near: list[cython.Py_ssize_t], t: float, here: CoursePlace) -> Leader:
        """Return the person among `near` whom the walker follows at `t`, or index -1.

        The walker reaches the distance of the time gap, measured between bodies, within `closes_in`
        seconds. Behind a person whose path is partly beside the own one, the distance is less.
        People who stand or walk in another direction are not followed. There is no leader if a
        person who comes the other way could step into the gap, because that jams aisles.
        """
        top: Leader = Leader(-1, self.walker.top_speed, 0.0)
        if self.walker.time_gap <= 0.0:
            return top
        leader: Leader = top
        slow: list[cython.Py_ssize_t] = []
        k: cython.Py_ssize_t = self.followed(near, t, here, slow)
        if k >= 0:
            leader = self.behind(k, t, here)
            if leader.speed == INFINITY:
                leader = top
        # A person who has just started may be followed too, along their route.
        motions: CommittedMotions = self.motions
        same_way: float = self.parameters.same_way
        i: cython.Py_ssize_t
        for i in range(len(slow)):
            k = slow[i]
            if motions.rests(k) > t and motions.cosine(k, t, here.c, here.s) > same_way:
                other: Leader = self.behind(k, t, here)
                if other.speed < leader.speed:
                    leader = other
        if leader.person < 0:
            return top
        for i in range(len(slow)):
            k = slow[i]
            there: Position = motions.place(k, t)
            away: float = abs(left_of(here, there.x, there.y))
            if (
                away < self.parameters.closes_up
                and motions.cosine(k, t, here.c, here.s) < -self.parameters.same_way
            ):
                return top
        return Leader(
            leader.person, max(leader.speed, self.parameters.least_speed), leader.walks_on
        )

    def speed_at(self, near: list[cython.Py_ssize_t], t: float, here: CoursePlace) -> float:
        """Return the speed (m/s) behind others from a place at `t` (s)."""
        slow: list[cython.Py_ssize_t] = []
        k: cython.Py_ssize_t = self.followed(near, t, here, slow)
        speed: float = INFINITY if k < 0 else self.behind(k, t, here).speed
        return (
            self.walker.top_speed if speed == INFINITY else max(speed, self.parameters.least_speed)
        )

    def followed(
        self,
        near: list[cython.Py_ssize_t],
        t: float,
        here: CoursePlace,
        slow: list[cython.Py_ssize_t],
    ) -> cython.Py_ssize_t:
        """Return the index of the leader that limits speed most, or -1.

        A leader is a person `near` who walks ahead in the same direction, and whose mean speed in
        the next seconds leaves no room for the time gap at top speed. There is no leader if a
        person ahead comes the other way, at most `closes_up` metres to either side. The function
        adds people ahead who hardly move to `slow`, because they may turn out to be either.
        """
        parameters: ChoiceParameters = self.parameters
        leader: cython.Py_ssize_t = -1
        least: float = self.walker.top_speed
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
            touch: float = self.walker.radius + at(self.motions.radii)[k]
            if along <= 0.0 or (away >= parameters.closes_up and away >= touch):
                continue
            vx: float = slope(piece.x, u)
            vy: float = slope(piece.y, u)
            speed: float = norm(vx, vy)
            # The velocity of a person who hardly moves gives no direction, but the route does.
            if speed <= _SLOW or piece.begin > t:
                slow.append(k)
                continue
            same: float = (vx * here.c + vy * here.s) / speed
            # A person who comes the other way would step into a gap.
            if same < -parameters.same_way and away < parameters.closes_up:
                del slow[:]
                return -1
            if same <= parameters.same_way or away >= touch:
                continue
            piece = planar(table)[planar_from(table, n, t + parameters.sees)]
            u = t + parameters.sees - piece.begin
            walked: float = (value(piece.x, u) - ox) * here.c + (value(piece.y, u) - oy) * here.s
            behind: float = self._speed_behind(along, away, touch, walked / parameters.sees)
            if behind < least:
                least = behind
                leader = k
        return leader

    def behind(self, k: cython.Py_ssize_t, t: float, here: CoursePlace) -> Leader:
        """Return the k-th person as a leader from `here`, with infinite speed if not in the way."""
        there: Position = self.motions.place(k, t)
        away: float = abs(left_of(here, there.x, there.y))
        touch: float = self.walker.radius + at(self.motions.radii)[k]
        if away >= touch:
            return Leader(k, INFINITY, 0.0)
        along: float = ahead_of(here, there.x, there.y)
        then: Position = self.motions.place(k, t + self.parameters.sees)
        walked: float = (then.x - there.x) * here.c + (then.y - there.y) * here.s
        walks_on: float = walked / self.parameters.sees
        return Leader(k, self._speed_behind(along, away, touch, walks_on), walks_on)

    def _speed_behind(self, along: float, away: float, touch: float, walks_on: float) -> float:
        """Return the speed (m/s) that keeps the distance from a leader.

        The leader is `along` metres ahead and `away` metres to the side, walks at `walks_on` (m/s),
        and both bodies touch at a distance of `touch`. The distance is that of the time gap at this
        speed, reached within `closes_in` seconds.
        """
        # Distance until the two discs touch, straight ahead.
        room: float = along - sqrt(touch * touch - away * away)
        # The distance after `ahead` seconds equals v times the time gap: room + (u - v) * ahead =
        # v * gap. That is v = s / T of the model for a later distance. A leader who is only partly
        # in the way needs less of the gap.
        ahead: float = self.parameters.closes_in
        return (room + walks_on * ahead) / (self.walker.time_gap * (1.0 - away / touch) + ahead)
