"""Outlook of a person who decides on a course: the floor ahead, and who comes near."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import shapely

from floorplan import Point
from navigation import (
    CollisionWorld,
    Motion,
    Swath,
    can_go_on,
    first_met,
    pace,
    stop_walking,
    swath,
    walked,
)

from .course import first, length_of, rest
from .traveller import Traveller

GAP = 0.006
"""Metres. Kept between two bodies in any case, so that rounding can't let them touch."""

STEP = 0.25
"""Metres between the places along a course that are looked at for a stop."""

FARTHEST = 25.0
"""Metres. So far a course is looked ahead to find the end of a narrow place."""

AROUND = 2.0
"""Metres. Those who stay so far from the course, and more than they need, are not looked at."""

Among = Callable[[Traveller, Sequence[float]], list[Traveller]]
"""The others but somebody who may come near a box: least x and y, greatest x and y (metres)."""


@dataclass(frozen=True)
class Hit:
    """The first conflict of a motion: when (seconds), with whom, and whether they stand by then."""

    t: float
    other: Traveller
    at_rest: bool


class Others:
    """People that somebody may meet, with what they have committed themselves to, side by side."""

    def __init__(self, me: Traveller, people: Sequence[Traveller], now: float) -> None:
        self.people = people
        self._now = now
        swaths = [other.swath for other in people]
        self._rests = [one.rests for one in swaths]
        self._tables = [one.table for one in swaths]
        self._boxes = [bound for one in swaths for bound in one.box]
        self._leasts = [me.radius + other.radius + GAP for other in people]
        self._with_comfort = [least + me.manners.comfort for least in self._leasts]
        self._when = [math.inf]

    def first_hit(self, ahead: Swath, *, comfort: bool = False) -> Hit | None:
        """Return the first conflict of a motion of theirs from now on with any of these.

        Two bodies keep `GAP` between them, or the `comfort` distance besides; those who are closer
        already come no closer.
        """
        leasts = self._with_comfort if comfort else self._leasts
        who = first_met(
            ahead.table, ahead.box, self._tables, self._boxes, leasts, self._now, self._when
        )
        if who < 0:
            return None
        t = self._when[0]
        return Hit(t, self.people[who], t >= self._rests[who])

    def free(self, ahead: Swath) -> bool:
        """Return whether a motion of theirs from now on conflicts with none of these."""
        who = first_met(
            ahead.table, ahead.box, self._tables, self._boxes, self._leasts, self._now, self._when
        )
        return who < 0


