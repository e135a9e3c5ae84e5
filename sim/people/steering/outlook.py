"""Outlook of a person who decides on a course: the floor ahead, and who comes near."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from navigation import (
    CollisionWorld,
    Motion,
    Swath,
    can_go_on,
    first_conflict,
    join,
    paced,
    standing,
    stop_walking,
    swath,
)

from .course import Place, first, gone, length_of, rest
from .traveller import Traveller

GAP = 0.006
"""Metres. Kept between two bodies in any case, so that rounding can't let them touch."""

STEP = 0.25
"""Metres between the places along a course that are looked at for a stop."""

FARTHEST = 25.0
"""Metres. So far a course is looked ahead to find the end of a narrow place."""

AROUND = 3.0
"""Metres. Those who stay so far from the course are not looked at."""

JUST_NOW = 1e-3
"""Seconds. Who is too close so soon is so already."""


@dataclass(frozen=True)
class Hit:
    """The first conflict of a motion: when (seconds), with whom, and whether they stand by then."""

    t: float
    other: Traveller
    at_rest: bool


def first_hit(
    me: Traveller, ahead: Swath, others: Iterable[Traveller], now: float, comfort: float = 0.0
) -> Hit | None:
    """Return the first conflict of `ahead` with what `others` have committed themselves to.

    Two bodies keep `GAP` and `comfort` (metres) between them; those who are closer already come
    no closer.
    """
    found: Hit | None = None
    for other in others:
        theirs = other.swath
        least = me.radius + other.radius + GAP + comfort
        if (
            ahead.low_x - theirs.high_x >= least
            or theirs.low_x - ahead.high_x >= least
            or ahead.low_y - theirs.high_y >= least
            or theirs.low_y - ahead.high_y >= least
        ):
            continue
        t = first_conflict(ahead, theirs, least, now)
        if t is not None and t <= now + JUST_NOW:
            apart = math.dist(me.body.motion.state(now).at, other.body.motion.state(now).at)
            if apart < least + JUST_NOW:
                t = first_conflict(ahead, theirs, min(least, apart - 1e-9), now)
        if t is not None and (found is None or t < found.t):
            found = Hit(t, other, t >= theirs.rests)
    return found


