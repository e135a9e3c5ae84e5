"""Distances between surfaces, against shapely and dense sampling."""

import itertools
import math
import pickle
from functools import partial

import fcl
import numpy as np
import pytest
import shapely
from hypothesis import given, settings, strategies as st
from stretches import assert_bounds, assert_negative_within, encounters, part_of

import floorplan
import navigation
from navigation import (
    Box,
    Cylinder,
    FixedDistance,
    IntegralLaw,
    Moving,
    Prism,
    SeparationLaw,
    Shapes,
)

END = 20.0
PLAN = floorplan.load("ariac2023")
TORSO = Shapes(machine=(Box.of_torso(PLAN.gantry),))
ARM = Shapes(machine=(Cylinder.of_arm(PLAN.gantry),))
CHILD = Shapes(person=Cylinder(radius=0.25, top=1.0), machine=(Box.of_torso(PLAN.gantry),))
LONG = Shapes(
    machine=(Box(length=2.4, width=0.4, bottom=1.3, top=2.0), Cylinder(radius=0.6, top=3.0))
)
WEDGE = Shapes(
    machine=(Prism(footprint=((-0.4, -0.5), (1.9, -0.2), (1.6, 0.6), (0.4, 0.1)), top=1.0),)
)
BESIDE = Shapes(machine=(Prism(footprint=((0.5, 0.3), (1.5, 0.3), (1.5, 0.9), (0.5, 0.9)), top=1),))

point = st.tuples(st.floats(-6, 0), st.floats(-3, 3))
walks = st.builds(navigation.walk, st.lists(point, min_size=2, max_size=5), st.floats(0, 3))
poses = st.tuples(st.floats(-6, 0), st.floats(-3, 3), st.floats(-3, 3))
gantry_motions = st.builds(navigation.gantry_move, poses, poses, st.floats(0, 3))
all_shapes = st.sampled_from([TORSO, ARM, CHILD, LONG, WEDGE, BESIDE])
laws = st.one_of(
    st.builds(FixedDistance, st.floats(0, 3)),
    st.builds(
        lambda t, d: SeparationLaw(t1=t, t2=0.5, intrusion=d), st.floats(0, 1), st.floats(0, 1)
    ),
)


def by_shapely(person, machine, shapes, ts):
    """Return the distances at many times from rotated footprints and the gap of heights."""
    places, centres, turns = person.position(ts), machine.position(ts), machine.rotation(ts)
    axes = shapely.points(places)
    least = np.full(len(ts), np.inf)
    for part in shapes.machine:
        if isinstance(part, Prism):
            corners = shapely.get_coordinates(shapely.MultiPoint(part.footprint).convex_hull)[:-1]
        elif isinstance(part, Box):
            x, y = part.length / 2, part.width / 2
            corners = np.array([(x, y), (-x, y), (-x, -y), (x, -y)])
        if not isinstance(part, Cylinder):
            c, s = np.cos(turns), np.sin(turns)
            turn = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], -2)
            footprints = shapely.polygons(corners @ turn + centres[:, None])
            flat = shapely.distance(axes, footprints)
        else:
            flat = shapely.distance(axes, shapely.points(centres)) - part.radius
        flat = np.maximum(flat - shapes.person.radius, 0.0)
        above = max(part.bottom - shapes.person.top, shapes.person.bottom - part.top, 0.0)
        least = np.minimum(least, np.hypot(flat, above))
    return least


def distance_at(person, machine, shapes, t):
    (encounter,) = encounters(person, machine, t, t, shapes.gauges)
    return encounter.distance(t)


@given(point, poses, all_shapes)
def test_the_distance_is_that_of_rotated_footprints(at, pose, shapes):
    person = navigation.standing(at)
    machine = navigation.standing(pose[:2], heading=pose[2])
    expected = by_shapely(person, machine, shapes, np.array([0.0]))[0]
    assert distance_at(person, machine, shapes, 0.0) == pytest.approx(expected, abs=1e-12)


@given(walks, gantry_motions, all_shapes)
def test_distances_at_many_times_are_those_of_the_monitor(person, machine, shapes):
    ts = np.linspace(0.0, END, 50)
    poses = np.column_stack([machine.position(ts), machine.rotation(ts)])
    found = shapes.distances(person.position(ts), poses)
    assert found == pytest.approx(by_shapely(person, machine, shapes, ts), abs=1e-9)


