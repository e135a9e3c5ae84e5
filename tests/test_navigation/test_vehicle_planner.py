"""Paths of vehicles with a footprint, against an oracle, and reasons of failures."""

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
HOOK = shapely.Polygon([(-1, -0.5), (2, -0.8), (0.5, 0), (2.5, 0.6), (-1, 0.5)])
UP = math.pi / 2


@pytest.fixture(scope="module")
def world():
    return CollisionWorld(floorplan.load("warehouse"), top=1.5)


def covers(world, footprint, path, limits):
    """Return the maximum area outside of the free floor that the motion along a path covers."""
    free = world.walkable
    motion = vehicle_path(path.poses[0], path.poses[1:], limits=limits)
    t = np.arange(0.0, motion.end, 0.05)
    places, turns = motion.position(t), motion.rotation(t)
    stands = [
        affinity.translate(affinity.rotate(footprint, turn, origin=(0, 0), use_radians=True), *at)
        for at, turn in zip(places, turns, strict=True)
    ]
    return float(shapely.area(shapely.difference(stands, free)).max())


@pytest.mark.parametrize("footprint", [LONG, WEDGE, HOOK])
def test_a_vehicle_fits_where_its_footprint_is_on_the_free_floor(footprint):
    world = CollisionWorld(floorplan.load("warehouse"), top=1.5)
    world.place("crate", box(3.0, 3.0, 6.0, 4.0))
    world.place("post", Disc((8.0, 8.0), 0.7))
    world.place("wide", box(18.0, 2.0, 25.0, 9.0))
    planner, free = VehiclePlanner(world, footprint), world.walkable
    random = np.random.default_rng(3)
    fits = 0
    for pose in random.uniform([0.0, 0.0, -math.pi], [30.0, 20.0, math.pi], (1500, 3)).tolist():
        there = affinity.rotate(footprint, pose[2], origin=(0, 0), use_radians=True)
        beyond = shapely.area(affinity.translate(there, *pose[:2]).difference(free))
        if planner.fits(pose):
            fits += 1
            assert beyond < 1e-4  # circles are polygons in the plane
        else:
            assert beyond > 0.0
    assert 50 < fits < 1000


def random_poses(planner, count, seed):
    """Return poses on the warehouse's floor in which the vehicle fits."""
    random = np.random.default_rng(seed)
    poses = random.uniform([0.0, 0.0, -math.pi], [30.0, 20.0, math.pi], size=(20 * count, 3))
    return [*itertools.islice(filter(planner.fits, poses.tolist()), count)]


@pytest.mark.parametrize(
    ("footprint", "limits"),
    [(LONG, VehicleLimits()), (WEDGE, VehicleLimits()), (LONG, VehicleLimits(side_speed=1.0))],
)
def test_paths_touch_nothing_and_connect_start_and_goal(world, footprint, limits):
    planner = VehiclePlanner(world, footprint, limits=limits)
    poses = random_poses(planner, 12, 1)
    for start, goal in itertools.pairwise(poses):
        path = planner.plan(start, goal)
        assert path.poses[0].tolist() == start
        assert path.poses[-1][:2] == pytest.approx(goal[:2])
        assert math.remainder(path.poses[-1][2] - goal[2], math.tau) == pytest.approx(0, abs=1e-9)
        assert covers(world, footprint, path, limits) < 1e-9
        assert path.length >= math.dist(start[:2], goal[:2]) - 1e-9


def test_a_vehicle_passes_aisles_narrower_than_its_disc(world):
    planner = VehiclePlanner(world, LONG)
    with pytest.raises(PlanningError):
        PathPlanner(world, math.hypot(1.2, 0.4)).plan((8.5, 2.0), (8.5, 10.0))
    for start, goal in itertools.permutations([8.5, 12.5, 16.5, 20.5, 24.5], 2):
        path = planner.plan((start, 9.0, UP), (goal, 12.0))
        assert covers(world, LONG, path, VehicleLimits()) < 1e-9
        # Out of one aisle and into the other, without a detour around the racks.
        assert path.length < abs(goal - start) + 22.0


def test_a_path_is_reproducible(world):
    one, other = (VehiclePlanner(world, LONG) for _ in range(2))
    poses = random_poses(one, 6, 4)
    asked = [*itertools.pairwise(poses)]
    first = [one.plan(*ends).poses.tolist() for ends in asked]
    assert [other.plan(*ends).poses.tolist() for ends in asked[::-1]] == first[::-1]


def test_a_search_in_se2_finds_a_path_without_room_to_turn():
    """In the bend of a corridor beside a post, it has room for a quarter turn only."""
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


def test_paths_avoid_bodies_at_their_present_places(world):
    busy = world.as_if({"pallet": Disc((8.5, 6.0), 0.3)})
    path = VehiclePlanner(busy, LONG).plan((8.5, 2.0, UP), (8.5, 10.0))
    assert path.length > 20.0  # around the rack, and in from the other end
    assert VehiclePlanner(world, LONG).plan((8.5, 2.0, UP), (8.5, 10.0)).length < 9.0


