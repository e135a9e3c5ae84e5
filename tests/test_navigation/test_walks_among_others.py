"""Walks among others, and safe durations of motions, against plain evaluations without tables."""

import itertools
import math
import random
from collections.abc import Iterator, MutableSequence
from contextlib import suppress

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, strategies as st

import floorplan
import navigation
from navigation.freespace import walls as walls_of
from navigation.kernels.candidates import Candidates, Course, Departure
from navigation.kernels.committed import CommittedMotions, Movers
from navigation.kernels.discs import DiscMotions, Swath
from navigation.kernels.edges import Legs, legs_of, touches
from navigation.kernels.lookout import most_remote
from navigation.kernels.numbers import numbers
from navigation.kernels.retreats import Retreats
from navigation.machines import agv_stops, gantry_stops
from navigation.monitor import StoppingHorizon
from navigation.separation import is_of_speeds, required_at_speeds
from navigation.walking import first_conflict, motion_along, swath as swath_of, swath_along

GAP = 0.006
START, TOP, FASTEST, ACCELERATION = 7.0, 0.9, 1.2, 2.5
WALLS = walls_of(shapely.box(-2.5, -2.5, 2.5, 2.5))
LEGS = Legs(WALLS, 0.3, lambda a, b: True)

Place = tuple[float, float]
Numbers = MutableSequence[float]
Crowd = list[tuple[Swath, float]]
"""Swaths and radii."""


def drawn(corners: list[Place]) -> Swath | None:
    limits = {"top_speed": TOP, "max_speed": FASTEST, "max_acceleration": ACCELERATION}
    return swath_along(corners, START, **limits)


def somewhere(rng: random.Random) -> Place:
    return (rng.uniform(-2.2, 2.2), rng.uniform(-2.2, 2.2))


def crowd(rng: random.Random, count: int) -> Crowd:
    """Return the swaths of `count` walking people."""
    walks = [drawn([somewhere(rng) for _ in range(3)]) for _ in range(count)]
    return [(walk, rng.uniform(0.2, 0.4)) for walk in walks if walk is not None]


def moved(moving: Crowd, floor: Crowd) -> tuple[Movers, int]:
    """Return drafts of motions on the floor, and the index of another disc of 0.3 m there."""
    motions = CommittedMotions(GAP)
    me = Swath(numbers(()), numbers([0.0] * 4)), 0.3
    for swath, radius in (*floor, *moving, me):
        motions.add(swath, radius)
    movers = Movers(motions, START)
    for k, (swath, _) in enumerate(moving, len(floor)):
        movers.move(k, swath)
    return movers, len(floor) + len(moving)


def met(walk: Swath, others: Crowd, own: float) -> int:
    motions = DiscMotions(GAP)
    for one in others:
        motions.add(*one)
    return motions.first_met([*range(len(others))], walk, own, START)[0]


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
            and met(walk, moving, 0.3 + GAP) < 0
            and not WALLS.touched(x, y, *to, 0.3)
        ):
            hit = met(walk, floor, 0.3 + GAP)
            if hit < 0 or not refusing[hit]:
                yield k, hit, walk.table


def test_retreats_are_those_of_a_plain_search() -> None:
    taken = 0
    for seed in range(150):
        rng = random.Random(seed)
        moving, floor = crowd(rng, rng.randrange(4)), crowd(rng, 5)
        movers, me = moved(moving, floor)
        refusing = bytearray(rng.random() < 0.5 for _ in floor)
        course = [somewhere(rng), somewhere(rng)]
        legs = legs_of(course)
        path = [somewhere(rng) for _ in range(rng.choice((1, 1, 2)))]
        places = [(rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5)) for _ in range(40)]
        around = numbers(c for place in places for c in place)
        walks = Retreats(movers, me, path[0], around, 0.6, LEGS, TOP, FASTEST, ACCELERATION, 1000)
        walks.leave(legs)
        walks.look(path, around)
        found = []
        while (walk := walks.next(1000, refusing)) is not None:
            found.append((walks.index, walks.hit, walk.table))
        assert found == [*plainly(path, places, legs, moving, floor, refusing)], seed
        taken += len(found)
    assert taken > 200


