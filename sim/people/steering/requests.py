"""Requests to step aside: somebody who is stuck asks those in the way, and they ask on."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from itertools import islice, pairwise
from typing import NamedTuple

from floorplan import Point
from navigation import Swath, first_met, next_step, pace

from .course import first, length_of, place_after, rest
from .outlook import STEP, Ground, Outlook
from .traveller import Traveller
from .whereabouts import GAP, Others, Whereabouts

RINGS = (0.1, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
"""Metres. So far people look around them for a place to step aside to.

A step of 0.1 m opens an arch: two who touch each other in a door, with a third close behind them.
"""

ANGLES = 16

AROUND = [
    number
    for r in RINGS
    for k in range(ANGLES)
    for angle in (2 * math.pi * k / ANGLES,)
    for number in (r * math.cos(angle), r * math.sin(angle))
]
"""Metres. The places around them, the nearest first: x and y of each in turn."""

PASSED = 1.0
"""Metres. So far beyond the one in the way whoever asks wants to get."""

LANE = 1.0
"""Metres between the points of a course that is laid to a side."""

WAITS = (0.0, 0.5, 1.0, 2.0, 4.0)
"""Seconds that whoever asks waits for the others to be out of the way."""


class Effort(NamedTuple):
    """How far a request goes: the figures of the search for who moves where.

    People ask on along a chain of at most `deepest`, and at most `most` move; each tries `wide`
    places, and all together `tries` courses. Where the course of the asker leaves them no room, it
    is also laid `sides` metres to the left, where there are no walls: that opens an aisle in which
    two can pass each other only close to its walls.
    """

    deepest: int
    most: int
    wide: int
    tries: int
    sides: tuple[float, ...] = ()


USUAL = Effort(deepest=4, most=12, wide=6, tries=40)
"""Enough where there is room."""

MORE = Effort(deepest=10, most=24, wide=12, tries=200)
"""For who has asked in vain: in a throng many have to move a little, one after the other."""

UTMOST = MORE._replace(sides=(-0.45, 0.45, -0.9, 0.9, -0.2, 0.2))
"""For who has lost patience."""


class Request:
    """One request of `asker`, and what comes of it: where all go who move for it.

    Depth first: each asked looks for the nearest place off the way of whoever asks, else ahead of
    them, and asks those who stand in the way of that step. Nobody is asked who ranks higher than
    the first asker, unless they are `behind`: who waits for the asker to go on gains by it. Nor is
    who moves: passages that are agreed stay so. All of it is checked together.
    """

    def __init__(
        self,
        asker: Traveller,
        now: float,
        whereabouts: Whereabouts,
        ground_of: Callable[[Traveller], Ground],
        effort: Effort = USUAL,
        behind: Container[Traveller] = (),
    ) -> None:
        self._asker = asker
        self._now = now
        self._whereabouts = whereabouts
        self._ground_of = ground_of
        self._effort = effort
        self._behind = behind
        self._left = effort.tries
        self.drafts: dict[Traveller, Swath] = {}
        """Where everybody goes who moves for it."""

    def succeeds(self, outlook: Outlook, passed: float) -> bool:
        """Return whether all can move so that the asker gets past `passed` metres of its course."""
        # Just past the one in the way, or as far as they look ahead: to get anywhere at all comes
        # first.
        near = min(outlook.stop_beyond(passed + PASSED), outlook.whole)
        far = outlook.stop_beyond(outlook.reach)
        for length in dict.fromkeys((near, far)):
            for course in self._courses(outlook, length):
                # Who waits long enough is in nobody's way: those who can't step aside then never
                # can.
                latest = outlook.draft(course, length, delay=WAITS[-1])
                if latest is None:
                    continue
                self.drafts, self._left = {self._asker: latest}, self._effort.tries
                if self._clear(self._asker, first(course, length), 0):
                    self._set_out_sooner(outlook, course, length)
                    return True
        return False

    def _courses(self, outlook: Outlook, length: float) -> Iterator[Sequence[Point]]:
        """Yield the course of the asker, and if need be some beside the first `length` metres."""
        yield outlook.course
        for side in self._effort.sides:
            steps = [min(k * LANE, length) for k in range(1, math.ceil(length / LANE) + 1)]
            ways = [outlook.walks.at(along) for along in steps]
            course = [outlook.at, *((x - side * s, y + side * c) for x, y, c, s in ways)]
            if all(outlook.ground.free(a, b) for a, b in pairwise(course)):
                yield course

    def _set_out_sooner(self, outlook: Outlook, course: Sequence[Point], length: float) -> None:
        """Let the asker set out as soon as all the others who move are out of its way."""
        others = {who: draft for who, draft in self.drafts.items() if who is not self._asker}
        moving = Moving(others, self._now)
        for wait in WAITS[:-1]:
            draft = outlook.draft(course, length, delay=wait)
            if draft is None or moving.meet(self._asker, draft):
                continue
            if self._near(self._asker, draft).free(draft):
                self.drafts[self._asker] = draft
                return

    def make_way(self, course: Sequence[Point]) -> None:
        """Let all who can step off the motion that the asker is committed to, along `course`."""
        self.drafts = {self._asker: self._asker.swath}
        self._clear(self._asker, course, 0)

    def _near(self, mover: Traveller, draft: Swath) -> Others:
        """Return those who may come near where `mover` goes, but who move for the request."""
        return self._whereabouts.others(mover, draft.box, self._now).without(self.drafts)

    def _clear(self, mover: Traveller, course: Sequence[Point], depth: int) -> bool:
        """Let all step aside who stand in the way of `mover`; return whether they can."""
        # All of a chain is checked against what everybody else is committed to, and the chain's own
        # drafts against each other, so that all can be committed to at once.
        draft = self.drafts[mover]
        others = self._near(mover, draft)
        while True:
            hit = others.first_hit(draft)
            if hit is None:
                return True
            if depth >= self._effort.deepest or len(self.drafts) > self._effort.most:
                return False
            if not self._may_ask(hit.other):
                return False
            if not self._step(hit.other, course, depth):
                return False
            others = others.without(self.drafts)

    def _may_ask(self, other: Traveller) -> bool:
        return (
            other is not self._asker
            and other.manners.steps_aside
            and not other.recorded
            and other.body.motion.end <= self._now
            and (other.rank > self._asker.rank or other in self._behind)
        )

    def _step(self, who: Traveller, course: Sequence[Point], depth: int) -> bool:
        """Let `who` step off `course`, and whoever is in the way of that; else leave all as is."""
        # Depth first: a step that leads nowhere takes all those back that were made for it.
        before = dict(self.drafts)
        for retreat, draft in islice(self._retreats(who, course), self._effort.wide):
            self._left -= 1
            if self._left < 0:
                break
            self.drafts[who] = draft
            if self._clear(who, retreat, depth + 1):
                return True
            self.drafts = dict(before)
        return False

    def _retreats(
        self, who: Traveller, course: Sequence[Point]
    ) -> Iterator[tuple[list[Point], Swath]]:
        """Yield courses off `course`: to the nearest places around, then to places ahead of it.

        And what comes of them; none meets anybody who moves.
        """
        at, ground = who.swath.place, self._ground_of(who)
        # With `who`'s own radius for the other's: a sieve, as `Moving` checks each step exactly.
        needed = 2 * who.radius + GAP
        legs = [number for a, b in pairwise(course) for number in (*a, *b)]
        moving = Moving(self.drafts, self._now)
        # Off the course first. Only where it fills the aisle do they walk ahead along it, to its
        # next wide place.
        yield from moving.steps(who, [at], AROUND, legs, needed, ground)
        gone, near = 0.0, math.inf
        whole = length_of(course)
        steps = [k * STEP for k in range(math.ceil(whole / STEP) + 1)]
        # The place on the course that is nearest to them: all before that is behind them.
        for s in steps:
            away = math.dist(place_after(course, s), at)
            if away < near:
                near, gone = away, s
        beside = [
            number
            for k in range(ANGLES // 2)
            for angle in (4 * math.pi * k / ANGLES,)
            for r in (needed + 0.02, 1.3 * needed)
            for number in (r * math.cos(angle), r * math.sin(angle))
        ]
        beyond = rest(course, gone + STEP)
        free: set[tuple[Point, Point]] = set()
        for s in steps:
            if s <= gone + STEP:
                continue
            path = [at, *first(beyond, s - gone - STEP)]
            for leg in pairwise(path):
                if leg not in free and not ground.free_and_back(*leg):
                    return
                free.add(leg)
            yield from moving.steps(who, path, beside, legs, needed, ground)


class Moving:
    """Those who move for a request, as of `now` (seconds): where each of them goes."""

    def __init__(self, drafts: Mapping[Traveller, Swath], now: float) -> None:
        self._now = now
        self._near = [*range(len(drafts))]
        self._tables = [draft.table for draft in drafts.values()]
        self._boxes = [bound for draft in drafts.values() for bound in draft.box]
        self._radii = [who.radius for who in drafts]

    def meet(self, who: Traveller, draft: Swath) -> bool:
        """Return whether somebody who goes like this would come too close to any of them."""
        found = first_met(
            draft.table,
            draft.box,
            self._near,
            self._tables,
            self._boxes,
            self._radii,
            who.radius + GAP,
            self._now,
            [math.inf],
        )
        return found >= 0

    def steps(
        self,
        who: Traveller,
        path: list[Point],
        places: list[float],
        legs: list[float],
        width: float,
        ground: Ground,
    ) -> Iterator[tuple[list[Point], Swath]]:
        """Yield the courses of `who` along `path` and on to each of the `places` that are fit.

        Those `width` metres off the `legs` of a course, without a wall in between, and in the way
        of none of these.
        """
        flat = [number for corner in path for number in corner]
        x, y = path[-1]
        k = -1
        while True:
            table: list[float] = []
            box: list[float] = []
            k = next_step(
                k + 1,
                flat,
                places,
                legs,
                width,
                self._now,
                who.top_speed,
                who.human.max_speed,
                who.human.max_acceleration,
                self._near,
                self._tables,
                self._boxes,
                self._radii,
                who.radius + GAP,
                table,
                box,
            )
            if k < 0:
                return
            place = (x + places[2 * k], y + places[2 * k + 1])
            if not ground.free_and_back((x, y), place):
                continue
            retreat, draft = [*path, place], Swath.of(table, box)
            if who.zones:
                points, top = who.zones.along(retreat, who.top_speed)
                slower = pace(
                    points,
                    self._now,
                    top_speed=top,
                    max_speed=who.human.max_speed,
                    max_acceleration=who.human.max_acceleration,
                )
                if slower is None or self.meet(who, slower):
                    continue
                draft = slower
            yield retreat, draft
