"""Paths of vehicles with a footprint: free by an oracle of its own, and why there is none."""

import itertools
import math

import numpy as np
import pytest
import shapely
from shapely import affinity
from shapely.geometry import box

import floorplan
from navigation import (
    CollisionWorld,
    Disc,
    PathPlanner,
    PlanningError,
    VehicleLimits,
    VehiclePlanner,
    vehicle_path,
)

LONG = box(-1.2, -0.4, 1.2, 0.4)
WEDGE = shapely.Polygon([(0.9, 0.1), (0.4, 0.45), (-0.6, 0.45), (-0.6, -0.45), (0.4, -0.45)])
UP = math.pi / 2


@pytest.fixture(scope="module")
def world():
    return CollisionWorld(floorplan.load("warehouse"), top=1.5)


def covers(world, footprint, path, limits):
    """Return the greatest area outside of the free floor that the motion along a path covers."""
    free = world.walkable
    motion = vehicle_path(path.poses[0], path.poses[1:], limits=limits)
    t = np.arange(0.0, motion.end, 0.05)
    places, turns = motion.position(t), motion.rotation(t)
    stands = [
        affinity.translate(affinity.rotate(footprint, turn, origin=(0, 0), use_radians=True), *at)
        for at, turn in zip(places, turns, strict=True)
    ]
    return float(shapely.area(shapely.difference(stands, free)).max())


def random_poses(planner, count, seed):
    """Return poses on the warehouse's floor that the vehicle fits."""
    random = np.random.default_rng(seed)
    poses = random.uniform([0.0, 0.0, -math.pi], [30.0, 20.0, math.pi], size=(20 * count, 3))
    return [*itertools.islice(filter(planner.fits, poses.tolist()), count)]


@pytest.mark.parametrize(
    ("footprint", "limits"),
    [(LONG, VehicleLimits()), (WEDGE, VehicleLimits()), (LONG, VehicleLimits(side_speed=1.0))],
)
def test_paths_touch_nothing_and_begin_and_end_where_asked(world, footprint, limits):
    planner = VehiclePlanner(world, footprint, limits=limits)
    poses = random_poses(planner, 12, 1)
    for start, goal in itertools.pairwise(poses):
        path = planner.plan(start, goal)
        assert path.poses[0].tolist() == start
        assert path.poses[-1][:2] == pytest.approx(goal[:2])
        assert math.remainder(path.poses[-1][2] - goal[2], math.tau) == pytest.approx(0, abs=1e-9)
        assert covers(world, footprint, path, limits) < 1e-9
        assert path.length >= math.dist(start[:2], goal[:2]) - 1e-9


def test_aisles_that_the_disc_around_it_does_not_pass(world):
    planner = VehiclePlanner(world, LONG)
    with pytest.raises(PlanningError):
        PathPlanner(world, math.hypot(1.2, 0.4)).plan((8.5, 2.0), (8.5, 10.0))
    for start, goal in itertools.permutations([8.5, 12.5, 16.5, 20.5, 24.5], 2):
        path = planner.plan((start, 9.0, UP), (goal, 12.0))
        assert covers(world, LONG, path, VehicleLimits()) < 1e-9
        # Out of one aisle and into the other, without a detour around the racks.
        assert path.length < abs(goal - start) + 22.0


def test_the_same_question_has_the_same_answer(world):
    one, other = (VehiclePlanner(world, LONG) for _ in range(2))
    poses = random_poses(one, 6, 4)
    asked = [*itertools.pairwise(poses)]
    first = [one.plan(*ends).poses.tolist() for ends in asked]
    assert [other.plan(*ends).poses.tolist() for ends in asked[::-1]] == first[::-1]


def test_a_search_in_se2_where_it_never_turns_right_round():
    """In the bend of a corridor it has room for a quarter turn alone, beside a post."""
    plan = floorplan.Floorplan(
        name="bend",
        boundary=shapely.Polygon([(0, 0), (8, 0), (8, 1.6), (1.6, 1.6), (1.6, 8), (0, 8)]),
    )
    world = CollisionWorld(plan)
    world.place("post", Disc((0.4, 0.4), 0.1))
    footprint = box(-0.8, -0.3, 0.8, 0.3)
    assert world.nearest_free((1.0, 1.0), math.hypot(0.8, 0.3)) is None
    path = VehiclePlanner(world, footprint).plan((6.5, 0.8, math.pi), (0.8, 6.5, UP))
    assert covers(world, footprint, path, VehicleLimits()) < 1e-9


def test_bodies_count_where_they_are_now(world):
    busy = world.as_if({"pallet": Disc((8.5, 6.0), 0.3)})
    path = VehiclePlanner(busy, LONG).plan((8.5, 2.0, UP), (8.5, 10.0))
    assert path.length > 20.0  # round the rack, and in from the other end
    assert VehiclePlanner(world, LONG).plan((8.5, 2.0, UP), (8.5, 10.0)).length < 9.0


@pytest.mark.parametrize(
    ("start", "goal", "reason", "message"),
    [
        ((8.0, 5.0, 0.0), (3.0, 3.0), "start_blocked", "touches rack1 at the start"),
        ((3.0, 5.0, 0.0), (8.5, 10.0, 0.0), "goal_blocked", "touches rack1, rack2 at the goal"),
        ((3.0, 5.0, 0.0), (29.9, 10.0), "goal_blocked", "touches the boundary at the goal"),
    ],
)
def test_the_reason_why_there_is_no_path(world, start, goal, reason, message):
    with pytest.raises(PlanningError, match=message) as why:
        VehiclePlanner(world, LONG).plan(start, goal)
    assert why.value.reason == reason


def test_no_path_at_all_is_proved(world):
    walled = world.as_if({"wall": box(4.4, 0.0, 4.6, 20.0)})
    with pytest.raises(PlanningError, match=r"not even a disc of 0\.4 m") as why:
        VehiclePlanner(walled, LONG).plan((2.0, 5.0, UP), (28.0, 10.0))
    assert why.value.reason == "unreachable"


def test_footprints_that_can_not_be(world):
    for footprint, message in (
        (box(1.0, 1.0, 2.0, 2.0), "must contain"),
        (shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), "simple polygon"),
    ):
        with pytest.raises(ValueError, match=message):
            VehiclePlanner(world, footprint)
