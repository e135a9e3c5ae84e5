"""Swept areas of machines: they contain every covered point, and little more."""

import itertools
import math

import numpy as np
import pytest
import shapely
from traffic_parts import LIMITS, Cart, Floor, area_of

import navigation
import sim
from navigation.kernels.areas import is_on_line
from navigation.kernels.numbers import numbers
from navigation.motion import Motion, Piece
from sim.core.clock import Clock
from sim.machines.traffic.areas import CLEAR, Area, Footprint, Part, may_meet

SHAPE = sim.MachineShape(
    name="cart", kind="amr", category="vehicle", length=1.6, width=0.8, top=0.4, top_speed=1.5
)
STILL = (0.0, 0.0, 0.0, 0.0)


def covered(shape, motion, begin, end):
    """Return the area that a machine covers on a motion, from samples."""
    states = [motion.state(float(t)) for t in np.linspace(begin, end, 120)]
    return shapely.union_all([shape.footprint(one.at, one.position[2]) for one in states])


def one_piece(x, y, seconds, rotation=STILL):
    return Motion((Piece(0.0, seconds, x, y, rotation),))


@pytest.mark.parametrize(
    "motion",
    [
        one_piece((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.8, 0.0), 2.0),  # a parabola
        one_piece((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.5), 2.0),
        one_piece((0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 0.5), 2.0),
        one_piece((0.0, 2.0, -1.0, 0.0), STILL, 3.0),  # back and forth on a line
        one_piece((0.0, 2.0, -1.0, 0.0), (0.0, 1.0, -0.5, 0.0), 3.0),
        one_piece((0.0, 1.0, 0.0, 0.0), STILL, 2.0, (0.0, 0.8, 0.0, 0.0)),
        one_piece(STILL, STILL, 2.0, (0.0, 2.0, -1.0, 0.0)),
        one_piece(STILL, STILL, 3.0, (0.0, 0.0, 0.0, 0.3)),
        one_piece(STILL, STILL, 2.0, (0.0, 0.0, 0.7, 0.0)),
    ],
)
def test_the_sweep_of_a_curve_contains_the_covered_area_and_little_more(motion):
    for begin, end in ((0.0, motion.end), (0.3, 1.7), (1.0, motion.end)):
        exact = covered(SHAPE, motion, begin, end)
        area = area_of(Footprint(SHAPE, CLEAR).swept(motion, begin, end))
        assert area.covers(exact)
        assert area.within(exact.buffer(0.12))


@pytest.mark.parametrize("twist", [(1.2, 0.6), (0.0, 1.0)])
def test_the_sweep_of_an_arc_without_clearance_contains_the_covered_area(twist):
    drive = navigation.vehicle_twist((1.0, 2.0, 0.3), twist, seconds=3.0)
    area = area_of(Footprint(SHAPE, 0.0).swept(drive, 0.0, drive.end))
    assert area.buffer(2e-4).covers(covered(SHAPE, drive, 0.0, drive.end))


def test_the_sweep_of_a_straight_drive_is_exact():
    drive = navigation.vehicle_segment(
        (1.0, 2.0, 0.4), (1 + 5 * math.cos(0.4), 2 + 5 * math.sin(0.4))
    )
    for begin, end in ((0.0, drive.end), (1.0, 3.0)):
        area = Footprint(SHAPE, 0.0).swept(drive, begin, end)
        exact = covered(SHAPE, drive, begin, end).convex_hull
        assert area_of(area).symmetric_difference(exact).area < 1e-6
        assert len(area.parts) == 1


def test_the_sweep_of_a_stationary_machine_is_its_footprint_with_the_clearance():
    footprint = Footprint(SHAPE, CLEAR)
    stands = navigation.standing((3.0, 4.0), heading=0.7)
    exact = SHAPE.footprint((3.0, 4.0), 0.7).buffer(CLEAR, join_style="mitre")
    for area in (footprint.swept(stands, 2.0, 9.0), footprint.at((3.0, 4.0, 0.7))):
        assert area_of(area).symmetric_difference(exact).area < 1e-9
        assert area.bounds == pytest.approx(exact.bounds)