def test_the_next_free_walk_is_that_of_a_plain_search() -> None:
    taken = 0
    for seed in range(150):
        rng = random.Random(seed)
        others = crowd(rng, 6)
        course = [somewhere(rng) for _ in range(3)]
        state = Departure(START, START, 0.0, (0.0, 0.0), FASTEST, ACCELERATION)
        walks = Candidates(Course(course), state)
        asked = [(rng.uniform(0.3, 6.0), rng.uniform(0.3, TOP), rng.choice((0.0, 1.0)))
                 for _ in range(30)]  # fmt: skip
        plain = []
        for length, top_speed, delay in asked:
            walk = walks.draw_along(length, top_speed, delay)
            if walk is not None and met(walk, others, 0.3 + GAP) < 0:
                plain.append(walk.table)
        for loss, one in enumerate(asked):
            walks.add(loss, *one)
        found, motions = [], moved([], others)[0].floor
        near = [*range(len(others))]
        while (walk := walks.next_free(near, motions, 0.3 + GAP)) is not None:
            found.append(walk.table)
        assert found == plain, seed
        taken += len(found)
    assert taken > 200


def places(rng: random.Random, count: int) -> list[tuple[float, float]]:
    return [(rng.uniform(0, 6), rng.uniform(0, 6)) for _ in range(count)]


def walks(rng: random.Random) -> navigation.Motion:
    while True:
        with suppress(ValueError):  # too short to slow down
            return navigation.walk(
                places(rng, rng.randint(2, 6)),
                rng.uniform(0, 3),
                initial_speed=rng.choice([0.0, 0.3, 0.9]),
                top_speed=rng.choice([1.0, 0.5, 0.25]),
                max_speed=1.0,
                max_acceleration=2.5,
            )


def test_conflicts_are_those_of_the_monitor():
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
        else:  # differences of rounding
            assert navigation.minimum_separation(one, other, 3.0, end)[1] < least + 1e-3


def test_a_person_at_the_minimum_distance_can_walk_away():
    """In any direction away from the other at once, but not towards it."""
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


def test_walks_keep_their_limits_and_equal_their_swaths():
    rng = random.Random(5)
    for _ in range(200):
        walk = walks(rng)
        t = np.linspace(walk.start, walk.end, 200)
        assert np.hypot(*walk.velocity(t).T).max() <= 1.0 + 1e-9
        assert all(abs(a) <= 2.5 + 1e-9 for s in t for a in walk.state(s).acceleration[:2])
        swath = swath_of(walk, walk.start)
        assert motion_along(swath, 0.0).position(t) == pytest.approx(walk.position(t))
        assert (walk.position(t) >= np.array(swath.box[:2]) - 1e-9).all()
        assert (walk.position(t) <= np.array(swath.box[2:]) + 1e-9).all()


def test_walls_are_those_of_the_world():
    rng = random.Random(6)
    world = navigation.CollisionWorld(floorplan.load("ariac2023"))
    walls, (low_x, low_y, high_x, high_y) = world.walls, world.plan.boundary.bounds
    for _ in range(2000):
        a = (rng.uniform(low_x, high_x), rng.uniform(low_y, high_y))
        away = rng.choice([0.3, 1.0, 3.0, 8.0])
        b = (a[0] + rng.uniform(-away, away), a[1] + rng.uniform(-away, away))
        if world.segment_free(a, a, 0.3, among=()):
            assert walls.touched(*a, *b, 0.3) != world.segment_free(a, b, 0.3, among=())


