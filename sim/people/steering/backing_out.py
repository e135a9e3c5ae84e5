"""Backing out: all who stand in an aisle that is full from both ends make way for one of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from floorplan import Point
from navigation.kernels.edges import legs_of, touches

from .course import first, length_of, nearest_length, place_after, rest
from .moving import RequestedMoves
from .outlook import STEP, Ground, Outlook
from .traveller import Traveller
from .whereabouts import GAP, Whereabouts

BACK = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0)
"""Seconds that somebody waits who backs out behind others, and whoever they do it for."""

ROOM = 0.15
"""Metres. Who is so near beside the course of somebody for whom others back out does so too."""

NEAR = (0.1, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
"""Metres. So far around them they look for a place off the course."""

BESIDE = (1.1, 1.3, 1.8, 2.5)
"""The same beside a point of the course: in widths that two need."""

ANGLES = 16


def back_out(
    outlook: Outlook,
    course: Sequence[Point],
    length: float,
    floor: Whereabouts,
    moving: RequestedMoves,
    ground_of: Callable[[Traveller], Ground],
    refuses: Callable[[int], bool],
) -> bool:
    """Return whether all can back out of `length` metres of a course: they are `moving` then.

    And for whom they do. The one farthest ahead goes first, who has room behind, then the
    next, who goes by where that one stood: so a full aisle is emptied from its end, however many
    are in it. `refuses` says of somebody's index whether they may not be asked.
    """
    me, now = outlook.me, outlook.now
    way = first(course, length)
    at_once = outlook.draft(way)
    # Those who only wait for their turn, all the same way, have no reason to.
    if at_once is None or not any(floor.cosine(me, other, now) < 0.0 for other in outlook.others):
        return False
    if course is not outlook.course:
        course = [*way, *rest(outlook.course, length)]
    ahead = []
    for other in floor.others(me, at_once.box, now):
        gone = nearest_length(way, other.swath.place)
        away = math.dist(place_after(way, gone), other.swath.place)
        if away < me.radius + other.radius + ROOM:
            ahead.append((gone, other))
    ahead.sort(key=lambda one: -one[0])
    if any(refuses(floor.indices[who]) for _, who in ahead):
        return False
    moving.keep(0)
    for _, who in ahead:
        paths = _paths_off(who, course, who.radius + me.radius + GAP, ground_of(who))
        if not _backs_out(who, paths, moving, floor):
            return False
    k = floor.indices[me]
    for wait in BACK:
        draft = outlook.draft(way, delay=wait)
        if draft is None or moving.meet(k, draft.table, draft.box):
            continue
        if moving.first_other(k, draft.table, draft.box) < 0:
            moving.add(k, draft.table, draft.box)
            return True
    return False


def _backs_out(
    who: Traveller, paths: Iterator[list[Point]], moving: RequestedMoves, floor: Whereabouts
) -> bool:
    """Let `who` move on the first of `paths` on which they meet nobody; return whether they can."""
    k, now = floor.indices[who], moving.now
    for path in paths:
        for wait in BACK:
            draft = who.draft(path, now, wait)
            if draft is None:
                break
            hit = moving.first_other(k, draft.table, draft.box)
            if hit < 0 and not moving.meet(k, draft.table, draft.box):
                moving.add(k, draft.table, draft.box)
                return True
            if hit >= 0 and floor.rests[hit] <= now:
                break  # and stands there just as much later on
    return False


def _paths_off(
    who: Traveller, course: Sequence[Point], needed: float, ground: Ground
) -> Iterator[list[Point]]:
    """Yield paths `needed` metres off a course: to places near them, then ahead along it."""
    at = who.swath.place
    legs = legs_of([*course])

    def off(start: Point, radii: Sequence[float]) -> Iterator[Point]:
        for r in radii:
            for k in range(ANGLES):
                angle = 2 * math.pi * k / ANGLES
                place = (start[0] + r * math.cos(angle), start[1] + r * math.sin(angle))
                clear = not touches(legs, *place, *place, needed)
                if clear and ground.free_and_back(start, place):
                    yield place

    for place in off(at, NEAR):
        yield [at, place]
    beside = [share * needed for share in BESIDE]
    ahead = rest(course, nearest_length(course, at) + STEP)
    lengths = (k * STEP for k in range(math.ceil(length_of(ahead) / STEP) + 1))
    for path in ground.paths_ahead(at, ahead, lengths):
        for place in off(path[-1], beside):
            yield [*path, place]