def test_a_footprint_beside_its_axis_turns_about_the_axis():
    beside = sim.MachineShape(
        name="arm",
        kind="amr",
        category="vehicle",
        length=1.0,
        width=1.0,
        top=0.4,
        top_speed=1.0,
        outline=((1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 1.0)),
    )
    motion = navigation.vehicle_turn((0.0, 0.0, 0.0), 2.5)
    exact = covered(beside, motion, 0.0, motion.end)
    area = area_of(Footprint(beside, CLEAR).swept(motion, 0.0, motion.end))
    assert area.covers(exact) and area.within(exact.buffer(0.1))


def test_a_long_turn_of_a_footprint_before_its_axis_leaves_the_other_side_free():
    outline = ((1.4, -0.3), (1.4, 0.3), (-0.4, 0.3), (-0.4, -0.3))
    keys = {"kind": "amr", "category": "vehicle", "top": 0.4, "top_speed": 1.0}
    shape = sim.MachineShape(name="long", length=2.8, width=0.6, outline=outline, **keys)
    motion = navigation.vehicle_turn((0.0, 0.0, 0.0), 4.2)
    exact = covered(shape, motion, 0.0, motion.end)
    area = area_of(Footprint(shape, 0.0).swept(motion, 0.0, motion.end))
    assert area.buffer(1e-3).covers(exact) and area.within(exact.buffer(0.03))


def test_areas_meet_exactly_where_their_polygons_do():
    rng = np.random.default_rng(1)
    met = 0
    for x, y, turn in rng.uniform([-2.5, -2.5, -3], [2.5, 2.5, 3], (200, 3)).tolist():
        one, other = (
            Footprint(SHAPE, 0.0).at((0.0, 0.0, 0.3)),
            Footprint(SHAPE, 0.0).at((x, y, turn)),
        )
        exact = SHAPE.footprint((0.0, 0.0), 0.3).intersects(SHAPE.footprint((x, y), turn))
        assert one.meets(other) == other.meets(one) == exact
        met += exact
        boxes = [shapely.box(*area.bounds) for area in (one, other)]
        assert one.gap(other) == pytest.approx(boxes[0].distance(boxes[1]))
    assert 20 < met < 180


def test_the_union_of_areas_has_the_bounds_of_all():
    footprint = Footprint(SHAPE, 0.0)
    poses = [(0.0, 0.0, 0.0), (-4.0, 7.0, 0.0), (5.0, -3.0, 0.0)]
    union = Area.of([footprint.at(pose) for pose in poses])
    assert union.bounds == pytest.approx((-4.8, -3.4, 5.8, 7.4))
    for pose in poses:
        assert union.meets(footprint.at(pose))
    assert not union.meets(footprint.at((0.0, 4.0, 0.0)))


def shape(name="one", **keys):
    return sim.MachineShape(
        **{
            "name": name,
            "kind": "agv",
            "category": "vehicle",
            "length": 1.2,
            "width": 0.8,
            "top": 0.5,
            "top_speed": 1.0,
            **keys,
        }
    )


def test_machines_may_meet_unless_their_heights_or_lanes_are_apart():
    east = shape(course=((0.0, 0.0), (9.0, 0.0)), direction=(1.0, 0.0))
    for y, meets in ((0.5, True), (0.81, True), (0.83, False), (3.0, False)):
        other = shape("other", course=((5.0, y), (20.0, y)), direction=(1.0, 0.0))
        assert may_meet(east, other) is may_meet(other, east) is meets
    north = shape("north", course=((4.0, -5.0), (4.0, 5.0)), direction=(0.0, 1.0))
    beyond = shape("beyond", course=((12.0, -5.0), (12.0, 5.0)), direction=(0.0, 1.0))
    assert may_meet(east, north) and not may_meet(east, beyond)
    free = shape("free", kind="amr")
    assert may_meet(east, free) and may_meet(beyond, free)
    assert not may_meet(shape("high", kind="amr", bottom=0.6, top=2.0), free)
    assert may_meet(shape("high", kind="amr", bottom=0.4, top=2.0), free)


def braked(cart, motion, t):
    """Return the area that a machine covers when it brakes at time `t` of a motion."""
    stop = cart.stopping(motion.state(t), t)
    return covered(cart.shape, stop, t, stop.end)


