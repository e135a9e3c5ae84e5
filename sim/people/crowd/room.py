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
"""Places that are looked at around one that is taken: so many circles, and places on each."""

Place = tuple[Point, float]
"""Where somebody stands, and their radius (metres)."""


def places_at(
    world: CollisionWorld, place: Point, radius: float, vehicles: Collection[str]
) -> list[Point]:
    """Return `place` and those beside what stands there, for a body of `radius` metres.

    Those beside come first where something stands on it that is not a wall, and `place` itself is
    left out where that is one of these `vehicles`.
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
    """Return the free place nearest to `place`, where nothing but people stands.

    None if there is none `within` so many metres.

    `ground` returns the floor as people of this `radius` (metres) see it.
    Those on the `floor` but `me` are minded, and those who are about to stand where it is `taken`.
    The order of the places that are tried is fixed.
    """
    for ring in range(RINGS + 1):
        away = 0.5 * ring * (radius + GAP)
        if away > within:
            return None
        for k in range(ANGLES if ring else 1):
            angle = 2 * math.pi * k / ANGLES
            at = (place[0] + away * math.cos(angle), place[1] + away * math.sin(angle))
            # Standing there for ever must conflict with nobody's motion, as everything that is
            # agreed to.
            stand = swath(standing(at, start=now), now)
            near = [floor.people[k] for k in floor.near(stand.box, radius)]
            # The place itself was found fit by whoever chose it, however close to a wall.
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
