"""Motions of points that a body carries, against rotated offsets."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import navigation
from navigation.carried import carried

coordinate = st.floats(-5, 5)
poses = st.tuples(coordinate, coordinate, st.floats(-3, 3))
offsets = st.tuples(st.floats(-2, 2), st.floats(-2, 2))
moves = st.builds(navigation.gantry_move, poses, poses, st.floats(0, 3))
twists = st.builds(
    lambda pose, v, w: navigation.vehicle_twist(
        pose, (v, w), 1.0, seconds=4.0, limits=navigation.VehicleLimits()
    ),
    poses,
    st.floats(-1, 1),
    st.floats(-1, 1),
)


@given(moves | twists, offsets)
def test_a_carried_point_follows_the_rotated_offset(motion, offset):
    point = carried(motion, *offset)
    t = np.linspace(motion.start - 1.0, motion.end + 1.0, 400)
    turns = np.exp(1j * motion.rotation(t)) * complex(*offset)
    expected = motion.position(t) + np.column_stack([turns.real, turns.imag])
    assert point.position(t) == pytest.approx(expected, abs=1.1e-4)
    assert point.rotation(t) == pytest.approx(motion.rotation(t), abs=1e-9)
    assert (point.start, point.end) == (motion.start, motion.end)


def test_points_of_a_body_without_rotation_have_the_same_cubics():
    drive = navigation.vehicle_segment((0.0, 0.0, 0.0), (4.0, 0.0))
    point = carried(drive, 0.5, -0.25)
    assert len(point.pieces) == len(drive.pieces)
    for mine, its in zip(point.pieces, drive.pieces, strict=True):
        assert mine.x[1:] == pytest.approx(its.x[1:], abs=1e-15)
    assert point.position(0.0) == pytest.approx(np.array([0.5, -0.25]))
    assert carried(drive, 0.0, 0.0) is drive