def test_a_body_that_turns_on_the_spot_moves_beyond_its_axis():
    still, turn = navigation.standing((5.0, 0.0)), navigation.gantry_move((0, 0, 0), (0, 0, 1.5))
    assert navigation.first_time(Moving(0.1), still, turn, 0.0, 10.0) is None
    ((begin, end),) = navigation.when(Moving(0.1, reach=2.0), still, turn, 0.0, 10.0)
    for t in (begin, end):
        assert abs(turn.state(t).velocity[2]) * 2.0 == pytest.approx(0.1, abs=1e-6)
    assert 0.0 < begin < end < turn.end


@pytest.mark.parametrize(
    ("footprint", "fault"),
    [
        (((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)), "must have an area"),
        (((0.0, 0.0), (1.0, math.nan), (2.0, 0.0)), "must have an area"),
        ((), "must have an area"),
    ],
)
def test_a_prism_has_an_area(footprint, fault):
    with pytest.raises(ValueError, match=fault):
        Prism(footprint=footprint, top=1.0)


@given(point, poses)
def test_the_distance_is_that_of_fcl(at, pose):
    box, probe = TORSO.machine[0], 1e-6
    heading = np.array([math.cos(pose[2] / 2), 0.0, 0.0, math.sin(pose[2] / 2)])
    turn = fcl.Transform(heading, np.array([*pose[:2], 0.0]))
    torso = fcl.CollisionObject(fcl.Box(box.length, box.width, 1.0), turn)
    axis = fcl.CollisionObject(fcl.Sphere(probe), fcl.Transform(np.array([*at, 0.0])))
    away = fcl.distance(torso, axis, fcl.DistanceRequest(), fcl.DistanceResult()) + probe
    flat = Shapes(person=Cylinder(radius=0.25, top=2.0), machine=TORSO.machine)
    expected = max(away - 0.25, 0.0)
    machine = navigation.standing(pose[:2], heading=pose[2])
    found = distance_at(navigation.standing(at), machine, flat, 0.0)
    assert found == pytest.approx(expected, abs=1e-9)


def test_the_distance_to_the_faces_and_the_corners_of_the_torso():
    """1.05 × 0.95 m, and a person of 0.3 m radius."""
    machine = navigation.standing((0, 0))
    for at, expected in (
        ((2.0, 0.1), 2.0 - 0.525 - 0.3),
        ((0.2, -2.0), 2.0 - 0.475 - 0.3),
        ((0.525 + 3, 0.475 + 4), 5.0 - 0.3),
        ((0.7, 0.0), 0.0),
    ):
        found = distance_at(navigation.standing(at), machine, TORSO, 0.0)
        assert found == pytest.approx(expected, abs=1e-12)
    turned = navigation.standing((0, 0), heading=math.pi / 2)
    found = distance_at(navigation.standing((2.0, 0.1)), turned, TORSO, 0.0)
    assert found == pytest.approx(2.0 - 0.475 - 0.3, abs=1e-12)


def test_the_torso_passes_over_short_people():
    """With its bottom at 1.24 m, the gap over 1.0 m of height is 0.24 m."""
    machine, below = navigation.standing((0, 0)), navigation.standing((0.1, 0.1))
    assert distance_at(below, machine, CHILD, 0.0) == pytest.approx(0.24, abs=1e-12)
    assert distance_at(below, machine, TORSO, 0.0) == 0.0
    beside = navigation.standing((0.525 + 0.25 + 0.32, 0.0))
    assert distance_at(beside, machine, CHILD, 0.0) == pytest.approx(0.4, abs=1e-12)


def test_the_shapes_are_those_of_the_floorplan():
    assert Box.of_torso(PLAN.gantry) == Box(length=1.05, width=0.95, bottom=1.24, top=2.71)
    assert Cylinder.of_arm(PLAN.gantry) == Cylinder(radius=0.9, bottom=1.1, top=2.71)
    assert Box.of_agv(PLAN.lane("agv1")) == Box(length=1.17, width=0.67, top=1.21)


def test_an_agv_touches_people_beside_its_lane_by_its_width():
    lane = PLAN.lane("agv1")
    run = navigation.agv_run(lane, 0.0, 10.0)
    shapes = Shapes(machine=(Box.of_agv(lane),))
    (x, y), away = lane.position(5.0), 0.67 / 2 + 0.3
    for gap in (0.1, 1e-6):
        beside = navigation.standing((x, y + away + gap))
        _, nearest = navigation.minimum_separation(beside, run, 0.0, 60.0, shapes=shapes)
        assert nearest == pytest.approx(gap, abs=1e-9)
        assert (
            navigation.violations(beside, run, FixedDistance(0.0), 0.0, 60.0, shapes=shapes) == []
        )
    inside = navigation.standing((x, y + away - 0.01))
    assert navigation.minimum_separation(inside, run, 0.0, 60.0, shapes=shapes)[1] == 0.0


