"""Floors of many obstacles, in tiles."""

import itertools
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import shapely
from hypothesis import given, settings, strategies as st
from plane_oracle import floor, gap, length, room, shortest
from shapely.geometry import box

from navigation import CollisionWorld, Disc, PathPlanner, PlanningError

RADIUS = 0.3


def hall(count, spacing, seed):
    """Return a square hall with obstacles at random places, one per cell."""
    rng = np.random.default_rng(seed)
    across = math.ceil(math.sqrt(count))
    cell = np.array([(k % across, k // across) for k in range(count)])
    centre = (cell + 0.5 + rng.uniform(-0.2, 0.2, (count, 2))) * spacing
    half = rng.uniform(0.3, 0.6, (count, 2))
    shapes = shapely.box(*(centre - half).T, *(centre + half).T)
    side = across * spacing
    return floor(*shapes.tolist(), boundary=box(0, 0, side, side))


def cluttered(count, side, seed):
    """Return a square hall with overlapping obstacles of any size and angle, and long walls."""
    rng = np.random.default_rng(seed)
    shapes = []
    for _ in range(count):
        thing = box(0, 0, *rng.uniform(0.2, 2.0, 2))
        if rng.random() < 0.1:
            thing = box(0, 0, side / 2, 0.1)
        turned = shapely.affinity.rotate(thing, rng.uniform(0, 360))
        shapes.append(shapely.affinity.translate(turned, *rng.uniform(0, side, 2)))
    return floor(*shapes, boundary=box(0, 0, side, side))


def free_places(plan, count, seed, margin=RADIUS + 0.01):
    rng = np.random.default_rng(seed)
    low, high = np.array(plan.boundary.bounds).reshape(2, 2)
    places = rng.uniform(low, high, (50 * count, 2))
    edges = plan.free(0.0, 1.75)
    shapely.prepare(edges)
    clear = shapely.contains_xy(edges, places)
    clear &= ~shapely.dwithin(edges.boundary, shapely.points(places), margin)
    return [tuple(place) for place in places[clear][:count].tolist()]


def graze(bends, along):
    """Return whether lines along (N, 2) pass the corners at `bends` without entering them."""
    slack = 1e-9 * (1 + np.abs(along).sum(axis=1))
    ways = np.stack([bends.before, bends.after])
    turns = ways[..., 0] * along[:, 1] - ways[..., 1] * along[:, 0]
    return (turns.min(axis=0) <= slack) & (turns.max(axis=0) >= -slack)


def touching(seed):
    """Return a floor of square cells of which a quarter are blocked. Many touch at a corner."""
    blocked = np.random.default_rng(seed).random((16, 16)) < 0.25
    cells = [box(x, y, x + 1, y + 1) for x, y in np.argwhere(blocked).tolist()]
    return floor(*cells, boundary=box(0, 0, 16, 16))


def lined_up(seed):
    """Return posts in rows, in whose aisles bends are in line, so that cuts may meet them."""
    across, post, aisle = 11, 0.4, 2 * (RADIUS + 1e-4)
    there = np.random.default_rng(seed).random((across, across)) < 0.9
    corner = np.argwhere(there) * (post + aisle)
    side = across * (post + aisle)
    return floor(
        *shapely.box(*corner.T, *(corner.T + post)).tolist(),
        boundary=box(-aisle, -aisle, side, side),
    )


FLOORS = {
    "hall": lambda seed: hall(36, 4.0, seed),
    "many": lambda seed: hall(121, 3.0, seed),  # in several tiles
    "clutter": lambda seed: cluttered(60, 24.0, seed),
    "cells": touching,
    "lines": lined_up,
}


@settings(max_examples=settings.default.max_examples // 12)
@given(st.integers(0, 2**32), st.sampled_from([*FLOORS]))
def test_no_link_is_missed(seed, kind):
    """Compare the links of the roadmap with tests of all pairs of bends."""
    plan = FLOORS[kind](seed)
    world = CollisionWorld(plan)
    roadmap = PathPlanner(world, RADIUS).roadmap()
    bends = roadmap.bends
    some = np.random.default_rng(seed).choice(len(bends), 40, replace=False)
    of = np.repeat(some, len(bends))
    to = np.tile(np.arange(len(bends)), len(some))
    along = bends.point[to] - bends.point[of]
    worth = (of != to) & graze(bends.take(of), along) & graze(bends.take(to), along)
    of, to = of[worth], to[worth]
    one, other = np.minimum(of, to), np.maximum(of, to)
    lines = shapely.linestrings(np.stack([bends.point[one], bends.point[other]], axis=1))
    free = ~shapely.dwithin(world.edges, lines, RADIUS + 5e-5)
    expected = {
        k: {(j, math.dist(bends.point[k], bends.point[j])) for j in to[free & (of == k)].tolist()}
        for k in some.tolist()
    }
    assert {k: set(roadmap.links_of(k)) for k in expected} == expected
    assert any(expected.values())


@settings(max_examples=settings.default.max_examples // 12)
@given(st.integers(0, 2**32), st.sampled_from(["hall", "clutter"]))
def test_paths_are_the_shortest(seed, kind):
    """With fine bends, on floors small enough for the oracle."""
    plan = hall(9, 3.0, seed) if kind == "hall" else cluttered(9, 8.0, seed)
    places = free_places(plan, 6, seed)
    world = CollisionWorld(plan)
    world.place("person", Disc(places.pop(), 0.3))
    planner = PathPlanner(world, RADIUS, step=math.radians(3))
    lengths = shortest(room(world, RADIUS), np.array(places))
    for (i, start), (j, goal) in itertools.combinations(enumerate(places), 2):
        try:
            path = planner.plan(start, goal)
        except PlanningError as why:
            # The oracle accepts gaps that are too narrow by up to 0.5 % of the radius.
            assert why.reason in ("unreachable", "start_blocked", "goal_blocked")
            continue
        assert gap(world, path.points) >= RADIUS - 1e-9
        assert path.length == pytest.approx(length(path.points), rel=1e-12)
        # The oracle cuts its corners by 0.5 % of the radius.
        assert lengths[i, j] - 1e-9 <= path.length <= lengths[i, j] * 1.006 + 1e-3


@settings(max_examples=settings.default.max_examples // 12)
@given(st.integers(0, 2**32), st.sampled_from([*FLOORS]), st.sampled_from([0.2, 0.3, 0.45, 0.52]))
def test_triangles_prove_only_what_the_free_space_does(seed, kind, radius):
    plan = FLOORS[kind](seed)
    places = free_places(plan, 40, seed, radius + 0.01)
    world = CollisionWorld(plan)
    roadmap, space = PathPlanner(world, radius).roadmap(), world.free_space(radius + 1e-4)
    for one, other in itertools.combinations(places, 2):
        assert not (roadmap.apart(one, other) and space.together(one, other))


@pytest.mark.parametrize("widest", [0.59, 0.61])
def test_passages_separate_a_wall_with_a_gap_narrower_than_the_disc(widest):
    """The gap is between two corners, a corner and a wall, or rows of posts on a slope."""
    for shapes in (
        [box(5, 0, 5.2, 4), box(5, 4 + widest, 5.2, 10)],
        [box(5, 0, 5.2, 10 - widest)],
        [box(3, 0, 3.5, 4), box(3.5 + widest, 3.8, 8, 10), box(3, 3.8, 3.2, 4)],
        [
            shapely.affinity.rotate(shape, 0.5, (5, 5), use_radians=True)
            for shape in (box(5, -5, 5.2, 5), box(5, 5 + widest, 5.2, 15))
        ],
    ):
        plan = floor(*shapes, boundary=box(0, 0, 10, 10))
        roadmap = PathPlanner(CollisionWorld(plan), RADIUS).roadmap()
        assert roadmap.apart((1, 5), (9, 5)) == (widest < 2 * RADIUS)
        assert not roadmap.apart((1, 5), (1, 9))


def test_paths_do_not_depend_on_earlier_queries():
    """Links are the same for any queries in any order."""
    plan = hall(64, 4.0, 5)
    places = free_places(plan, 6, 6)

    def ways(order):
        # Another thread has an empty cache.
        with ThreadPoolExecutor(1) as fresh:
            planner = fresh.submit(lambda: PathPlanner(CollisionWorld(plan), RADIUS)).result()
            asked = [(places[k], places[k - 1]) for k in order]
            found = list(fresh.map(lambda ends: planner.plan(*ends).points.tolist(), asked))
        return dict(zip(order, found, strict=True))

    assert ways(range(6)) == ways([5, 0, 3, 1, 4, 2])


def test_paths_among_hundreds_of_obstacles_and_people():
    plan = hall(400, 4.0, 7)
    world = CollisionWorld(plan)
    planner = PathPlanner(world, RADIUS)
    side = plan.boundary.bounds[2]
    places = free_places(plan, 20, 8)
    corner, far = (0.4, 0.4), (side - 0.4, side - 0.4)
    alone = planner.plan(corner, far)
    assert gap(world, alone.points) >= RADIUS - 1e-9
    assert math.dist(corner, far) < alone.length < 1.01 * math.dist(corner, far)
    for k, at in enumerate([alone.points[5], alone.points[9], *places]):
        world.place(f"person{k}", Disc(tuple(at), 0.3))
    among = planner.plan(corner, far)
    assert gap(world, among.points) >= RADIUS - 1e-9
    assert alone.length < among.length < 1.01 * alone.length
    world.place("wall", box(0, 8.0, 8.0, 8.1))
    world.place("other wall", box(8.0, 0.0, 8.1, 8.1))
    with pytest.raises(PlanningError) as shut_in:
        planner.plan(corner, far)
    assert shut_in.value.reason == "unreachable"


@pytest.mark.slow
def test_a_path_among_ten_thousand_obstacles():
    plan = hall(10_000, 10.0, 9)
    world = CollisionWorld(plan)
    side = plan.boundary.bounds[2]
    start, goal = (0.4, 0.4), (side - 0.4, side - 0.4)
    path = PathPlanner(world, RADIUS).plan(start, goal)
    assert path.clearance >= RADIUS - 1e-9
    assert math.dist(start, goal) < path.length < 1.01 * math.dist(start, goal)