@pytest.mark.parametrize(
    ("start", "goal", "reason", "message"),
    [
        ((8.0, 5.0, 0.0), (3.0, 3.0), "start_blocked", "touches rack1 at the start"),
        ((3.0, 5.0, 0.0), (8.5, 10.0, 0.0), "goal_blocked", "touches rack1, rack2 at the goal"),
        ((3.0, 5.0, 0.0), (29.9, 10.0), "goal_blocked", "touches the boundary at the goal"),
    ],
)
def test_a_missing_path_has_a_reason(world, start, goal, reason, message):
    with pytest.raises(PlanningError, match=message) as why:
        VehiclePlanner(world, LONG).plan(start, goal)
    assert why.value.reason == reason


def test_an_unreachable_goal_is_proved(world):
    walled = world.as_if({"wall": box(4.4, 0.0, 4.6, 20.0)})
    with pytest.raises(PlanningError, match=r"not even a disc of 0\.4 m") as why:
        VehiclePlanner(walled, LONG).plan((2.0, 5.0, UP), (28.0, 10.0))
    assert why.value.reason == "unreachable"


def test_invalid_footprints_are_rejected(world):
    for footprint, message in (
        (box(1.0, 1.0, 2.0, 2.0), "must contain"),
        (shapely.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), "simple polygon"),
    ):
        with pytest.raises(ValueError, match=message):
            VehiclePlanner(world, footprint)


def hall(*gates, obstacles=()):
    """A hall of 20 × 10 m."""
    plan = floorplan.Floorplan(
        name="hall", boundary=box(0, 0, 20, 10), gates=gates, obstacles=obstacles
    )
    return CollisionWorld(plan, gates=gates)


def test_a_turn_takes_the_longer_direction_if_the_shorter_is_blocked():
    world = hall()
    mast = box(-0.3, -0.3, 1.5, 0.3)
    planner = VehiclePlanner(world, mast)
    assert planner.plan((10, 5, 0.0), (10, 5, 2.5)).turned == pytest.approx(2.5)
    world.place("post", Disc((10 + 1.2 * math.cos(1.2), 5 + 1.2 * math.sin(1.2)), 0.1))
    path = planner.plan((10, 5, 0.0), (10, 5, 2.5))
    assert path.turned == pytest.approx(math.tau - 2.5) and path.length == 0.0
    assert covers(world, mast, path, VehicleLimits()) < 1e-9
    assert planner.plan((10, 5, 2.5), (10, 5, 0.0)).turned == pytest.approx(math.tau - 2.5)


def walled_hall(towards):
    """Return a hall in two halves with a passage in the north and a gate in the south."""
    gate = floorplan.Gate(name="gate", ends=((10.0, 1.0), (10.0, 3.0)), towards=(towards, 2.0))
    wall = [
        floorplan.Obstacle(
            name=f"wall{k}", footprint=box(9.9, low, 10.1, high), bottom=0.0, top=3.0
        )
        for k, (low, high) in enumerate(((0, 1), (3, 7), (9, 10)))
    ]
    return hall(gate, obstacles=wall)


def crosses_gate(path):
    """Return whether a path crosses the gate."""
    line = shapely.LineString([(10.0, 1.0), (10.0, 3.0)])
    return bool(shapely.LineString(path.poses[:, :2]).intersects(line))


@pytest.mark.parametrize("footprint", [box(-0.5, -0.3, 0.5, 0.3), LONG])
def test_vehicles_drive_through_one_way_gates_in_their_direction_only(footprint):
    east, west = (6.0, 2.0, 0.0), (14.0, 2.0, 0.0)
    planner = VehiclePlanner(walled_hall(11.0), footprint)
    through, around = planner.plan(east, west), planner.plan(west, east)
    assert crosses_gate(through) and through.length == pytest.approx(8.0)
    assert not crosses_gate(around) and around.length > 12.0
    assert planner.free_along([east, west]) and not planner.free_along([west, east])


@pytest.mark.parametrize("rotation", [0.0, 0.7, math.pi])
@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -0.8])
def test_drives_end_a_millimetre_before_a_wall_and_pass_it_at_that_distance(rotation, heading):
    limits = VehicleLimits(side_speed=1.0)
    turn = rotation - heading  # of the vehicle relative to its path
    corners = shapely.get_coordinates(affinity.rotate(WEDGE, turn, (0, 0), use_radians=True))
    front, left, back = corners[:, 0].max(), corners[:, 1].max(), -corners[:, 0].min()
    for gap, free in ((0.5e-3, False), (1.5e-3, True)):
        for wall, (begin, end) in (
            (box(3 + front + gap, -5, 9, 5), (0.0, 3.0)),
            (box(-9, -5, -back - gap, 5), (0.0, 3.0)),
            (box(-5, left + gap, 9, 5), (0.0, 3.0)),
        ):
            world = hall()
            turned = affinity.rotate(wall, heading, (0, 0), use_radians=True)
            world.place("wall", affinity.translate(turned, 10, 5))
            planner = VehiclePlanner(world, WEDGE, limits=limits)
            c, s = math.cos(heading), math.sin(heading)
            one, other = ((10 + d * c, 5 + d * s, rotation) for d in (begin, end))
            assert planner.free_along([one, other]) is free
            assert planner.fits(one) and planner.fits(other)