@settings(max_examples=settings.default.max_examples // 3)
@given(walks, gantry_motions, all_shapes, laws)
def test_violations_are_those_of_dense_sampling(person, machine, shapes, law):
    ts = np.arange(0, END, 2e-3)
    human, robot = (np.hypot(*motion.velocity(ts).T) for motion in (person, machine))
    margins = by_shapely(person, machine, shapes, ts) - law.distance(human, robot)
    found = navigation.violations(person, machine, law, 0.0, END, shapes=shapes)
    assert_negative_within(found, ts, margins, END)
    first = navigation.first_violation(person, machine, law, 0.0, END, shapes=shapes)
    assert first == (found[0][0] if found else None)
    _, least = navigation.minimum_margin(person, machine, law, 0.0, END, shapes=shapes)
    assert least <= margins.min() + 1e-9
    assert least >= margins.min() - 0.03
    assert bool(found) == (least < 0) or abs(least) < 1e-9


@given(walks, gantry_motions, all_shapes)
def test_times_are_exact_to_a_microsecond(person, machine, shapes):
    law = FixedDistance(0.5)
    for instant in itertools.chain(
        *navigation.violations(person, machine, law, 0.0, END, shapes=shapes)
    ):
        if 0.0 < instant < END:
            around = np.array([instant - 1e-6, instant + 1e-6])
            before, after = by_shapely(person, machine, shapes, around) - 0.5
            assert before * after <= 0.0 or min(abs(before), abs(after)) < 1e-9


@settings(max_examples=settings.default.max_examples // 3)
@given(walks, gantry_motions, all_shapes)
def test_the_minimum_is_that_of_dense_sampling(person, machine, shapes):
    coarse = np.arange(0, END, 3e-3)
    t, nearest = navigation.minimum_separation(person, machine, 0.0, END, shapes=shapes)
    distances = by_shapely(person, machine, shapes, coarse)
    candidates = coarse[distances <= distances.min() + 9e-3]
    between = np.clip(np.concatenate([candidates - 1e-3, candidates + 1e-3]), 0.0, END)
    sampled = min(distances.min(), by_shapely(person, machine, shapes, between).min())
    assert sampled - 3e-3 <= nearest <= sampled + 1e-9
    assert by_shapely(person, machine, shapes, np.array([t]))[0] == pytest.approx(nearest, abs=1e-9)


@given(walks, gantry_motions, all_shapes, st.floats(-1, 1), st.floats(0, 1), st.floats(0, 1))
def test_bounds_hold_throughout_an_interval(person, machine, shapes, slope, low, high):
    distances = partial(by_shapely, person, machine, shapes)
    for encounter in encounters(person, machine, 0.0, END, shapes.gauges):
        begin, end = part_of(encounter, low, high)
        if end <= begin:
            continue
        for steepness, curve in ((0.0, 0.0), (slope, 0.0), (slope, 2 * slope), (0.0, slope)):
            assert_bounds(encounter, begin, end, steepness, curve, distances)


@pytest.mark.parametrize("milliseconds", [1.0, 0.1, 0.01])
def test_a_violation_of_a_millisecond_is_not_missed(milliseconds):
    """At 1 m/s past a corner, closer than 0.5 m for a moment."""
    half_chord = milliseconds / 2000
    away = math.sqrt(0.8**2 - half_chord**2)
    machine = navigation.standing(
        (0.0, -0.475 * math.cos(0.5) - 0.525 * math.sin(0.5)), heading=0.5
    )
    corner = (-0.525 * math.cos(0.5) * -1 - 0.475 * math.sin(0.5), 0.0)
    person = navigation.walk([(-9, away), (9, away)], 0.0)
    law = FixedDistance(0.5)
    ((begin, end),) = navigation.violations(person, machine, law, 0.0, 60.0, shapes=TORSO)
    middle = 9.2 + corner[0]
    assert begin == pytest.approx(middle - half_chord, abs=1e-6)
    assert end == pytest.approx(middle + half_chord, abs=1e-6)


def test_beside_a_wall_that_turns_the_minimum_takes_few_steps():
    """Bounds of first order would need 100 000 intervals beside the turning face of a torso."""
    person, machine = (
        navigation.Motion((navigation.Piece(0.0, 2.0, *((c, v, 0.0, 0.0) for c, v in axes)),))
        for axes in (
            ((-3.228, 0.150), (-2.418, 0.989), (0.0, 0.0)),
            ((-2.378, 0.610), (-0.411, -0.555), (0.971, -0.785)),
        )
    )
    asked = 0

    class Nothing:
        def required(self, encounter, begin, end):
            nonlocal asked
            asked += 1
            return navigation.Enclosure(value=0.0)

    span = (0.0, 2.0)
    _, nearest = navigation.minimum_margin(person, machine, Nothing(), *span, shapes=TORSO)
    assert nearest > 0.1
    assert nearest == navigation.minimum_separation(person, machine, *span, shapes=TORSO)[1]
    assert 10 < asked < 3000


@pytest.mark.parametrize("required", [0.5, 0.1, 1 / 3])
def test_a_tie_is_no_violation_and_needs_few_steps(required):
    """An AGV passes a person who stands exactly at the required distance from its lane."""
    lane = PLAN.lane("agv1")
    run = navigation.agv_run(lane, 0.0, 17.0)
    shapes = Shapes(machine=(Box.of_agv(lane),))
    (x, y), law = lane.position(8.0), FixedDistance(required)
    beside = navigation.standing((x, y + 0.67 / 2 + 0.3 + required))
    assert navigation.violations(beside, run, law, 0.0, 60.0, shapes=shapes) == []
    turned = navigation.gantry_move((x, y, 0.0), (x, y, 3.0))
    by_the_arm = navigation.standing((x + 1.2 + required, y))
    assert navigation.violations(by_the_arm, turned, law, 0.0, 60.0, shapes=ARM) == []


@pytest.mark.parametrize("required", [1e-3, 1e-9, 1e-160])
def test_a_person_inside_a_solid_is_too_close_for_any_law(required):
    machine = navigation.gantry_move((-2.0, 0.0, -1.0), (-1.8, 0.1, 1.0))
    person = navigation.walk([(-2.2, 0.1), (-1.6, -0.1)], 0.0)
    found = navigation.violations(person, machine, FixedDistance(required), 0, 60, shapes=ARM)
    assert found == ([(0.0, 60.0)] if required > 1e-12 else [])


def test_the_integral_law_between_surfaces():
    """Head on, surfaces are 0.825 m closer than centres."""
    person, machine = navigation.walk([(-10, 0), (10, 0)], 0.0), navigation.standing((0, 0))
    law = IntegralLaw(t1=1.0, t2=1.5, stopping=0.0, intrusion=1.0)
    t = navigation.first_violation(person, machine, law, 0.0, 60.0, shapes=TORSO)
    assert t == pytest.approx(6.5 + 0.2 - 0.825, abs=1e-6)


def test_conditions_use_distances_between_surfaces():
    person, machine = navigation.walk([(-10, 0), (10, 0)], 0.0), navigation.standing((0, 0))
    apart = navigation.Apart(2.0)
    (begin, _), (_, end) = navigation.when(apart, person, machine, 0.0, 60.0, shapes=TORSO)
    assert (begin, end) == (0.0, 60.0)
    t = navigation.first_time(~apart, person, machine, 0.0, 60.0, shapes=TORSO)
    assert t == pytest.approx(10.2 - 2.825, abs=1e-6)


def corners_at(box, motion, ts):
    """Return the corners of a box that turns with its body, at many times."""
    corners = np.array(box.corners)
    c, s = np.cos(motion.rotation(ts)), np.sin(motion.rotation(ts))
    turn = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], -2)
    return corners @ turn + motion.position(ts)[:, None]