DRIVES = {
    "straight": lambda cart: navigation.vehicle_segment((0, 0, 0), (12, 0), limits=LIMITS),
    "turn": lambda cart: navigation.vehicle_turn((0, 0, 0), 3.0, limits=LIMITS),
    "arc": lambda cart: navigation.vehicle_twist((0, 0, 0), (1.2, 0.6), seconds=8, limits=LIMITS),
    "back": lambda cart: navigation.vehicle_twist(
        (0, 0, 1), (-0.6, -0.9), seconds=8, limits=LIMITS
    ),
}


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("now", [0.0, 1.3, 2.5])
def test_a_part_contains_the_motion_and_every_stop_on_it(name, now):
    cart = Floor().cart("one", 0.0)
    motion = DRIVES[name](cart)
    part = Part(cart, motion, now, 1.0)
    area = area_of(part.area(Footprint(cart.shape, CLEAR)))
    assert now < part.end <= now + 1.5
    assert area.covers(covered(cart.shape, motion, now, part.end))
    for t in np.linspace(now, part.end, 12).tolist():
        # Within 2 cm, because stops between the samples are not computed.
        assert area.buffer(0.02).covers(braked(cart, motion, t))
    last = braked(cart, motion, part.end)
    assert area.within(last.union(covered(cart.shape, motion, now, part.end)).buffer(0.3))


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("now", [0.0, 1.3, 2.5])
def test_a_known_stopping_distance_changes_no_answer_about_an_area(name, now):
    class Limited(Cart):
        stopping_distance = LIMITS.longest_stop.distance

    cart = Limited(Clock(), "one", (0.0, 0.0, 0.0))
    area = Part(cart, DRIVES[name](cart), now, 1.0).area(Footprint(cart.shape, CLEAR))
    exact, probe = area_of(area), Footprint(shape(length=0.2, width=0.2), 0.0)
    met = 0
    for x, y in itertools.product(np.arange(-6.0, 10.0, 0.3), np.arange(-6.0, 6.0, 0.3)):
        other = probe.at((x, y, 0.4))
        assert area.meets(other) == exact.intersects(area_of(other))
        met += area.meets(other)
    assert met > 10


@pytest.mark.parametrize(
    ("rest", "end"), [(0.6, 0.6), (1.0, 1.0), (1.4, 1.4), (1.6, 1.0), (9.0, 1.0)]
)
def test_a_part_ends_where_the_machine_rests_or_after_its_time(rest, end):
    cart = Floor().cart("one", 0.0)
    # One metre from rest to rest in a fixed time: 3 s² - 2 s³.
    first = Piece(0.0, rest, (0.0, 0.0, 3 / rest**2, -2 / rest**3), STILL, STILL)
    second = Piece(rest, rest + 3.0, (1.0, 0.0, 3 / 9, -2 / 27), STILL, STILL)
    motion = Motion((first, second))
    assert Part(cart, motion, 0.0, 1.0).end == pytest.approx(end)
    only = Motion((first,))
    assert Part(cart, only, 0.0, 20.0).end == pytest.approx(rest)


def test_a_part_of_a_machine_whose_stop_is_unknown_is_the_motion_alone():
    cart = Floor().cart("one", 0.0)
    cart.stopping = lambda state, t: None
    motion = navigation.vehicle_segment((0, 0, 0), (12, 0), limits=LIMITS)
    part = Part(cart, motion, 0.0, 3.0)
    area = area_of(part.area(Footprint(cart.shape, 0.0)))
    exact = covered(cart.shape, motion, 0.0, part.end)
    assert part.end == 3.0 and area.symmetric_difference(exact).area < 1e-6


def test_straight_poses_are_a_line_or_a_turn_on_the_spot():
    def on_line(*poses):
        return is_on_line(numbers(c for pose in poses for c in pose))

    assert on_line((0, 0, 0), (1, 1, 0), (3, 3, 0))
    assert on_line((0, 0, 0), (0, 0, 1), (0, 0, 3))
    assert on_line((0, 0, 0), (1, 2, 3))
    assert not on_line((0, 0, 0), (1, 0, 0), (2, 1e-3, 0))
    assert not on_line((0, 0, 0), (1, 0, 0.1), (2, 0, 0))