class Ground:
    """The floor as people of one radius (metres) see it."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.world = world
        self.radius = radius

    @cached_property
    def _narrow(self) -> shapely.Geometry:
        return self.world.narrows(self.radius)

    def free(self, a: Place, b: Place) -> bool:
        """Return whether the segment from a to b touches nothing."""
        return self.world.segment_free(a, b, self.radius)

    def narrow(self, places: Sequence[Place]) -> list[bool]:
        """Return for each place whether it is in a narrow place, or just before one."""
        if self._narrow.is_empty:
            return [False] * len(places)
        xy = np.array(places)
        found: list[bool] = shapely.intersects_xy(self._narrow, xy[:, 0], xy[:, 1]).tolist()
        return found


class Outlook:
    """Everything that one decision about the course of `me` looks at.

    `at`, `t` and `speed` are where, when and how fast a new course begins: now, or once they have
    come to rest, where they are too fast to turn (`lead` is the motion until then). `course` is
    their path from there to the goal.
    """

    def __init__(
        self,
        me: Traveller,
        now: float,
        others: Sequence[Traveller],
        ground: Ground,
        reroute: Callable[[Place], list[Place]],
    ) -> None:
        self.me = me
        self.now = now
        self.others = others
        self.ground = ground
        self._state = me.body.motion.state(now)
        self.lead: Motion | None = None
        self.at, self.t, self.speed = self._state.at, now, self._state.speed
        self.course = [self.at, *self._taut(self.at, reroute)]
        if self.speed > 1e-6 and not self.can_turn(self.course):
            self.lead = stop_walking(
                me.body.motion, now, max_acceleration=me.human.max_acceleration
            )
            end = self.lead.state(self.lead.end)
            self.at, self.t, self.speed = end.at, self.lead.end, 0.0
            self.course = [self.at, *self._taut(self.at, reroute)]

    @cached_property
    def wish(self) -> Motion | None:
        """The motion along the course as far as they look ahead, as if nobody were there."""
        return self.walk(self.course, self.stop_beyond(self.reach))

    @cached_property
    def reach(self) -> float:
        """How far along the course they look ahead, metres."""
        return self.me.top_speed * self.me.manners.foresight

    def can_turn(self, course: Sequence[Place]) -> bool:
        """Return whether they may set out on `course` from here without slowing down first."""
        if len(course) < 2 or self.speed < 1e-6:
            return True
        return can_go_on(self._state, course[1], self.me.human.max_acceleration)

    def walk(
        self,
        course: Sequence[Place],
        length: float | None = None,
        *,
        top_speed: float | None = None,
        delay: float = 0.0,
    ) -> Motion | None:
        """Return the walk along the first `length` metres of a course from here, and to rest.

        None if they can't. `delay` (seconds) counts from when they stand.
        """
        me = self.me
        if delay and self.speed > 1e-6:
            return None
        points: Sequence[Place] = course if length is None else first(course, length)
        fastest = me.top_speed if top_speed is None else top_speed
        top: float | list[float] = fastest
        if me.zones:
            points, top = me.zones.along(points, fastest)
        motion = paced(
            points,
            self.t + delay,
            initial_speed=self.speed,
            top_speed=top,
            max_speed=me.human.max_speed,
            max_acceleration=me.human.max_acceleration,
        )
        if motion is None:
            return None
        if self.lead is not None:
            return join([self.lead, motion])
        if delay:
            x, y, heading = self._state.position
            return join([standing((x, y), heading=heading, start=self.now), motion])
        return motion

    def stop_beyond(self, length: float) -> float:
        """Return the first length along the course, from `length` metres on, for a stop.

        Nobody stops in a narrow place of their own will, but at their goal.
        """
        whole = length_of(self.course)
        while length < min(whole, FARTHEST):
            if not self.is_narrow(length):
                return length
            length += STEP
        return whole

    def stop_before(self, length: float) -> float:
        """Return the last length along the course, up to `length` metres, for a stop."""
        while length > 0.0 and self.is_narrow(length):
            length -= STEP
        return max(length, 0.0)

    def is_narrow(self, length: float) -> bool:
        """Return whether the course is in a narrow place after `length` metres."""
        k = math.ceil(length / STEP)
        return k < len(self._narrow) and self._narrow[k]

    @cached_property
    def _narrow(self) -> list[bool]:
        whole = min(length_of(self.course), FARTHEST)
        ends = [rest(self.course, k * STEP)[0] for k in range(math.ceil(whole / STEP) + 1)]
        return self.ground.narrow(ends)

    def free(self, motion: Motion) -> bool:
        """Return whether a motion of theirs from now on conflicts with nobody near."""
        ahead = swath(motion, self.now)
        return not any(first_hit(self.me, ahead, (other,), self.now) for other in self.near)

    @cached_property
    def near(self) -> Sequence[Traveller]:
        """Those of the others who may come near the course, or beside it."""
        wish = self.wish
        if wish is None:
            return self.others
        ahead = swath(wish, self.now)
        low_x, high_x = ahead.low_x - AROUND, ahead.high_x + AROUND
        low_y, high_y = ahead.low_y - AROUND, ahead.high_y + AROUND
        return [
            other
            for other in self.others
            for theirs in (other.swath,)
            if theirs.low_x < high_x
            and theirs.high_x > low_x
            and theirs.low_y < high_y
            and theirs.high_y > low_y
        ]

    def hit(
        self, motion: Motion, comfort: float = 0.0, but: Collection[Traveller] = ()
    ) -> Hit | None:
        """Return the first conflict of a motion of theirs from now on, `but` with some people."""
        others = [o for o in self.near if o not in but] if but else self.near
        return first_hit(self.me, swath(motion, self.now), others, self.now, comfort)

    def gone(self, motion: Motion, t: float) -> float:
        """Return the metres along its course that a motion has gone at `t` (seconds)."""
        return gone(motion, self.t, t)

    def _taut(self, at: Place, reroute: Callable[[Place], list[Place]]) -> list[Place]:
        """Return the route from `at`: without the points that can be left out, or a new one."""
        route = self.me.route
        for k in range(min(len(route), 4) - 1, -1, -1):
            if self.ground.free(at, route[k]):
                return route[k:]
        return reroute(at)