def overlaps(some, others):
    """Return by how much pairs of rectangles (N, 4, 2) overlap, less than 0 if they are apart.

    The overlap is the distance of 0 from the border of the differences of all their points.
    """
    differences = (some[:, :, None] - others[:, None]).reshape(len(some), -1, 2)
    hulls = shapely.convex_hull(shapely.multipoints(differences))
    away = shapely.distance(shapely.Point(0.0, 0.0), shapely.boundary(hulls))
    return np.where(shapely.contains_xy(hulls, 0.0, 0.0), away, -away)


boxes = st.builds(Box, length=st.floats(0.2, 3), width=st.floats(0.2, 3), top=st.just(1.0))


@settings(max_examples=60)
@given(gantry_motions, gantry_motions, boxes, boxes, st.sampled_from([0.0, 1e-3, 0.1]))
def test_boxes_overlap_as_their_corners_do(one, other, box, others, depth):
    found = navigation.when(navigation.Overlapping(box, others, depth), one, other, 0.0, END)
    ts = np.linspace(0.0, END, 400)
    margins = depth - overlaps(corners_at(box, one, ts), corners_at(others, other, ts))
    assert_negative_within(list(found), ts, margins, END)


def test_crossing_boxes_overlap_by_their_lengths():
    """At 1 m/s each, at a right angle, from 1 m before the crossing to 1 m after it."""
    box = Box(length=1.2, width=0.8, top=1.0)
    across = navigation.gantry_move((-5.0, 0.0, 0.0), (5.0, 0.0, 0.0), 0.0)
    along = navigation.gantry_move((0.0, -5.0, math.pi / 2), (0.0, 5.0, math.pi / 2), 0.0)
    ((begin, end),) = navigation.when(navigation.Overlapping(box, box), across, along, 0.0, 20.0)
    assert across.position(begin) == pytest.approx((-1.0, 0.0), abs=1e-6)
    assert across.position(end) == pytest.approx((1.0, 0.0), abs=1e-6)
    above = Box(length=9.0, width=9.0, bottom=1.0, top=2.0)
    over = navigation.Overlapping(box, above)
    assert navigation.first_time(over, across, along, 0.0, 20.0) is None


