"""Approaches computed by hand: time spans in which a machine's own motion reduces the distance."""

import math

import numpy as np
import pytest

import navigation
from navigation import Box, Cylinder, FixedDistance, Shapes
from navigation.motion import Motion, Piece, standing
from sim.safety.approaches import approaches
from sim.safety.margins import Encountered

STILL = (0.0, 0.0, 0.0, 0.0)
LAW = FixedDistance(4.0)
ROUND = Shapes(person=Cylinder(radius=0.3, top=1.0), machine=(Cylinder(radius=0.5, top=1.0),))
LONG = Shapes(
    person=Cylinder(radius=0.3, top=1.0),
    machine=(Box(length=2.0, width=0.6, bottom=0.0, top=1.0),),
)


def motion(*pieces):
    """Return a motion of pieces: seconds, and the cubics of x, y and the rotation."""
    segments, t = [], 0.0
    for seconds, *cubics in pieces:
        x, y, rotation = [*cubics, *[STILL] * (3 - len(cubics))]
        segments.append(Piece(t, t + seconds, x, y, rotation))
        t += seconds
    return Motion(tuple(segments))


def approaches_of(machine, spans, *, person=(0.0, 0.0), shapes=None, law=LAW):
    """Return the approaches of a machine to a person during violations."""
    walk = person if isinstance(person, Motion) else standing(person)
    return [*approaches(Encountered("ann", "cart", law, walk, machine, shapes, spans, []), spans)]


def at(x, y=0.0, rotation=0.0):
    """Return a piece in which a machine rests for two seconds."""
    return (2.0, (x, 0.0, 0.0, 0.0), (y, 0.0, 0.0, 0.0), (rotation, 0.0, 0.0, 0.0))


BOTH = pytest.mark.parametrize("shapes", [None, ROUND])


@BOTH
def test_an_approach_lasts_as_long_as_the_machine_drives_at_the_person(shapes):
    # The machine rests at 3 m, drives to 1 m from rest to rest, and drives off.
    there = (4.0, (3.0, 0.0, -2 * 3 / 16, 2 * 2 / 64))
    away = (4.0, (1.0, 0.0, 2 * 3 / 16, -2 * 2 / 64))
    machine = motion(at(3.0), there, away)
    (one,) = approaches_of(machine, [(0.0, 10.0)], shapes=shapes)
    assert (one.person, one.machine) == ("ann", "cart")
    if shapes is None:
        assert (one.begin, one.end) == pytest.approx((2.0, 6.0), abs=1e-6)
    else:  # between surfaces, the first and last micrometres are no approach
        assert (one.begin, one.end) == pytest.approx((2.0, 6.0), abs=1e-4)
    assert one.margin == pytest.approx(1.0 - 4.0 - (0.8 if shapes else 0.0), abs=1e-6)
    assert one.time == pytest.approx(6.0, abs=1e-2)


@BOTH
def test_an_approach_may_begin_and_end_within_a_piece(shapes):
    # x' = -1 + (u - 2)² within one piece of 5 s: the distance decreases from 1 to 3 s.
    piece = (5.0, (2.5, 3.0, -2.0, 1 / 3))
    machine = motion(at(2.5), piece)
    spans = [(0.0, 7.0)]
    (one,) = approaches_of(machine, spans, shapes=shapes)
    assert (one.begin, one.end) == pytest.approx((3.0, 5.0), abs=2e-5)
    x = 2.5 + 3.0 * 3 - 2.0 * 9 + 9.0
    assert one.margin == pytest.approx(x - 4.0 - (0.8 if shapes else 0.0), abs=1e-4)


@BOTH
def test_a_machine_that_passes_approaches_until_it_is_beside_the_person(shapes):
    passing = (6.0, (-3.0, 1.0, 0.0, 0.0), (1.5, 0.0, 0.0, 0.0))
    machine = motion(at(-3.0, 1.5), passing)
    (one,) = approaches_of(machine, [(0.0, 8.0)], shapes=shapes)
    assert (one.begin, one.end) == pytest.approx((2.0, 5.0), abs=3e-5)
    assert one.margin == pytest.approx(1.5 - 4.0 - (0.8 if shapes else 0.0), abs=1e-6)
    person = standing((2.0, 0.2))
    (one,) = approaches_of(machine, [(0.0, 8.0)], person=person, shapes=shapes)
    assert one.end == pytest.approx(7.0, abs=1e-4)


@BOTH
def test_closing_that_lasts_since_the_begin_of_the_violation_is_no_approach(shapes):
    there = (4.0, (3.0, -0.25, 0.0, 0.0))
    machine = motion(at(3.0), there, at(2.0), (1.0, (2.0, -0.4, 0.0, 0.0)))
    spans = [(2.0, 9.0)]
    (one,) = approaches_of(machine, spans, shapes=shapes)
    assert (one.begin, one.end) == pytest.approx((8.0, 9.0), abs=1e-4)
    assert [a.begin for a in approaches_of(machine, [(1.9, 9.0)], shapes=shapes)] == pytest.approx(
        [2.0, 8.0], abs=1e-4
    )
    assert approaches_of(machine, [(3.0, 5.5)], shapes=shapes) == []
    assert approaches_of(machine, [(6.5, 7.5)], shapes=shapes) == []


