"""The nearest place to stand: there is room there, and nothing nearer."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import floorplan
from navigation import CollisionWorld

PLAN = floorplan.load("ariac2023")
WORLD = CollisionWorld(PLAN)


@pytest.mark.parametrize("point", [(-2.5, 0.5), (-2.66, 3.0), (-0.6, -4.72)])
def test_no_cracks_between_grown_edges_and_corners(point):
    """A crack beside a corner of a bin once was taken for a place to stand."""
    place = WORLD.nearest_free(point, 0.3)
    assert WORLD.free(place, 0.3 - 1e-6)


@given(st.floats(-22, 2), st.floats(-12, 12))
def test_the_nearest_free_place_is_free_and_near(x, y):
    place = WORLD.nearest_free((x, y), 0.3)
    assert WORLD.free(place, 0.3 - 1e-6)
    away = math.dist((x, y), place)
    for k in range(36):
        angle = 2 * math.pi * k / 36
        inner = 0.98 * away
        nearer = (x + inner * math.cos(angle), y + inner * math.sin(angle))
        assert away < 1e-9 or not WORLD.free(nearer, 0.301)