LAWS = (
    navigation.SeparationLaw(t1=0.5, t2=1.0, intrusion=0.3),
    navigation.FixedDistance(1.0),
    navigation.IntegralLaw(t1=0.5, t2=1.0),
)
FULL_SPEED = math.sqrt(2.0)
LANE = floorplan.load("ariac2023").lane("agv1")
MARGIN = 0.01
BEGUN, LEAST = 3.0, 0.2

near = st.tuples(st.floats(-10, -5), st.floats(0, 6), st.floats(-3, 3))


def lack(motion, begin, end, person, law):
    """Return the maximum missing distance at many times."""
    x, y, speed = person
    worst = -math.inf
    for t in np.linspace(begin, end, 60).tolist():
        state = motion.state(t)
        pace = state.speed if is_of_speeds(law) else FULL_SPEED
        asked = required_at_speeds(law, speed, pace) + MARGIN + speed * (t - BEGUN)
        worst = max(worst, asked - math.dist(state.at, (x, y)))
    return worst


@given(
    st.booleans(),
    st.tuples(near, near),
    st.lists(st.tuples(st.floats(-14, -1), st.floats(-4, 10), st.floats(0.3, 2)), max_size=3),
    st.sampled_from(LAWS),
)
def test_the_safe_duration_of_a_motion_is_exact(gantry, ends, people, law):
    if gantry:
        motion = navigation.gantry_move(*ends, 2.0)
        stops = gantry_stops()
        stop_from = navigation.gantry_stop
    else:
        q = [abs(end[0] + 5) for end in ends]
        motion = navigation.agv_run(LANE, q[0], q[1], 2.0)
        stops = agv_stops(LANE)

        def stop_from(state, t):
            return navigation.agv_stop(LANE, state, t)

    assume(motion.end > BEGUN)
    rows = []
    for x, y, speed in people:
        known = is_of_speeds(law)
        fixed = -1.0 if known else required_at_speeds(law, speed, FULL_SPEED) + MARGIN
        rows += (x, y, speed, fixed)
    lookout = StoppingHorizon(law, MARGIN)
    until, who = lookout.safe_until(motion.table, stops, rows, BEGUN, LEAST)
    looks = [BEGUN]
    while looks[-1] < motion.end:
        looks.append(min(BEGUN + LEAST * 2 ** (len(looks) - 1), motion.end))
    assert until in looks
    if until == BEGUN and who < 0:
        return

    def worst(begin, end, person):
        stop = stop_from(motion.state(end), end)
        return max(lack(motion, begin, end, person, law), lack(stop, end, stop.end, person, law))

    for begin, end in itertools.pairwise(looks):
        if end <= until:
            assert all(worst(begin, end, person) < 1e-6 for person in people)
        elif begin == until:
            # Samples cannot show a missing distance between them.
            assert worst(begin, end, people[who]) > -0.05


@given(
    st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=1, max_size=6),
    st.lists(st.tuples(*[st.floats(-9, 9)] * 2, *[st.floats(-2, 2)] * 2), max_size=3),
)
def test_the_most_remote_place_is_that_of_a_plain_search(places, people):
    glances, horizon, top, lag, enough = [0.0, 1.0, 2.0], 1.5, 1.0, 0.5, 4.0

    def nearest(place):
        length = math.dist(places[0], place)
        found = math.inf
        for t, (x, y, vx, vy) in itertools.product(glances, people):
            share = min(1.0, top * max(0.0, t - lag) / length) if length else 0.0
            at = [a + share * (b - a) for a, b in zip(places[0], place, strict=True)]
            after = min(t, horizon)
            found = min(found, math.dist(at, (x + vx * after, y + vy * after)))
        return found

    rows = [c for person in people for c in person]
    flat = [c for place in places for c in place]
    k = most_remote(flat, rows, glances, horizon, top, lag, enough)
    stays = nearest(places[0])
    assert k == 0 or stays < enough + 1e-9
    if stays < enough - 1e-9:
        assert nearest(places[k]) > max(map(nearest, places)) - 1e-9