@BOTH
def test_each_violation_has_its_own_approaches(shapes):
    there = (2.0, (3.0, -0.5, 0.0, 0.0))
    back = (2.0, (2.0, 0.5, 0.0, 0.0))
    machine = motion(at(3.0), there, back, at(3.0), there, back)
    both = approaches_of(machine, [(1.0, 5.0), (7.0, 12.0)], shapes=shapes)
    assert [(a.begin, a.end) for a in both] == [
        pytest.approx((2.0, 4.0), abs=1e-4),
        pytest.approx((8.0, 10.0), abs=1e-4),
    ]


@pytest.mark.parametrize(
    ("metres", "count"), [(0.0005, 0), (0.0009, 0), (0.0011, 1), (0.002, 1), (0.02, 1)]
)
@pytest.mark.parametrize("seconds", [0.004, 0.5, 4.0])
@BOTH
def test_a_machine_that_comes_less_than_a_millimetre_nearer_does_not_approach(
    metres, count, seconds, shapes
):
    there = (seconds, (3.0, -metres / seconds, 0.0, 0.0))
    machine = motion(at(3.0), there, at(3.0 - metres))
    assert len(approaches_of(machine, [(0.0, seconds + 3.0)], shapes=shapes)) == count


@BOTH
def test_a_machine_that_a_person_walks_up_to_does_not_approach(shapes):
    walk = Motion.from_samples([0.0, 2.0, 8.0], [(0.0, 0.0), (0.0, 0.0), (2.0, 0.0)])
    machine = motion(at(3.0), (6.0, (3.0, 0.0, 0.0, 0.0)))
    assert approaches_of(machine, [(0.0, 8.0)], person=walk, shapes=shapes) == []
    leaves = motion(at(3.0), (6.0, (3.0, 0.5, 0.0, 0.0)))
    assert approaches_of(leaves, [(0.0, 8.0)], person=walk, shapes=shapes) == []
    after = motion(at(3.0), (6.0, (3.0, -0.1, 0.0, 0.0)))
    fleeing = Motion.from_samples([0.0, 2.0, 8.0], [(0.0, 0.0), (0.0, 0.0), (-3.0, 0.0)])
    (one,) = approaches_of(after, [(0.0, 8.0)], person=fleeing, shapes=shapes)
    assert (one.begin, one.end) == pytest.approx((2.0, 8.0), abs=1e-4)


@BOTH
def test_consecutive_approaches_are_merged(shapes):
    first = (1.0, (3.0, -0.5, 0.0, 0.0))
    second = (1.0, (2.5, -0.2, -0.1, 0.0))
    machine = motion(at(3.0), first, second, at(2.2))
    (one,) = approaches_of(machine, [(0.0, 6.0)], shapes=shapes)
    assert (one.begin, one.end) == pytest.approx((2.0, 4.0), abs=1e-4)


def test_a_turn_on_the_spot_approaches_between_surfaces_only():
    # The long side turns towards the person, so its near end approaches.
    turn = (2.0, (1.6, 0.0, 0.0, 0.0), STILL, (math.pi / 2, 0.0, -3 * math.pi / 8, math.pi / 8))
    machine = motion(at(1.6, rotation=math.pi / 2), turn)
    assert approaches_of(machine, [(0.0, 4.0)]) == []
    (one,) = approaches_of(machine, [(0.0, 4.0)], shapes=LONG)
    assert one.begin == pytest.approx(2.0, abs=0.02)
    assert one.margin == pytest.approx(
        float(LONG.distances(np.zeros((1, 2)), np.array([machine.cubics(one.time)[:, 0]]))[0])
        - 4.0,
        abs=0.02,
    )


@pytest.mark.parametrize("seed", range(8))
def test_approaches_between_surfaces_equal_dense_samples(seed):
    rng = np.random.default_rng(seed)
    twist = rng.uniform([-0.8, -0.8], [0.8, 0.8])
    drive = navigation.vehicle_twist(
        (rng.uniform(1.0, 2.5), rng.uniform(-1, 1), rng.uniform(-3, 3)), twist, 1.0, seconds=3.0
    )
    spans = [(0.0, drive.end + 1.0)]
    t = np.arange(0.0005, spans[0][1], 1e-3)
    poses = drive.cubics(t)
    ahead = np.concatenate([poses[..., :1] + 1e-6 * poses[..., 1:2]], axis=2)[..., 0]
    here = poses[..., 0]
    places = np.zeros((len(t), 2))
    rate = (LONG.distances(places, here) - LONG.distances(places, ahead)) / 1e-6
    mine = sum(a.end - a.begin for a in approaches_of(drive, spans, shapes=LONG))
    assert mine == pytest.approx(1e-3 * float((rate > 1e-5).sum()), abs=0.02)
