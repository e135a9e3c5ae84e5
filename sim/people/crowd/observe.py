"""Observation: the course of a person, the preferred motion, and people nearby."""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from contextlib import suppress

from floorplan import Point
from navigation import Motion, join, stop_walking, walk
from navigation.kernels.candidates import Candidates, Course, Departure
from navigation.kernels.discs import Swath
from navigation.kernels.following import ChoiceParameters, Passer
from navigation.kernels.foresight import TrajectoryChoice
from navigation.kernels.grid import middles
from navigation.kernels.numbers import numbers
from navigation.walking import can_go_on, motion_along, swath, swath_along

from .commitments import GAP, Commitments, Hit, Others
from .ground import Ground, corners_passed, first
from .parameters import PARAMETERS
from .traveller import Traveller

GIVEN = ChoiceParameters(PARAMETERS)


def whole_walk(me: Traveller, now: float) -> Motion:
    """Return the walk of a person all the way to the goal, on an empty floor.

    A person who is too fast for it comes to rest first, and plans the route from there.
    """
    state = me.body.motion.state(now)
    route = me.route if me.routed == now else me.reroute(state.at)
    course, tops = _limited(me, [state.at, *route])
    speed = state.speed
    if speed == 0.0 or (
        (speed <= me.top_speed or tops != me.top_speed)
        and (len(course) < 2 or can_go_on(state, course[1], me.human.max_acceleration, me.body.leg))
    ):
        with suppress(ValueError):  # too short to come to rest on
            return _walk_all(me, course, tops, now, speed)
    braking = stop_walking(me.body.motion, now, max_acceleration=me.human.max_acceleration)
    at = braking.state(braking.end).at
    course, tops = _limited(me, [at, *me.reroute(at)])
    return join([braking, _walk_all(me, course, tops, braking.end, 0.0)])


def _limited(me: Traveller, course: list[Point]) -> tuple[list[Point], float | list[float]]:
    """Return a course with the top speed of each leg, or only one where no limit is lower."""
    return me.zones.along(course, me.top_speed) if me.zones else (course, me.top_speed)


def _walk_all(
    me: Traveller, course: list[Point], tops: float | list[float], t: float, speed: float
) -> Motion:
    """Return the walk along all of a course; `ValueError` if it is too short to stop on."""
    is_limited = tops != me.top_speed
    return walk(
        course,
        t,
        initial_speed=speed,
        top_speed=tops if is_limited else None,
        max_speed=me.human.max_speed if is_limited else me.top_speed,
        max_acceleration=me.human.max_acceleration,
    )