@pytest.mark.parametrize("width", [0.8, 0.1, 1 / 3])
def test_boxes_that_slide_along_each_other_need_few_steps(width):
    """Side by side they only touch, or overlap by exactly the allowed depth."""
    box = Box(length=1.2, width=width, top=1.0)
    away, back = ((-5.0, 0.0, 0.0), (5.0, 0.0, 0.0)), ((5.0, width, 0.0), (-5.0, width, 0.0))
    one, other = navigation.gantry_move(*away, 0.0), navigation.gantry_move(*back, 0.0)
    for depth in (0.0, 1e-3):
        closer = other.translated(0.0, -depth)
        condition = navigation.Overlapping(box, box, depth)
        assert list(navigation.when(condition, one, closer, 0.0, 20.0)) == []
        deeper = other.translated(0.0, -depth - 1e-6)
        assert len(list(navigation.when(condition, one, deeper, 0.0, 20.0))) == 1
    with pytest.raises(ValueError, match="can't overlap by more than -1"):
        navigation.Overlapping(box, box, -1.0)


def test_shapes_are_values():
    assert Shapes(machine=TORSO.machine) == TORSO != ARM
    distance_at(navigation.standing((5, 5)), navigation.standing((0, 0)), TORSO, 0.0)
    copy = pickle.loads(pickle.dumps(TORSO))
    assert copy == TORSO
    assert hash(copy) == hash(TORSO)
    found = distance_at(navigation.standing((2, 0)), navigation.standing((0, 0)), copy, 0.0)
    assert found == pytest.approx(1.175)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Cylinder(radius=0.0, top=1.0), "radius of a Cylinder can't be 0.0 m"),
        (lambda: Cylinder(radius=math.nan, top=1.0), "radius of a Cylinder can't be nan m"),
        (lambda: Box(length=-1.0, width=1.0, top=1.0), "length of a Box can't be -1.0 m"),
        (lambda: Box(length=1.0, width=math.inf, top=1.0), "width of a Box can't be inf m"),
        (lambda: Box(length=1.0, width=1.0, bottom=2.0, top=1.0), "must be above bottom"),
        (lambda: Box(length=1.0, width=1.0, bottom=-1.0, top=1.0), "bottom of a Box can't be"),
        (lambda: Shapes(machine=()), "needs at least one solid"),
        (lambda: Shapes(machine=(3.0,)), "made of Cylinder, Box and Prism, not 3.0"),
        (lambda: Shapes(person=TORSO.machine[0], machine=TORSO.machine), "a person is a Cylinder"),
    ],
)
def test_invalid_solids_are_rejected(make, message):
    with pytest.raises(ValueError, match=message.replace(".", r"\.").replace("'", ".")):
        make()


def test_a_rotation_that_is_not_finite_is_rejected():
    nowhere = navigation.Motion(
        (navigation.Piece(0.0, 9.0, (0.0,) * 4, (0.0,) * 4, (math.nan, 0.0, 0.0, 0.0)),)
    )
    with pytest.raises(ValueError, match="a motion is not finite"):
        navigation.violations(
            navigation.standing((2, 0)), nowhere, FixedDistance(1.0), 0.0, 9.0, shapes=TORSO
        )
