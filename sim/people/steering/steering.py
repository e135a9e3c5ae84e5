"""Steering: the choice of a course among people."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple, Protocol

from floorplan import Point
from navigation import Motion, Swath

from .course import first, heading, length_of, rest
from .outlook import GAP, Hit, Outlook
from .traveller import Traveller

SIDEWAYS = (0.45, 0.9, 1.35)
"""Metres. Shifts to the side that are tried besides the one that just gets past."""

DETOURS = (2.0, 2.8, 3.6)
"""Metres. Shifts that somebody tries who stands before others who don't go the same way."""

WIDEST = 3.6
"""Metres. Nobody shifts further to the side than this."""

SHARES = (0.75, 0.5, 0.25)
"""Shares of the top speed that are tried."""

DELAYS = (0.5, 1.0, 2.0, 4.0)
"""Seconds that somebody who stands waits before setting out."""

SHORTEST = 0.3
"""Metres. Nobody who stands sets out for less."""

PHANTOM = 0.3
"""Share that a stop behind somebody who is about to walk on counts of the metres it loses."""

PARTS = (1.0, 0.8, 0.6, 0.4, 0.2)
"""Parts of the free stretch ahead after which a stop is tried."""

STANDS = 1e-6
"""m/s. Slower than this is standing."""

OTHER_SIDE = 0.15
"""Metres. What passing on the less usual side costs."""

BRUSH = 0.5
"""Metres. Detour that keeping the comfort distance is worth."""


class Proposal(NamedTuple):
    """A walk along a course, and the metres that it loses.

    `length` and `top_speed` (metres, m/s) are as for `Outlook.walk`, and `delay` (seconds).
    """

    loss: float
    course: list[Point]
    length: float
    top_speed: float | None = None
    delay: float = 0.0