class Outlook:
    """Observation of a person `me` who decides: the floor ahead, and people nearby.

    Attributes
    ----------
    at, t, speed : Point, float, float
        Position (m), time (s) and speed (m/s) at which a new course begins. If the person is too
        fast for the first turn, it begins where they come to rest, after the motion `lead`.
    course : list of Point
        Path from there to the goal.
    whole, reach, stop : float
        Length of the course, distance of foresight, and length after which the person stops if no
        other person is in the way, m.
    wished : Swath or None
        Draft of the preferred motion, `wish`.
    walks : Candidates
        Candidate walks along the course and beside it.
    """

    def __init__(
        self,
        me: Traveller,
        now: float,
        commitments: Commitments,
        ground: Ground,
    ) -> None:
        self.me = me
        self.now = now
        self.ground = ground
        self._legs = ground.legs
        self._commitments = commitments
        self._state = me.body.motion.state(now)
        self._others: Others | None = None
        self._hit: Hit | None = None
        self._made: tuple[Motion | None, Swath | None] = (None, None)
        self._free: tuple[Swath | None, Others | None] = (None, None)
        """The draft that was chosen, and those among whom it was found free."""
        self._wish: Motion | None = None
        self.lead: Motion | None = None
        self._lead: Swath | None = None
        self.at, self.t, self.speed = self._state.at, now, self._state.speed
        self.course = [self.at, *self._taut(self.at)]
        # A person who is too fast for the first turn brakes along the old course. The new one
        # begins at the rest position.
        if self.speed > 1e-6 and not self.can_turn(self.course):
            self.lead = stop_walking(
                me.body.motion, now, max_acceleration=me.human.max_acceleration
            )
            self._lead = swath(self.lead, now)
            end = self.lead.state(self.lead.end)
            self.at, self.t, self.speed = end.at, self.lead.end, 0.0
            self.course = [self.at, *self._taut(self.at)]
        human, lead, manners = me.human, self._lead, me.manners
        self.walks = Candidates(
            Course(self.course),
            Departure(
                self.t,
                now,
                self.speed,
                me.body.leg,
                human.max_speed,
                human.max_acceleration,
                lead,
            ),
            self._slowed if me.zones else None,
        )
        self._foresight = TrajectoryChoice(
            self.walks,
            commitments,
            Passer(
                commitments.indices[me],
                me.top_speed,
                me.radius,
                manners.comfort,
                manners.time_gap,
                manners.foresight,
                me.usual_side,
            ),
            ground.narrow.cells,
            ground.narrow_outside.cells,
            self._legs,
            GIVEN,
        )
        self.whole = self.walks.course.length
        self.reach, self.stop = self._foresight.reach, self._foresight.stop
        self.stop_beyond = self._foresight.stop_beyond
        self.wished = self._foresight.wish()

    @property
    def wish(self) -> Motion | None:
        """Preferred motion: along the course within the foresight, on an empty floor."""
        if self._wish is None and self.wished is not None:
            self._wish = motion_along(self.wished, self._state.position[2])
        return self._wish

    def is_wish(self, motion: Motion) -> bool:
        """Return whether a motion is the preferred one."""
        return motion is self._wish

    def can_turn(self, course: Sequence[Point]) -> bool:
        """Return whether the person can start on `course` without braking."""
        if len(course) < 2 or self.speed < 1e-6:
            return True
        most = self.me.human.max_acceleration
        return can_go_on(self._state, course[1], most, self.me.body.leg)

    def walk(
        self,
        course: Sequence[Point],
        length: float | None = None,
        *,
        top_speed: float | None = None,
        delay: float = 0.0,
    ) -> Motion | None:
        """Return the walk along the first `length` metres of a course, or None if it is impossible.

        `delay` (s) begins at rest.
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
        """Return the swath of `walk`."""
        me = self.me
        fastest = me.top_speed if top_speed is None else top_speed
        if course is self.course:
            most = math.inf if length is None else length
            return self.walks.draw_along(most, fastest, delay)
        if delay and self.speed > 1e-6:
            return None
        points: Sequence[Point] = course if length is None else first(course, length)
        return self._paced(points, fastest, delay)

    def _paced(self, points: Sequence[Point], fastest: float, delay: float) -> Swath | None:
        """Return the swath of a walk along `points` within the speed limits of zones."""
        me = self.me
        points, top = me.zones.along(points, fastest)
        return swath_along(
            points,
            self.t + delay,
            initial_speed=self.speed,
            top_speed=top,
            max_speed=me.human.max_speed,
            max_acceleration=me.human.max_acceleration,
            lead=self._lead,
            since=self.now,
        )

    def _slowed(
        self, corners: MutableSequence[float], fastest: float, delay: float
    ) -> Swath | None:
        """Return the swath of a walk within the speed limits of zones, or None."""
        points = [*zip(corners[::2], corners[1::2], strict=True)]
        return self._paced(points, fastest, delay)

    def first_free(self) -> Motion | None:
        """Return the free candidate with the least loss, or None."""
        draft = self._foresight.first_free()
        if draft is None:
            return None
        if draft is self.wished:
            return self.wish
        self._free = (draft, self.others)
        return self.made(draft)

    def aside(self, along: float, side: float, other: int) -> Swath | None:
        """Return the draft of a walk `side` metres to the left after `along` metres of the course.

        None if it is not free of walls and of all people near except the one in row `other`.
        """
        return self._foresight.aside(along, side, other)

    def made(self, draft: Swath) -> Motion:
        """Return the motion of a draft."""
        motion = motion_along(draft, self._state.position[2])
        self._made = (motion, draft)
        return motion

    def ahead(self, motion: Motion) -> Swath:
        """Return the swath of a motion from now on."""
        if motion is self._wish and self.wished is not None:
            return self.wished
        made, draft = self._made
        return draft if motion is made and draft is not None else swath(motion, self.now)

    def free(self, motion: Motion) -> bool:
        """Return whether a motion from now on has no conflict."""
        ahead = self.ahead(motion)
        others, (draft, among) = self._around_of(ahead), self._free
        return (ahead is draft and others is among) or others.free(ahead)

    @property
    def others(self) -> Others:
        """People who may come near the course."""
        if self._others is None:
            self.look_again()
        near = self._foresight.near
        if self._others is None or self._others.near is not near:
            self._others = Others(self._commitments, self.me, near, self.now)
        return self._others

    def look_again(self) -> None:
        """Observe the others, and find the first conflict."""
        k, t = self._foresight.look()
        self._hit = None if k < 0 else self._commitments.hit(k, t)

    @property
    def first_hit(self) -> Hit | None:
        """First conflict of the preferred motion."""
        assert self.others is not None
        return self._hit

    def _around_of(self, ahead: Swath) -> Others:
        """Return the people who may come near a motion."""
        low_x, low_y, high_x, high_y = ahead.box
        if self._others is not None:
            seen = self._foresight.seen
            if low_x >= seen[0] and low_y >= seen[1] and high_x <= seen[2] and high_y <= seen[3]:
                return self.others
        return self._commitments.others(self.me, ahead.box, self.now)

    def hit(self, motion: Motion) -> Hit | None:
        """Return the first conflict of a motion from now on."""
        ahead = self.ahead(motion)
        return self._around_of(ahead).first_hit(ahead)

    def gone(self, t: float) -> float:
        """Return the length of the preferred motion until `t` (s), m."""
        return 0.0 if self.wished is None else self.wished.gone(self.t, t)

    def _taut(self, at: Point) -> list[Point]:
        """Return the route from `at` without unnecessary points, or a new route."""
        me = self.me
        # Corners that were passed may still be visible, and lead back.
        route = me.route[corners_passed([me.routed_from, *me.route], at) :]
        if me.goes_round and route:
            width = 2 * me.radius + GAP
            places = middles(self.standing(width, at, *route))
            # A person must not return to a passed bend because of a person beyond it.
            k = self._legs.farthest_round(*at, route, places, width)
            if k >= 0:
                return route[k:]
            me.goes_round = False
        k = self._legs.farthest(*at, route)
        return me.reroute(at) if k < 0 else route[k:]

    def send_by(self, route: list[Point]) -> None:
        """Replace the route to the goal."""
        self._commitments.set_goal(self.me, self.me.goal, route)

    def standing(self, around: float, *places: Point) -> MutableSequence[float]:
        """Return the people at rest around places: x, y, and the distance to keep from each (m)."""
        xs, ys = zip(*places, strict=True)
        box = numbers((min(xs), min(ys), max(xs), max(ys)))
        table = self._commitments
        return table.standing(table.indices[self.me], box, around, self.now)
