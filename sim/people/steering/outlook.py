"""Outlook of a person who decides on a course: the floor ahead, and who comes near."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from itertools import pairwise

from floorplan import Point
from navigation import (
    Candidates,
    CollisionWorld,
    Motion,
    Narrows,
    Swath,
    can_go_on,
    pace,
    stop_walking,
    swath,
    touches,
    walked,
)

from .course import first
from .detour import AROUND as ALL_AROUND
from .detour import Detours
from .traveller import Traveller
from .whereabouts import GAP, Hit, Others, Sight, Whereabouts

STEP = 0.25
"""Metres between the places along a course that are looked at, to stop or to get off it."""

INSIDE, OUTSIDE = 2, 3
"""People. A place is narrow where so many can't go abreast: for who is in it, and for who is not.
In an aisle for two, those of one direction side by side leave no room for the other."""

FARTHEST = 25.0
"""Metres. So far a course is looked ahead to find the end of a narrow place."""

AROUND = 2.0
"""Metres. Those who stay so far from the course, and more than they need, are not looked at."""


class Ground:
    """The floor as people of one radius (metres) see it."""

    def __init__(self, world: CollisionWorld, radius: float) -> None:
        self.world = world
        self.radius = radius
        self.detours = Detours(world, radius)
        self.walls = world.walls(radius).grid
        """The sides of the walls."""
        self._gates = world.gates
        self._gated = bool(self._gates)

    @cached_property
    def _narrows(self) -> dict[int, Narrows]:
        return {number: self.world.narrows(self.radius, number) for number in (INSIDE, OUTSIDE)}

    def free(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a, a free place, to b touches nothing.

        Nor goes through a gate against its direction.
        """
        radius = self.radius
        if self.walls.touched(*a, *b, radius) or (self._gated and not self._gates.allow(a, b)):
            return False
        near = self.world.near(a, b, radius)
        return not near or self.world.segment_free(a, b, radius, near)

    def paths_ahead(
        self, at: Point, course: Sequence[Point], lengths: Iterable[float]
    ) -> Iterator[list[Point]]:
        """Yield the path from `at`, beside a course, along it to each of these lengths (metres).

        They grow; it ends before the first path that is not free, there and back.
        """
        free: set[tuple[Point, Point]] = set()
        for length in lengths:
            path = [at, *first(course, length)]
            if not all(leg in free or self.free_and_back(*leg) for leg in pairwise(path)):
                return
            free.update(pairwise(path))
            yield path

    def has_only_walls(self, place: Point, metres: float) -> bool:
        """Return whether nothing but walls can be in the way so far around a place."""
        return not self._gated and not self.world.near(place, place, self.radius + metres)

    def free_and_back(self, a: Point, b: Point) -> bool:
        """Return whether the segment from a to b is free, and a way leads back.

        It may be another, where the segment goes through a gate.
        """
        return self.free(a, b) and (
            not self._gated
            or self._gates.allow(b, a)
            or self._gates.reach(self.world.fixed_space(self.radius), b, a)
        )

    def narrow(self, place: Point, abreast: int) -> bool:
        """Return whether a place is one where so many can't go `abreast`, or just before it."""
        return self._narrows[abreast].has(place)


