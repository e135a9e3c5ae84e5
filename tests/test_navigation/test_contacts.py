"""First contacts and partings of outlines, against dense samples by shapely."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, strategies as st
from shapely import affinity

import navigation
from navigation.contacts import Outlines, bounds_from, shrunk

BOX = shapely.box(-0.6, -0.4, 0.6, 0.4)
WEDGE = shapely.Polygon([(0.8, 0.0), (-0.4, 0.5), (-0.4, -0.5)])
TEE = shapely.Polygon(
    [(-1, -0.2), (0, -0.2), (0, -0.8), (0.3, -0.8), (0.3, 0.8), (0, 0.8), (0, 0.2), (-1, 0.2)]
)
HALL = shapely.box(0, 0, 16, 12)
REST = navigation.standing((0.0, 0.0))
LIMITS = navigation.VehicleLimits(side_speed=1.0)
STEP = 0.01

outlines = st.sampled_from([BOX, WEDGE, TEE])
coordinates = st.floats(-2.5, 2.5)
poses = st.tuples(coordinates, coordinates, st.floats(-3, 3))
twists = st.builds(
    lambda pose, v, side, w: navigation.vehicle_twist(
        pose, (v, side, w), seconds=3.0, limits=LIMITS
    ),
    poses,
    st.floats(-1.4, 1.4),
    st.sampled_from([0.0, 0.5]),
    st.floats(-0.9, 0.9),
)


def covered(outline, motion, t):
    x, y, rotation = motion.state(t).position
    turned = affinity.rotate(outline, rotation, origin=(0, 0), use_radians=True)
    return affinity.translate(turned, x, y)


def gap(one, mine, other, theirs, t):
    return covered(one, mine, t).distance(covered(other, theirs, t))


@given(outlines, twists, outlines, twists | st.builds(navigation.standing, st.just((0.5, 0.5))))
def test_the_first_contact_is_that_of_dense_samples(one, mine, other, theirs):
    pair, end = Outlines(one, other), max(mine.end, theirs.end)
    apart = [gap(one, mine, other, theirs, t) for t in np.arange(0.0, end, STEP)]
    assert pair.overlap(mine, theirs, 0.0) == (apart[0] == 0.0)
    if apart[0] == 0.0:
        return
    t = pair.first_contact(mine, theirs, 0.0, end)
    if t is None:
        assert min(apart) > 0.0
        return
    assert gap(one, mine, other, theirs, t) == pytest.approx(0.0, abs=1e-8)
    assert min(apart[: math.ceil(t / STEP)]) > 0.0
    parted = pair.first_parting(mine, theirs, t, end, 1e-3)
    if parted is not None:
        assert gap(one, mine, other, theirs, parted) == pytest.approx(1e-3, abs=1e-4)
        since, until = math.ceil(t / STEP), math.ceil(parted / STEP)
        assert max(apart[since:until], default=0.0) < 1e-3


def test_a_machine_leaves_a_hall_with_its_first_corner():
    """Straight ahead, and on the spot beside the wall."""
    pair = Outlines(BOX, HALL, outside=True)
    drive = navigation.vehicle_segment((3.0, 6.0, 0.0), (20.0, 6.0))
    t = pair.first_contact(drive, REST, 0.0, drive.end)
    assert drive.state(t).at[0] == pytest.approx(15.4, abs=1e-8)
    turn = navigation.vehicle_turn((15.3, 6.0, math.pi / 2), math.pi)
    t = pair.first_contact(turn, REST, 0.0, turn.end)
    corner = math.atan2(0.6, 0.4)
    ahead = math.cos(turn.state(t).position[2] - math.pi / 2 - corner) * math.hypot(0.6, 0.4)
    assert ahead == pytest.approx(0.7, abs=1e-8)
    assert pair.overlap(navigation.standing((20.0, 6.0)), REST, 0.0)
    assert not pair.overlap(navigation.standing((8.0, 6.0)), REST, 0.0)


def test_a_machine_slides_along_a_wall_without_a_contact():
    """Without an overlap beyond the tolerance, at any acceleration."""
    pair = Outlines(shrunk(BOX, 1e-6), HALL, outside=True)
    for depth, touches in ((0.99e-6, False), (1.01e-6, True)):
        drive = navigation.vehicle_segment((3.0, 0.4 - depth, 0.0), (12.0, 0.4 - depth))
        assert (pair.first_contact(drive, REST, 0.0, drive.end) is not None) == touches


def test_a_body_inside_an_outline_overlaps_it():
    small = shapely.box(-0.1, -0.1, 0.1, 0.1)
    for one, other in ((BOX, small), (small, BOX)):
        assert Outlines(one, other).overlap(REST, REST, 0.0)
    assert not Outlines(TEE, small).overlap(REST, navigation.standing((-0.5, 0.5)), 0.0)


def test_the_bounds_of_a_motion_contain_its_remaining_part():
    motion = navigation.vehicle_twist((0.0, 0.0, 0.0), (1.0, 0.5), seconds=5.0)
    for begin in (0.0, 2.3, motion.end):
        places = motion.position(np.linspace(begin, motion.end, 200))
        x, y, most_x, most_y = bounds_from(motion, begin)
        assert (places >= np.array([x, y]) - 1e-9).all()
        assert (places <= np.array([most_x, most_y]) + 1e-9).all()