class Ground:
    """The floor as people of one radius (metres) see it."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.world = world
        self.radius = radius
        self._walls = world.walls(radius)

    @cached_property
    def _narrow(self) -> shapely.Geometry:
        return self.world.narrows(self.radius)

    @cached_property
    def _narrow_bounds(self) -> tuple[float, float, float, float]:
        bounds: tuple[float, float, float, float] = self._narrow.bounds
        return bounds

    def free(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a, a free place, to b touches nothing."""
        if not self._walls.clear(a, b):
            return False
        near = self.world.near(a, b, self.radius)
        return not near or self.world.segment_free(a, b, self.radius, near)

    def narrow(self, place: Point) -> bool:
        """Return whether a place is in a narrow one, or just before it."""
        if self._narrow.is_empty:
            return False
        low_x, low_y, high_x, high_y = self._narrow_bounds
        x, y = place
        if not (low_x <= x <= high_x and low_y <= y <= high_y):
            return False
        return bool(shapely.intersects_xy(self._narrow, x, y))


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
        among: Among,
        ground: Ground,
        reroute: Callable[[Point], list[Point]],
    ) -> None:
        self.me = me
        self.now = now
        self.ground = ground
        self._among = among
        self._state = me.body.motion.state(now)
        self._narrow: dict[int, bool] = {}
        self._around = AROUND
        self._others: Others | None = None
        self._made: tuple[Motion | None, Swath | None] = (None, None)
        self.lead: Motion | None = None
        self._lead: Swath | None = None
        self.at, self.t, self.speed = self._state.at, now, self._state.speed
        self.course = [self.at, *self._taut(self.at, reroute)]
        if self.speed > 1e-6 and not self.can_turn(self.course):
            self.lead = stop_walking(
                me.body.motion, now, max_acceleration=me.human.max_acceleration
            )
            self._lead = swath(self.lead, now)
            end = self.lead.state(self.lead.end)
            self.at, self.t, self.speed = end.at, self.lead.end, 0.0
            self.course = [self.at, *self._taut(self.at, reroute)]

    @cached_property
    def wish(self) -> Motion | None:
        """The motion along the course as far as they look ahead, as if nobody were there."""
        return None if self.wished is None else self.made(self.wished)

    @cached_property
    def wished(self) -> Swath | None:
        """Where the `wish` goes."""
        return self.draft(self.course, self.stop_beyond(self.reach))

    @cached_property
    def _whole(self) -> float:
        return length_of(self.course)

    @cached_property
    def reach(self) -> float:
        """How far along the course they look ahead, metres."""
        return self.me.top_speed * self.me.manners.foresight

    def can_turn(self, course: Sequence[Point]) -> bool:
        """Return whether they may set out on `course` from here without slowing down first."""
        if len(course) < 2 or self.speed < 1e-6:
            return True
        return can_go_on(self._state, course[1], self.me.human.max_acceleration)

    def walk(
        self,
        course: Sequence[Point],
        length: float | None = None,
        *,
        top_speed: float | None = None,
        delay: float = 0.0,
    ) -> Motion | None:
        """Return the walk along the first `length` metres of a course from here, and to rest.

        None if they can't. `delay` (seconds) counts from when they stand.
        """
        draft = self.draft(course, length, top_speed=top_speed, delay=delay)
        return None if draft is None else self.made(draft)

    def draft(
        self,
        course: Sequence[Point],
        length: float | None = None,
        *,
        top_speed: float | None = None,
        delay: float = 0.0,
    ) -> Swath | None:
        """Return where `walk` would go."""
        me = self.me
        if delay and self.speed > 1e-6:
            return None
        points: Sequence[Point] = course if length is None else first(course, length)
        fastest = me.top_speed if top_speed is None else top_speed
        top: float | list[float] = fastest
        if me.zones:
            points, top = me.zones.along(points, fastest)
        return pace(
            points,
            self.t + delay,
            initial_speed=self.speed,
            top_speed=top,
            max_speed=me.human.max_speed,
            max_acceleration=me.human.max_acceleration,
            lead=self._lead,
            since=self.now,
        )

    def made(self, draft: Swath) -> Motion:
        """Return the motion of a draft."""
        motion = walked(draft, self._state.position[2])
        self._made = (motion, draft)
        return motion

    def ahead(self, motion: Motion) -> Swath:
        """Return where a motion goes from now on."""
        made, draft = self._made
        return draft if motion is made and draft is not None else swath(motion, self.now)

    def stop_beyond(self, length: float) -> float:
        """Return the first length along the course, from `length` metres on, for a stop.

        Nobody stops in a narrow place of their own will, but at their goal.
        """
        while length < min(self._whole, FARTHEST):
            if not self.is_narrow(length):
                return length
            length += STEP
        return self._whole

    def stop_before(self, length: float) -> float:
        """Return the last length along the course, up to `length` metres, for a stop."""
        while length > 0.0 and self.is_narrow(length):
            length -= STEP
        return max(length, 0.0)

    def is_narrow(self, length: float) -> bool:
        """Return whether the course is in a narrow place after `length` metres."""
        k = math.ceil(length / STEP)
        if k * STEP > min(self._whole, FARTHEST) + STEP:
            return False
        if k not in self._narrow:
            self._narrow[k] = self.ground.narrow(rest(self.course, k * STEP)[0])
        return self._narrow[k]

    def free(self, motion: Motion) -> bool:
        """Return whether a motion of theirs from now on conflicts with nobody."""
        ahead = self.ahead(motion)
        return Others(self.me, self._among(self.me, ahead.box), self.now).free(ahead)

    @property
    def others(self) -> Others:
        """Those who may come near the course, or beside it."""
        if self._others is None:
            wished = self.wished
            box = self.me.swath.box if wished is None else wished.box
            low_x, low_y, high_x, high_y = box
            around = self._around
            box = [low_x - around, low_y - around, high_x + around, high_y + around]
            self._others = Others(self.me, self._among(self.me, box), self.now)
        return self._others

    def look_around(self, metres: float) -> None:
        """See those as well who stay so far from the course."""
        self._around = metres
        self._others = None

    def look_again(self) -> None:
        """See the others anew: one of them has committed themselves to something else."""
        self._others = None

    @property
    def near(self) -> Sequence[Traveller]:
        """Those of the others who may come near the course, or beside it."""
        return self.others.people

    def hit(self, motion: Motion) -> Hit | None:
        """Return the first conflict of a motion of theirs from now on."""
        ahead = self.ahead(motion)
        return Others(self.me, self._among(self.me, ahead.box), self.now).first_hit(ahead)

    def gone(self, t: float) -> float:
        """Return the metres along the course that they would have gone at `t` (seconds)."""
        return 0.0 if self.wished is None else self.wished.gone(self.t, t)

    def _taut(self, at: Point, reroute: Callable[[Point], list[Point]]) -> list[Point]:
        """Return the route from `at`: without the points that can be left out, or a new one."""
        route = self.me.route
        for k in range(min(len(route), 4) - 1, -1, -1):
            if self.ground.free(at, route[k]):
                return route[k:]
        return reroute(at)
