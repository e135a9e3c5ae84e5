"""Discs that meet, walks in closed form, and walls, beside ways to tell that know no tables."""

import math
import random
from contextlib import suppress

import numpy as np
import pytest

import floorplan
import navigation
from navigation.walking import first_conflict, swath as swath_of


def places(rng: random.Random, count: int) -> list[tuple[float, float]]:
    return [(rng.uniform(0, 6), rng.uniform(0, 6)) for _ in range(count)]


def walks(rng: random.Random) -> navigation.Motion:
    while True:
        with suppress(ValueError):  # too short to slow down on
            return navigation.walk(
                places(rng, rng.randint(2, 6)),
                rng.uniform(0, 3),
                initial_speed=rng.choice([0.0, 0.3, 0.9]),
                top_speed=rng.choice([1.0, 0.5, 0.25]),
                max_speed=1.0,
                max_acceleration=2.5,
            )


def test_conflicts_are_those_that_the_monitor_sees():
    rng = random.Random(4)
    for _ in range(300):
        one, other = walks(rng), walks(rng)
        least = rng.uniform(0.1, 1.5)
        t = first_conflict(swath_of(one, 3.0), swath_of(other, 3.0), least, 3.0)
        end = max(one.end, other.end, 3.0) + 1.0
        law = navigation.FixedDistance(least)
        found = navigation.violations(one, other, law, 3.0, end)
        if t is None:
            assert not found
        elif found:
            assert t == pytest.approx(found[0][0], abs=2e-4)
        else:  # no more than rounding
            assert navigation.minimum_separation(one, other, 3.0, end)[1] < least + 1e-3


def test_who_stands_as_near_as_may_be_can_walk_away():
    """To any side of the line across, at once, and however hard; but not the other way."""
    rng = random.Random(7)
    for _ in range(200):
        at, to_other = places(rng, 1)[0], rng.uniform(-math.pi, math.pi)
        other = (at[0] + 0.606 * math.cos(to_other), at[1] + 0.606 * math.sin(to_other))
        theirs = swath_of(navigation.standing(other), 0.0)
        for turned, meets in ((rng.uniform(0.5, 1.5), False), (rng.uniform(-0.45, 0.45), True)):
            heading = to_other + turned * math.pi
            walk = navigation.walk(
                [at, (at[0] + math.cos(heading), at[1] + math.sin(heading))],
                0.0,
                max_speed=1.0,
                max_acceleration=rng.uniform(0.5, 8.0),
            )
            least = math.dist(at, other) - 1e-9
            found = first_conflict(swath_of(walk, 0.0), theirs, least, 0.0)
            assert (found is not None) == meets


def test_walks_keep_their_limits_and_are_what_their_swaths_are():
    rng = random.Random(5)
    for _ in range(200):
        walk = walks(rng)
        t = np.linspace(walk.start, walk.end, 200)
        assert np.hypot(*walk.velocity(t).T).max() <= 1.0 + 1e-9
        assert all(abs(a) <= 2.5 + 1e-9 for s in t for a in walk.state(s).acceleration[:2])
        swath = swath_of(walk, walk.start)
        assert swath.motion(0.0).position(t) == pytest.approx(walk.position(t))
        assert (walk.position(t) >= np.array(swath.box[:2]) - 1e-9).all()
        assert (walk.position(t) <= np.array(swath.box[2:]) + 1e-9).all()


def test_walls_are_where_the_world_has_them():
    rng = random.Random(6)
    world = navigation.CollisionWorld(floorplan.load("ariac2023"))
    walls, (low_x, low_y, high_x, high_y) = world.walls(0.3), world.plan.boundary.bounds
    for _ in range(2000):
        a = (rng.uniform(low_x, high_x), rng.uniform(low_y, high_y))
        away = rng.choice([0.3, 1.0, 3.0, 8.0])
        b = (a[0] + rng.uniform(-away, away), a[1] + rng.uniform(-away, away))
        if world.segment_free(a, a, 0.3, among=()):
            assert walls.clear(a, b) == world.segment_free(a, b, 0.3, among=())
