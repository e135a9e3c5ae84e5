"""Walks among others: the kernels take those that a plain look at each takes, in the same order."""

import math
import random
from collections.abc import Iterator, MutableSequence

import shapely

from navigation.freespace import Walls
from navigation.kernels.candidates import Candidates
from navigation.kernels.discs import first_met
from navigation.kernels.edges import legs_of, touches
from navigation.kernels.movers import Movers
from navigation.kernels.numbers import numbers
from navigation.kernels.retreats import Retreats
from navigation.kernels.throng import Throng
from navigation.walking import Swath

GAP = 0.006
START, TOP, FASTEST, ACCELERATION = 7.0, 0.9, 1.2, 2.5
WALLS = Walls(shapely.box(-2.5, -2.5, 2.5, 2.5), 0.3)

Place = tuple[float, float]
Numbers = MutableSequence[float]
Crowd = tuple[list[Numbers], Numbers, Numbers]


def drawn(corners: list[Place]) -> Swath | None:
    limits = {"top_speed": TOP, "max_speed": FASTEST, "max_acceleration": ACCELERATION}
    return Swath.along(corners, START, **limits)


def somewhere(rng: random.Random) -> Place:
    return (rng.uniform(-2.2, 2.2), rng.uniform(-2.2, 2.2))


def crowd(rng: random.Random, count: int) -> Crowd:
    """Return some who walk about: tables, bounds and radii."""
    walks = [drawn([somewhere(rng) for _ in range(3)]) for _ in range(count)]
    found = [walk for walk in walks if walk is not None]
    boxes = numbers(bound for walk in found for bound in walk.box)
    return [walk.table for walk in found], boxes, numbers(rng.uniform(0.2, 0.4) for _ in found)


def moved(moving: Crowd, floor: Crowd) -> tuple[Movers, int]:
    """Return those moving among those on the floor, and the index of one of 0.3 m with them."""
    throng = Throng(GAP)
    for tables, boxes, radii in (
        floor,
        moving,
        ([numbers(())], numbers([0.0] * 4), numbers([0.3])),
    ):
        for k, (table, radius) in enumerate(zip(tables, radii, strict=True)):
            throng.add(table, boxes[4 * k : 4 * k + 4], radius)
    movers = Movers(throng, START)
    for k, table in enumerate(moving[0]):
        movers.add(len(floor[2]) + k, table, moving[1][4 * k : 4 * k + 4])
    return movers, len(floor[2]) + len(moving[2])


def met(walk: Swath, others: Crowd, but: bytearray, own: float) -> int:
    near = [k for k in range(len(others[2])) if not but[k]]
    return first_met(walk.table, walk.box, near, *others, own, START, numbers([math.inf]))


def plainly(
    path: list[Place],
    places: list[Place],
    legs: Numbers,
    moving: Crowd,
    floor: Crowd,
    refusing: bytearray,
) -> Iterator[tuple[int, int, Numbers]]:
    x, y = path[-1]
    for k, (dx, dy) in enumerate(places):
        to = (x + dx, y + dy)
        walk = drawn([*path, to])
        if (
            walk is not None
            and not touches(legs, *to, *to, 0.6)
            and met(walk, moving, bytearray(len(moving[2])), 0.3 + GAP) < 0
            and WALLS.clear((x, y), to)
        ):
            hit = met(walk, floor, bytearray(len(floor[2])), 0.3 + GAP)
            if hit < 0 or not refusing[hit]:
                yield k, hit, walk.table


def test_the_steps_taken_are_those_of_a_plain_look() -> None:
    taken = 0
    for seed in range(150):
        rng = random.Random(seed)
        moving, floor = crowd(rng, rng.randrange(4)), crowd(rng, 5)
        movers, me = moved(moving, floor)
        refusing = bytearray(rng.random() < 0.5 for _ in floor[2])
        course = [somewhere(rng), somewhere(rng)]
        legs = legs_of(course)
        path = [somewhere(rng) for _ in range(rng.choice((1, 1, 2)))]
        places = [(rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5)) for _ in range(40)]
        walks = Retreats(movers, me, course, 0.6, TOP, FASTEST, ACCELERATION, WALLS.grid, 0.3)
        walks.look(path, numbers(c for place in places for c in place))
        found = []
        while (k := walks.next(1000, None, refusing)) >= 0:
            found.append((k, walks.hit, walks.table))
        assert found == [*plainly(path, places, legs, moving, floor, refusing)], seed
        taken += len(found)
    assert taken > 200


def test_the_next_free_walk_is_that_of_a_plain_look() -> None:
    taken = 0
    for seed in range(150):
        rng = random.Random(seed)
        others = crowd(rng, 6)
        course = [somewhere(rng) for _ in range(3)]
        walks = Candidates(
            *(course, START, START, 0.0, 0.0, 0.0, FASTEST, ACCELERATION),
            *(numbers(()), numbers(())),
        )
        asked = [(rng.uniform(0.3, 6.0), rng.uniform(0.3, TOP), rng.choice((0.0, 1.0)))
                 for _ in range(30)]  # fmt: skip
        plain = []
        for length, top_speed, delay in asked:
            if walks.draw_along(length, top_speed, delay):
                walk = Swath.of(walks.table, walks.box)
                if met(walk, others, bytearray(len(others[2])), 0.3 + GAP) < 0:
                    plain.append(walk.table)
        for loss, one in enumerate(asked):
            walks.add(loss, *one)
        found, throng = [], moved(([], [], []), others)[0].throng
        while walks.next_free([*range(len(others[2]))], throng, 0.3 + GAP):
            found.append(walks.table)
        assert found == plain, seed
        taken += len(found)
    assert taken > 200
