"""Start positions of people: given, beside each other at home, or anywhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import TypeGuard

import shapely

from floorplan import Floorplan, Point, Problem
from navigation import CollisionWorld

from ...core.entries import seed_of
from ...core.scenario import PersonEntry, Scenario, TrialError
from .commitments import GAP
from .crowd import Crowd

TRIES = 5_000
"""Maximum number of random positions for one person."""

WINGS = 1000.0
"""Distance from the floor at which absent people are, m."""

Standing = tuple[Point, float]
"""Position and radius of a person, m."""


def starting_places(trial: Scenario, world: CollisionWorld, crowd: Crowd) -> list[Point]:
    """Return the start positions of all people, without overlaps.

    People with a given position come first, then the others in their order. A `TrialError` names
    a person for whom there is no room.
    """
    plan = trial.floorplan
    radii = [entry.radius or plan.human.radius for entry in trial.people]
    places = [entry.place_on(plan) for entry in trial.people]
    taken = [(at, radius) for at, radius in zip(places, radii, strict=True) if at is not None]
    for k, entry in enumerate(trial.people):
        if places[k] is not None:
            continue
        if entry.source is not None:
            places[k] = wings(plan, k)
            continue
        leader = trial.leader(entry)
        at: Point | None
        if entry.anywhere and _is_there(leader):
            beside = places[trial.people.index(leader)]
            assert beside is not None  # leaders come before their groups
            at = crowd.room(beside, radii[k], taken=taken)
        elif entry.anywhere:
            at = _anywhere(entry, trial.seed, world, radii[k], taken)
        else:
            home = entry.home_on(plan)
            assert home is not None  # checks reject trials without a home
            at = crowd.room(home.position, radii[k], taken=taken)
        if at is None:
            where = "on the floor" if entry.anywhere else "at home; give at: [x, y]"
            message = f"people[{k}]: there is no room for {entry.name} {where}"
            raise TrialError(f"trial {trial.name!r}", [Problem(message)])
        places[k] = at
        taken.append((at, radii[k]))
    return [place for place in places if place is not None]


def with_homes(trial: Scenario, starts: Sequence[Point]) -> tuple[PersonEntry, ...]:
    """Return the people of a trial. The start position is the home of people without one."""
    return tuple(
        replace(entry, home=at) if entry.home_on(trial.floorplan) is None else entry
        for entry, at in zip(trial.people, starts, strict=True)
    )


def _is_there(leader: PersonEntry | None) -> TypeGuard[PersonEntry]:
    """Return whether there is a leader who is on the floor at the start."""
    return leader is not None and leader.source is None


def wings(plan: Floorplan, index: int) -> Point:
    """Return the position of an absent person, far from the floor and from other absent people."""
    low_x, low_y, _, _ = plan.boundary.bounds
    return (low_x - WINGS, low_y - WINGS - 10.0 * index)


def _anywhere(
    entry: PersonEntry, seed: int, world: CollisionWorld, radius: float, taken: list[Standing]
) -> Point | None:
    """Return a random free position in the largest connected part of the floor, or None."""
    space = world.free_space(radius + GAP)
    if not len(space.pieces):
        return None
    piece = max(space.pieces, key=lambda one: one.area)
    low_x, low_y, high_x, high_y = piece.bounds
    random = Random(seed_of(seed, f"start {entry.name}"))
    # Rejection sampling from the bounds is uniform for every shape of the piece.
    for _ in range(TRIES):
        at = (random.uniform(low_x, high_x), random.uniform(low_y, high_y))
        if all(math.dist(at, other) >= radius + r + GAP for other, r in taken) and bool(
            shapely.intersects_xy(piece, *at)
        ):
            return at
    return None