class Steering(Protocol):
    """Interface of a steering: it decides how somebody walks on among others."""

    def replan(
        self, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        """Return the motion that `body` should follow from now on; None to leave it as it is.

        `neighbours` are those who may come near, with the motions that they are committed to.
        A motion that comes too close to any of them, its final standing included, is not followed:
        the old one goes on, which is safe.
        """
        ...


class Foresighted:
    """Takes the free course that loses least: aside, slower, shorter, or later.

    People see what others have committed themselves to, and test each course against all of it.
    """

    def replan(
        self, body: Traveller, neighbours: Sequence[Traveller], outlook: Outlook
    ) -> Motion | None:
        """See `Steering`."""
        wished = outlook.wished
        if wished is None:
            return None
        near = outlook.others.first_hit(wished, comfort=True)
        if near is None:
            return outlook.wish
        hit = outlook.others.first_hit(wished)
        if hit is None:
            brush = Proposal(BRUSH, outlook.course, outlook.stop_beyond(outlook.reach))
            draft = _first_free(outlook, [brush, *_asides(body, outlook, near)])
            if draft is not None and draft.table == wished.table:
                return outlook.wish
        else:
            follows = _same_way(body, hit, outlook.now)
            proposals = [*self._later_or_shorter(body, outlook, hit, follows)]
            if hit.at_rest and follows:
                # They are about to walk on: nobody passes them where they can get nearer.
                draft = _first_free(outlook, proposals)
                if draft is not None:
                    return outlook.made(draft)
                proposals = []
            proposals += _asides(body, outlook, near)
            if near.other is not hit.other:
                proposals += _asides(body, outlook, hit)
            draft = _first_free(outlook, proposals)
            if draft is None and outlook.speed < STANDS and not follows:
                outlook.look_around(DETOURS[-1])
                draft = _first_free(outlook, _asides(body, outlook, hit, DETOURS))
        return None if draft is None else outlook.made(draft)

    def _later_or_shorter(
        self, me: Traveller, outlook: Outlook, hit: Hit, follows: bool
    ) -> Iterator[Proposal]:
        """Yield walks along the course that are slower, later, or end before the other.

        Who `follows` goes the same way as the other.
        """
        course, stop = outlook.course, outlook.stop_beyond(outlook.reach)
        whole = length_of(first(course, outlook.reach))
        if not hit.at_rest:  # else it would be as much in the way later on
            for pace in SHARES:
                yield Proposal((1 - pace) * whole, course, stop, top_speed=pace * me.top_speed)
            if outlook.speed < STANDS:
                for delay in DELAYS:
                    yield Proposal(delay * me.top_speed, course, stop, delay=delay)
        share = PHANTOM if hit.at_rest and follows else 1.0
        for length in self._stops(me, outlook, outlook.gone(hit.t), follows):
            yield Proposal(share * max(whole - length, 0.0), course, length)

    def _stops(
        self, me: Traveller, outlook: Outlook, gone: float, follows: bool
    ) -> Iterator[float]:
        """Yield the lengths after which to stop short of a conflict `gone` metres ahead.

        Not in a narrow place, but behind somebody who leaves it the same way.
        """
        stands = outlook.speed < STANDS
        braking = outlook.speed**2 / (2 * me.human.max_acceleration) * 1.001
        for part in PARTS:
            length = part * gone if follows else outlook.stop_before(part * gone)
            if length >= (SHORTEST if stands else braking):
                yield length
        if not stands:
            yield braking


def _first_free(outlook: Outlook, proposals: list[Proposal]) -> Swath | None:
    """Return the draft of the proposal that loses least of those that are free."""
    proposals.sort(key=_loss)
    for one in proposals:
        draft = _draft(outlook, one)
        if draft is not None and outlook.others.free(draft) and _has_room(outlook, one):
            return draft
    return None


def _loss(one: Proposal) -> float:
    return one.loss


def _draft(outlook: Outlook, one: Proposal) -> Swath | None:
    if one.course is not outlook.course and not outlook.can_turn(one.course):
        return None
    return outlook.draft(one.course, one.length, top_speed=one.top_speed, delay=one.delay)


def _has_room(outlook: Outlook, one: Proposal) -> bool:
    """Return whether there are no walls in the way; people were looked at before, it is quicker."""
    free = outlook.ground.free
    return one.course is outlook.course or all(free(a, b) for a, b in pairwise(one.course[:4]))


def _asides(
    me: Traveller, outlook: Outlook, hit: Hit, widths: Sequence[float] = ()
) -> list[Proposal]:
    """Return the courses that pass the other, or all that stand there at these `widths`."""
    length = outlook.reach + 0.5
    return [Proposal(loss, course, length) for loss, course in asides(me, outlook, hit, widths)]


def _same_way(me: Traveller, hit: Hit, now: float) -> bool:
    """Return whether the other walks the same way, or will."""
    mine, theirs = me.direction(now), hit.other.direction(now)
    if mine is None or theirs is None:
        return False
    return mine[0] * theirs[0] + mine[1] * theirs[1] > 0.3


def asides(
    me: Traveller, outlook: Outlook, hit: Hit, widths: Sequence[float] = ()
) -> Iterator[tuple[float, list[Point]]]:
    """Yield courses that pass the other on either side, and what they lose (metres).

    Just past the other and a little wider, or else by these `widths` (metres) alone.
    """
    other, gone = hit.other, outlook.gone(hit.t)
    c, s = heading(outlook.course, max(gone - 1e-6, 0.0))
    x, y = rest(outlook.course, gone)[0]
    px, py = other.body.motion.state(hit.t).at
    ahead, beside = (px - x) * c + (py - y) * s, (py - y) * c - (px - x) * s
    needed = me.radius + other.radius + GAP
    sides = [side for width in widths or SIDEWAYS for side in (-width, width)]
    if not widths:
        wide = needed + me.manners.comfort
        sides = [
            beside - wide,
            beside + wide,
            beside - needed - 1e-3,
            beside + needed + 1e-3,
            *sides,
        ]
    usual = -1.0 if me.manners.passing_side == "right" else 1.0
    for side in dict.fromkeys(sides):
        if not 0.02 < abs(side) <= WIDEST:
            continue
        course = aside(outlook.course, gone + max(ahead, 0.0), side)
        loss = length_of(course) - length_of(outlook.course)
        yield loss + (OTHER_SIDE if side * usual < 0 else 0.0), course


def aside(course: Sequence[Point], length: float, side: float) -> list[Point]:
    """Return a course that is `side` metres to the left of another after `length` metres."""
    c, s = heading(course, max(length - 1e-6, 0.0))
    x, y = rest(course, length)[0]
    ramp = 1.2 * abs(side)
    early, late = min(0.35, length), 0.35
    before = (x - early * c - side * s, y - early * s + side * c)
    after = (x + late * c - side * s, y + late * s + side * c)
    whole = length_of(course)
    if length + late >= whole:  # the goal itself is beside the other
        return [course[0], before, course[-1]]
    return [course[0], before, after, *rest(course, min(length + late + ramp, whole))]


def both_aside(
    me: Traveller, mine: Outlook, hit: Hit, theirs: Outlook
) -> Iterator[tuple[Swath, Swath]]:
    """Yield drafts in which two who meet head-on both shift to their side, the usual one first."""
    if mine.wished is None or theirs.wished is None:
        return
    other = hit.other
    gone = mine.gone(hit.t)
    c, s = heading(mine.course, max(gone - 1e-6, 0.0))
    x, y = rest(mine.course, gone)[0]
    px, py = other.body.motion.state(hit.t).at
    ahead, beside = (px - x) * c + (py - y) * s, (py - y) * c - (px - x) * s
    place = rest(mine.course, gone + max(ahead, 0.0) / 2)[0]
    passed = _nearest_length(theirs.course, place)
    needed = me.radius + other.radius + GAP + 1e-3
    comfort = min(me.manners.comfort, 0.1)
    usual = -1.0 if me.manners.passing_side == "right" else 1.0
    for spare in (comfort, 0.0):
        for way in (usual, -usual):
            width = needed + spare + way * beside
            if width <= 0.0:
                continue
            for share in (0.5, 0.7, 0.3):
                one = aside(mine.course, max(gone + ahead / 2, 0.1), way * share * width)
                two = aside(theirs.course, max(passed, 0.1), way * (1 - share) * width)
                both = [
                    (outlook, Proposal(0.0, course, outlook.reach + 0.5))
                    for outlook, course in ((mine, one), (theirs, two))
                ]
                ours, yours = (_draft(*walk) for walk in both)
                if ours and yours and all(_has_room(*walk) for walk in both):
                    yield ours, yours


def _nearest_length(course: Sequence[Point], place: Point) -> float:
    """Return the length along a polyline at which it is nearest to a point."""
    best, at, gone = math.inf, 0.0, 0.0
    for (ax, ay), (bx, by) in pairwise(course):
        leg = math.hypot(bx - ax, by - ay)
        if leg < 1e-9:
            continue
        u = ((place[0] - ax) * (bx - ax) + (place[1] - ay) * (by - ay)) / leg
        u = min(max(u, 0.0), leg)
        away = math.hypot(ax + u * (bx - ax) / leg - place[0], ay + u * (by - ay) / leg - place[1])
        if away < best:
            best, at = away, gone + u
        gone += leg
    return at