class Outlook:
    """Everything that one decision about the course of `me` looks at.

    `at`, `t` and `speed` are where, when and how fast a new course begins: now, or once they have
    come to rest, where they are too fast to turn (`lead` is the motion until then). `course` is
    their path from there to the goal, `whole` its length, `reach` how far along it they look
    ahead and `stop` after how much of it they stop if nobody is in the way (metres); `wished` is
    where the `wish` goes. `walks` along the course and beside it are to be weighed against each
    other.
    """

    def __init__(
        self,
        me: Traveller,
        now: float,
        whereabouts: Whereabouts,
        ground: Ground,
        reroute: Callable[[Point], list[Point]],
    ) -> None:
        self.me = me
        self.now = now
        self.ground = ground
        self.reroute = reroute
        self._whereabouts = whereabouts
        self._state = me.body.motion.state(now)
        self._narrow: dict[int, bool] = {}
        self._around = AROUND
        self._others: Others | None = None
        self._seen: list[float] = []
        self._made: tuple[Motion | None, Swath | None] = (None, None)
        self._free_of: tuple[Swath | None, Others | None] = (None, None)
        """The last draft that was found free, and of whom."""
        self._wish: Motion | None = None
        self.lead: Motion | None = None
        self._lead: Swath | None = None
        self.at, self.t, self.speed = self._state.at, now, self._state.speed
        self.course = [self.at, *self._taut(self.at)]
        # Too fast for the bend: what is decided begins where they come to rest; until then they
        # brake along their old course.
        if self.speed > 1e-6 and not self.can_turn(self.course):
            self.lead = stop_walking(
                me.body.motion, now, max_acceleration=me.human.max_acceleration
            )
            self._lead = swath(self.lead, now)
            end = self.lead.state(self.lead.end)
            self.at, self.t, self.speed = end.at, self.lead.end, 0.0
            self.course = [self.at, *self._taut(self.at)]
        human, lead = me.human, self._lead
        vx, vy, _ = self._state.velocity
        self.walks = Candidates(
            [number for corner in self.course for number in corner],
            self.t,
            now,
            self.speed,
            vx,
            vy,
            human.max_speed,
            human.max_acceleration,
            [] if lead is None else lead.walk,
            [] if lead is None else lead.box,
        )
        self.whole = self.walks.whole
        self.reach = me.top_speed * me.manners.foresight
        self.stop = self.stop_beyond(self.reach)
        self.wished = self.draft(self.course, self.stop)

    @property
    def wish(self) -> Motion | None:
        """The motion along the course as far as they look ahead, as if nobody were there."""
        if self._wish is None and self.wished is not None:
            self._wish = walked(self.wished, self._state.position[2])
        return self._wish

    def is_wish(self, motion: Motion) -> bool:
        """Return whether a motion is the `wish`; it is not made for that."""
        return motion is self._wish

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
        fastest = me.top_speed if top_speed is None else top_speed
        if course is self.course and not me.zones:
            walks, most = self.walks, math.inf if length is None else length
            return _drawn(walks) if walks.draw_along(most, fastest, delay) else None
        if delay and self.speed > 1e-6:
            return None
        points: Sequence[Point] = course if length is None else first(course, length)
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

    def next_free(self) -> Swath | None:
        """Return the draft of the next of the `walks` that meets nobody; None for none."""
        walks, others = self.walks, self.others
        draft: Swath | None = None
        if not self.me.zones:
            draft = _drawn(walks) if others.next_free(walks) else None
        else:
            while walks.next_course():
                draft = self._zoned()
                if draft is not None and others.free(draft):
                    break
                draft = None
        self._free_of = (draft, others)
        return draft

    def aside(self, along: float, side: float, others: Others) -> Swath | None:
        """Return the draft of a walk `side` metres to the left after `along` metres of the course.

        None if it is not free, of walls or of these `others`.
        """
        walks, me = self.walks, self.me
        draft = None
        if walks.draw_aside(self.reach + 0.5, me.top_speed, along, side):
            draft = self._zoned() if me.zones else _drawn(walks)
        if draft is None or not others.free(draft) or not self.has_room():
            return None
        return draft

    def has_room(self) -> bool:
        """Return whether there are no walls in the way of the walk that is looked at.

        To be asked after others were looked at: that is quicker.
        """
        walks, free = self.walks, self.ground.free
        # The shift is in the first three legs; all that comes after is the course, which is free.
        return walks.side == 0.0 or all(free(a, b) for a, b in pairwise(_points(walks.corners)[:4]))

    def _zoned(self) -> Swath | None:
        """Return the draft of the walk that is looked at where limits hold."""
        walks = self.walks
        return self.draft(
            _points(walks.corners), walks.length, top_speed=walks.top_speed, delay=walks.delay
        )

    def made(self, draft: Swath) -> Motion:
        """Return the motion of a draft."""
        motion = walked(draft, self._state.position[2])
        self._made = (motion, draft)
        return motion

    def ahead(self, motion: Motion) -> Swath:
        """Return where a motion goes from now on."""
        if motion is self._wish and self.wished is not None:
            return self.wished
        made, draft = self._made
        return draft if motion is made and draft is not None else swath(motion, self.now)

    def stop_beyond(self, length: float) -> float:
        """Return the first length along the course, from `length` metres on, for a stop.

        Nobody stops in a narrow place of their own will, but at their goal.
        """
        while length < min(self.whole, FARTHEST):
            if not self.is_narrow(length):
                return length
            length += STEP
        return self.whole

    def stop_before(self, length: float) -> float:
        """Return the last length along the course, up to `length` metres, for a stop."""
        while length > 0.0 and self.is_narrow(length):
            length -= STEP
        return max(length, 0.0)

    def is_narrow(self, length: float) -> bool:
        """Return whether the course is in a narrow place after `length` metres."""
        # On a grid of lengths, so that the same place is asked for once and not once for each
        # candidate.
        k = math.ceil(length / STEP)
        if k * STEP > min(self.whole, FARTHEST) + STEP:
            return False
        if k not in self._narrow:
            self._narrow[k] = self.ground.narrow(self.walks.at(k * STEP)[:2], self.abreast)
        return self._narrow[k]

    @cached_property
    def abreast(self) -> int:
        """So many can't go abreast where it is narrow for them: see `INSIDE` and `OUTSIDE`."""
        return INSIDE if self.inside else OUTSIDE

    @cached_property
    def inside(self) -> bool:
        """Whether they are where it is narrow, or just before it."""
        return self.ground.narrow(self.at, OUTSIDE)

    def free(self, motion: Motion) -> bool:
        """Return whether a motion of theirs from now on conflicts with nobody."""
        ahead = self.ahead(motion)
        others, (draft, among) = self._around_of(ahead), self._free_of
        return (ahead is draft and others is among) or others.free(ahead)

    @property
    def others(self) -> Others:
        """Those who may come near the course, or beside it."""
        if self._others is None:
            low_x, low_y, high_x, high_y = self._box
            around = self._around
            self._seen = [low_x - around, low_y - around, high_x + around, high_y + around]
            self._others = self._whereabouts.others(self.me, self._seen, self.now)
        return self._others

    def sight(self, metres: float) -> Sight:
        """Return what they see so far around the course."""
        low_x, low_y, high_x, high_y = self._box
        box = [low_x - metres, low_y - metres, high_x + metres, high_y + metres]
        return self._whereabouts.sight(self.me, box)

    @property
    def _box(self) -> list[float]:
        """The bounds of the course ahead."""
        return self.me.swath.box if self.wished is None else self.wished.box

    def _around_of(self, ahead: Swath) -> Others:
        """Return those who may come near a motion."""
        low_x, low_y, high_x, high_y = ahead.box
        if self._others is not None:
            seen = self._seen
            if low_x >= seen[0] and low_y >= seen[1] and high_x <= seen[2] and high_y <= seen[3]:
                return self._others
        return self._whereabouts.others(self.me, ahead.box, self.now)

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
        return self._around_of(ahead).first_hit(ahead)

    def gone(self, t: float) -> float:
        """Return the metres along the course that they would have gone at `t` (seconds)."""
        return 0.0 if self.wished is None else self.wished.gone(self.t, t)

    def _taut(self, at: Point) -> list[Point]:
        """Return the route from `at`: without the points that can be left out, or a new one."""
        me = self.me
        route = me.route
        if me.goes_round and route:
            discs = [c for place, _ in self.standing(at, *route) for c in (*place, *place)]
            width = 2 * me.radius + GAP

            def clear(a: Point, b: Point) -> bool:
                return not touches(discs, *a, *b, width) and self.ground.free(a, b)

            # The farthest that can be seen: a straight line to it is shorter than the bends before
            # it.
            for k in range(min(len(route), 4) - 1, -1, -1):
                if clear(at, route[k]):
                    # Who has passed a bend must not go back to it because of somebody beyond it.
                    if all(clear(a, b) for a, b in pairwise(route[k:])):
                        return route[k:]
                    break
            me.goes_round = False
        for k in range(min(len(route), 4) - 1, -1, -1):
            if self.ground.free(at, route[k]):
                return route[k:]
        return self.reroute(at)

    def standing(self, *places: Point) -> list[tuple[Point, float]]:
        """Return who stands around these places: where, and how far to stay from there (m)."""
        me, floor = self.me, self._whereabouts
        xs, ys = zip(*places, strict=True)
        near = floor.near([min(xs), min(ys), max(xs), max(ys)], ALL_AROUND)
        return [
            (floor.places[k], me.radius + floor.radii[k] + GAP)
            for k in near
            if floor.rests[k] <= self.now and floor.people[k] is not me
        ]


def _drawn(walks: Candidates) -> Swath:
    """Return the draft of the walk that was looked at last."""
    return Swath.of(walks.table, walks.box)


def _points(corners: Sequence[float]) -> list[Point]:
    """Return corners whose x and y stand in turn as points."""
    return [*zip(corners[::2], corners[1::2], strict=True)]
