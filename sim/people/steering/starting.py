"""Places at which people start: their own, at home beside each other, or anywhere."""

from __future__ import annotations

import math
import zlib
from random import Random

import shapely

from floorplan import Problem
from navigation import CollisionWorld

from ...core.scenario import PersonEntry, Scenario, TrialError
from .course import Place
from .crowd import Crowd
from .outlook import GAP

TRIES = 5_000
"""Number of places that are drawn for one person."""

Standing = tuple[Place, float]
"""The place and the radius of somebody (metres)."""


def starting_places(trial: Scenario, world: CollisionWorld, crowd: Crowd | None) -> list[Place]:
    """Return where the people of a trial start, so that none of them overlap.

    First come those with places of their own, then the others in their order. `TrialError` says
    for whom there is no room.
    """
    usual = trial.floorplan.human.radius
    radii = [entry.radius or usual for entry in trial.people]
    places = [entry.place for entry in trial.people]
    for k, entry in enumerate(trial.people):
        taken = [(at, radii[j]) for j, at in enumerate(places) if at is not None]
        if places[k] is not None:
            continue
        if entry.at == "anywhere":
            places[k] = _anywhere(entry, trial.seed, world, radii[k], taken)
        else:
            home = entry.home_on(trial.floorplan)
            assert home is not None  # else the trial is refused
            places[k] = home.position
            if crowd is not None:
                places[k] = crowd.room(home.position, radii[k], taken=taken)
        if places[k] is None:
            found = "on the floor" if entry.at == "anywhere" else "at home; give at: [x, y]"
            message = f"people[{k}]: there is no room for {entry.name} {found}"
            raise TrialError(f"trial {trial.name!r}", [Problem(message)])
    return [place for place in places if place is not None]


def _anywhere(
    entry: PersonEntry, seed: int, world: CollisionWorld, radius: float, taken: list[Standing]
) -> Place | None:
    """Return a free place drawn evenly from the largest connected part of the floor."""
    space = world.free_space(radius + GAP)
    if not len(space.pieces):
        return None
    piece = max(space.pieces, key=lambda one: one.area)
    low_x, low_y, high_x, high_y = piece.bounds
    random = Random(zlib.crc32(f"{seed} start {entry.name}".encode()))
    for _ in range(TRIES):
        at = (random.uniform(low_x, high_x), random.uniform(low_y, high_y))
        if all(math.dist(at, other) >= radius + r + GAP for other, r in taken) and bool(
            shapely.intersects_xy(piece, *at)
        ):
            return at
    return None
