"""Room: free positions where a person can stand."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence

from floorplan import Point
from navigation import CollisionWorld, standing
from navigation.walking import first_conflict, swath

from .commitments import GAP, Commitments
from .ground import Ground
from .traveller import Traveller

RINGS, ANGLES = 24, 24
"""Number of circles around an occupied place, and number of positions on each."""

Place = tuple[Point, float]
"""Position and radius of a stationary person, m."""


def places_at(
    world: CollisionWorld, place: Point, radius: float, vehicles: Collection[str]
) -> list[Point]:
    """Return `place`, and positions beside it if it is occupied, for a disc of `radius` metres.

    Positions beside a body on `place` come first. If the body is one of `vehicles`, `place` is
    omitted.
    """
    exits = [] if world.free(place, radius) else [*world.exits(place, radius)]
    touching = {body.name for body in world.hits(place, place, radius)}
    if not touching:
        return [place, *exits]
    return exits if touching & set(vehicles) else [*exits, place]


def room_near(
    place: Point,
    radius: float,
    ground: Callable[[], Ground],
    floor: Commitments,
    now: float,
    me: Traveller | None,
    taken: Sequence[Place],
    within: float = math.inf,
) -> Point | None:
    """Return the free position nearest to `place`, on which there are only people, or None.

    `ground` returns the ground for people of this `radius` (m). The position is free of the
    committed motions of others and of the `taken` positions, and `within` a distance (m).
    """
    for ring in range(RINGS + 1):
        away = 0.5 * ring * (radius + GAP)
        if away > within:
            return None
        for k in range(ANGLES if ring else 1):
            angle = 2 * math.pi * k / ANGLES
            at = (place[0] + away * math.cos(angle), place[1] + away * math.sin(angle))
            stand = swath(standing(at, start=now), now)
            near = [floor.people[k] for k in floor.near(stand.box, radius)]
            # The caller has checked the distance of `place` to walls.
            if (
                (ring == 0 or ground().free_and_back(place, at))
                and all(math.dist(at, other) >= radius + r + GAP for other, r in taken)
                and not any(
                    first_conflict(stand, other.swath, radius + other.radius + GAP, now) is not None
                    for other in near
                    if other is not me
                )
            ):
                return at
    return None