def test_a_turn_is_free_only_if_every_pose_of_it_is():
    world = hall()
    world.place("post", Disc((10 + 0.9, 5 + 0.9), 0.05))
    planner = VehiclePlanner(world, LONG)
    assert planner.free_along([(10, 5, 0.0), (10, 5, 0.3)])
    assert not planner.free_along([(10, 5, 0.0), (10, 5, 1.5)])
    assert planner.free_along([(10, 5, 0.0), (10, 5, -1.5), (10, 5, -1.5)])
    assert not planner.free_along([(10, 5, 0.0), (10, 5, -1.5), (10, 5, -2.6)])


def test_the_estimate_of_seconds_is_that_of_drives_and_turns_from_rest_to_rest():
    limits = VehicleLimits(speed=1.0, acceleration=0.5, jerk=1e6, turn_jerk=1e6)
    planner = VehiclePlanner(hall(), LONG, limits=limits)
    poses = [(2, 2, 0.0), (8, 2, 0.0), (8, 2, 2.0), (8, 2, 2.0)]
    path = vehicle_path(poses[0], poses[1:-1], limits=limits)
    assert planner.seconds(poses) == pytest.approx(path.end, abs=1e-3)
    assert planner.seconds(poses[:2]) == pytest.approx(6.0 / 1.0 + 1.0 / 0.5)


def test_a_vehicle_backs_out_of_a_bay_in_which_it_cannot_turn():
    walls = [
        floorplan.Obstacle(name=f"wall{k}", footprint=box(0, low, 6, high), bottom=0.0, top=3.0)
        for k, (low, high) in enumerate(((3.0, 4.4), (5.6, 7.0)))
    ]
    world = hall(obstacles=walls)
    planner = VehiclePlanner(world, LONG)
    path = planner.plan((1.5, 5.0, 0.0), (1.5, 5.0, math.pi))
    assert covers(world, LONG, path, VehicleLimits()) < 1e-9
    assert path.poses[0].tolist() == [1.5, 5.0, 0.0]
    assert path.poses[:, 0].max() > 6.0
    with pytest.raises(PlanningError) as why:
        planner.plan((1.5, 5.0, 0.0), (1.5, 5.0, 1.0))
    assert why.value.reason == "goal_blocked"


def test_a_path_has_no_unnecessary_turns():
    planner = VehiclePlanner(hall(), LONG)
    path = planner.plan((3, 3, 0.2), (12, 7))
    assert len(path.poses) == 3 and path.length == pytest.approx(math.hypot(9, 4))
    backwards = planner.plan((12, 5, 0.0), (3, 5))
    assert backwards.poses.tolist() == [[12, 5, 0], [3, 5, 0]] or backwards.turned == pytest.approx(
        math.pi
    )
    sliding = VehiclePlanner(hall(), LONG, limits=VehicleLimits(side_speed=1.0))
    assert sliding.plan((3, 3, 0.2), (12, 7)).turned == 0.0


def test_a_vehicle_that_cannot_turn_drives_back():
    plan = floorplan.Floorplan(name="corridor", boundary=box(0, 0, 20, 1.6))
    planner = VehiclePlanner(CollisionWorld(plan), LONG)
    path = planner.plan((15.0, 0.8, 0.0), (3.0, 0.8))
    assert path.poses.tolist() == [[15.0, 0.8, 0.0], [3.0, 0.8, 0.0]]


def test_a_vehicle_drives_ahead_or_back_to_a_place_to_turn():
    for low in (0.0, 14.0):  # the wide part of the corridor is behind it, or ahead
        boundary = shapely.union(box(0, 2, 20, 3.6), box(low, 0, low + 6, 6))
        planner = VehiclePlanner(
            CollisionWorld(floorplan.Floorplan(name="corridor", boundary=boundary)), LONG
        )
        path = planner.plan((low + 7.2 if low == 0 else low - 1.2, 2.8, 0.0), (10.0, 2.8, math.pi))
        assert math.remainder(path.poses[-1][2] - math.pi, math.tau) == pytest.approx(0.0)
        assert path.poses[-1][:2] == pytest.approx([10.0, 2.8])


@pytest.mark.parametrize("seed", range(60))
def test_a_free_turn_touches_no_post(seed):
    rng = np.random.default_rng(seed)
    turn, angle, away = rng.uniform([0.2, -3.0, 0.5], [3.0, 3.0, 1.26])
    at = (10 + away * math.cos(angle), 5 + away * math.sin(angle))
    world = hall()
    world.place("post", Disc(at, 0.02))
    swept = shapely.union_all(
        [affinity.rotate(LONG, turn * k / 300, origin=(0, 0), use_radians=True) for k in range(301)]
    )
    gap = affinity.translate(swept, 10, 5).distance(shapely.Point(at)) - 0.02
    free = VehiclePlanner(world, LONG).free_along([(10, 5, 0.0), (10, 5, turn)])
    assert not free or gap > 0.0
    assert free or gap < 0.06
