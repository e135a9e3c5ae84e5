"""Steering: the choice of a course among people."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Protocol

from navigation import Motion

from .course import Place, first, heading, length_of, rest
from .outlook import GAP, Hit, Outlook
from .traveller import Traveller

SIDEWAYS = (0.45, 0.9, 1.35)
"""Metres. Shifts to the side that are tried besides the one that just gets past."""

WIDEST = 1.8
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

Proposal = tuple[float, Callable[[], "Motion | None"]]
"""Metres that a course loses, and the motion along it, if it is possible."""


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
        wish = outlook.wish
        if wish is None:
            return None
        hit = outlook.hit(wish, body.manners.comfort)
        if hit is None:
            return wish
        proposals = sorted(self._proposals(body, outlook, wish, hit), key=lambda one: one[0])
        for _, make in proposals:
            motion = make()
            if motion is not None and outlook.free(motion):
                return motion
        return None

    def _proposals(
        self, me: Traveller, outlook: Outlook, wish: Motion, hit: Hit
    ) -> Iterator[Proposal]:
        yield BRUSH, lambda: wish
        gone = outlook.gone(wish, hit.t)
        whole = length_of(first(outlook.course, outlook.reach))
        for loss, course in asides(me, outlook, hit, gone):
            yield loss, partial(_walk_aside, outlook, course)
        stop = outlook.stop_beyond(outlook.reach)
        walk = partial(outlook.walk, outlook.course)
        for pace in SHARES:
            yield (1 - pace) * whole, partial(walk, stop, top_speed=pace * me.top_speed)
        if outlook.speed < STANDS:
            for delay in DELAYS:
                yield delay * me.top_speed, partial(walk, stop, delay=delay)
        follows = _same_way(me, hit, outlook.now)
        share = PHANTOM if hit.at_rest and follows else 1.0
        for length in self._stops(me, outlook, gone, follows):
            yield share * max(whole - length, 0.0), partial(walk, length)

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


def _walk_aside(outlook: Outlook, course: list[Place]) -> Motion | None:
    ground = outlook.ground
    if not outlook.can_turn(course):
        return None
    if not all(ground.free(a, b) for a, b in pairwise(course[:4])):
        return None
    length = outlook.reach + 0.5
    return outlook.walk(course, min(length, length_of(course)))


def _same_way(me: Traveller, hit: Hit, now: float) -> bool:
    """Return whether the other walks the same way, or will."""
    mine, theirs = me.direction(now), hit.other.direction(now)
    if mine is None or theirs is None:
        return False
    return mine[0] * theirs[0] + mine[1] * theirs[1] > 0.3


def asides(
    me: Traveller, outlook: Outlook, hit: Hit, gone: float
) -> Iterator[tuple[float, list[Place]]]:
    """Yield courses that pass the other on either side, and what they lose (metres)."""
    other = hit.other
    c, s = heading(outlook.course, max(gone - 1e-6, 0.0))
    x, y = rest(outlook.course, gone)[0]
    px, py = other.body.motion.state(hit.t).at
    ahead, beside = (px - x) * c + (py - y) * s, (py - y) * c - (px - x) * s
    needed = me.radius + other.radius + GAP
    sides = [beside - needed - me.manners.comfort, beside + needed + me.manners.comfort]
    sides += [beside - needed - 1e-3, beside + needed + 1e-3]
    if not hit.at_rest:
        sides += [side for width in SIDEWAYS for side in (-width, width)]
    usual = -1.0 if me.manners.passing_side == "right" else 1.0
    for side in dict.fromkeys(sides):
        if not 0.02 < abs(side) < WIDEST:
            continue
        course = aside(outlook.course, gone + max(ahead, 0.0), side)
        loss = length_of(course) - length_of(outlook.course)
        yield loss + (OTHER_SIDE if side * usual < 0 else 0.0), course


def aside(course: Sequence[Place], length: float, side: float) -> list[Place]:
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
) -> Iterator[tuple[Motion, Motion]]:
    """Yield motions in which two who meet head-on both shift to their side, the usual one first."""
    wish = mine.wish
    if wish is None or theirs.wish is None:
        return
    other = hit.other
    gone = mine.gone(wish, hit.t)
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
                first_motion, second = _walk_aside(mine, one), _walk_aside(theirs, two)
                if first_motion is not None and second is not None:
                    yield first_motion, second


def _nearest_length(course: Sequence[Place], place: Place) -> float:
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
