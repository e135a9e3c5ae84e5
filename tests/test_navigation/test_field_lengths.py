"""Lengths of protective fields against the motions of machines."""

import itertools
import math
import random
from dataclasses import replace

import pytest
import shapely
from shapely import affinity
from shapely.geometry import Polygon

from floorplan import UserError
from navigation import (
    FieldSet,
    FieldSupplements,
    ProtectiveFields,
    VehicleLimits,
    needed_fields,
    short_fields,
    stopping_reach,
    vehicle_segment,
    vehicle_stop,
    vehicle_turn,
    vehicle_twist,
)
from navigation.field_lengths import STEP, directions, main_directions, swept_straight, swept_turn
from navigation.machines import AxisLimits

FOOTPRINT = shapely.box(-1.2, -0.4, 1.2, 0.4)
BARE = FieldSupplements(measurement=0.0, wear=0.0, ground_clearance=0.0, side=0.0)
DRIVES = (
    VehicleLimits(),
    VehicleLimits(speed=0.8, acceleration=0.3, jerk=math.inf),
    VehicleLimits(side_speed=0.9),
)


def rectangle(front, back=1.3, side=0.5):
    return ((-back, -side), (front, -side), (front, side), (-back, side))


@pytest.mark.parametrize("limits", DRIVES)
def test_no_stop_from_a_speed_travels_farther(limits):
    rng = random.Random(1)
    farthest = {}
    for _ in range(300):
        axis = limits.along(1.0, 0.0)
        drive = vehicle_segment((0, 0, 0), (rng.uniform(0.1, 4), 0), limits=limits)
        t, response = rng.uniform(0, drive.end), rng.choice([0.0, 0.2, 0.7])
        stop = vehicle_stop(drive.state(t + response), t + response, limits=limits)
        way = float(stop.position(stop.end)[0] - drive.position(t)[0])
        speed = float(drive.velocity(t)[0])
        reach = stopping_reach(axis, speed, response).distance
        assert way <= reach + 1e-9
        farthest[response] = max(farthest.get(response, 0.0), way / reach)
    assert min(farthest.values()) > 0.95  # the bound is tight


def test_no_turn_from_a_speed_turns_farther():
    rng, limits = random.Random(2), VehicleLimits()
    for _ in range(200):
        turn = vehicle_turn((0, 0, 0), rng.uniform(0.1, 4), limits=limits)
        t, response = rng.uniform(0, turn.end), rng.choice([0.0, 0.2, 0.7])
        stop = vehicle_stop(turn.state(t + response), t + response, limits=limits)
        way = float(stop.rotation(stop.end) - turn.rotation(t))
        speed = turn.state(t).velocity[2]
        assert way <= stopping_reach(limits.turning, speed, response).distance + 1e-9


def test_the_travel_of_an_agv_is_response_and_braking():
    reach = stopping_reach(AxisLimits(2.0, 2.0), 2.0, 0.2)
    assert reach == pytest.approx((0.4, 1.0, 1.2))


def test_the_length_is_the_sum_of_the_standard():
    reach = stopping_reach(AxisLimits(2.0, 2.0), 2.0, 0.2)
    sizes = FieldSupplements(
        measurement=0.1, reflectors=0.2, wear=0.1, ground_clearance=0.15, approach_speed=1.6
    )
    assert sizes.length(reach) == pytest.approx(0.1 + 0.2 + 0.15 + 0.1 * 1.0 + 1.6 * 1.2)


@pytest.mark.parametrize("limits", [*DRIVES, AxisLimits(2.0, 2.0)])
def test_computed_fields_are_long_enough(limits):
    top = limits.max_speed if isinstance(limits, AxisLimits) else limits.top_speed
    speeds = [0.3, top]
    fields = needed_fields(FOOTPRINT, limits, speeds, response_time=0.3, supplements=BARE)
    assert short_fields(fields, FOOTPRINT, limits) == ()
    low = 0.0 if fields.sets[0].direction else -top
    assert fields.gaps((low, top), (-1.0, 1.0)) == ()
    for each in fields.sets:
        assert Polygon(each.warning).covers(Polygon(each.protective))


def test_sets_for_driving_backwards_are_optional():
    keys = {"response_time": 0.2, "backwards": False}
    fields = needed_fields(FOOTPRINT, VehicleLimits(), [0.3, 1.5], **keys)
    assert next(gap.linear for gap in fields.gaps((-1.5, 1.5))) == (-1.5, -0.3)


def test_supplements_lengthen_and_widen_fields():
    keys = {"response_time": 0.2, "supplements": BARE}
    bare = needed_fields(FOOTPRINT, VehicleLimits(), [0.3, 1.5], **keys)
    keys["supplements"] = FieldSupplements(wear=0.0, approach_speed=0.0, side=0.2)
    wide = needed_fields(FOOTPRINT, VehicleLimits(), [0.3, 1.5], **keys)
    bare, wide = (Polygon(each.sets[2].protective).bounds for each in (bare, wide))
    assert [b - a for a, b in zip(bare, wide, strict=True)] == pytest.approx(
        [-0.2, -0.2, 0.45, 0.2], abs=0.011
    )


def test_a_short_field_is_reported_with_its_length():
    reach = stopping_reach(VehicleLimits().along(1, 0), 1.5, 0.2).distance
    field = FieldSet(name="fast", protective=rectangle(2.0), linear=(0.1, 2.0), theta=(0.0, 0.0))
    fields = ProtectiveFields(sets=[field], response_time=0.2)
    (short,) = short_fields(fields, FOOTPRINT, VehicleLimits())
    assert short.missing == pytest.approx(1.2 + reach - 2.0, abs=1e-5)
    assert short.speed == 1.5
    assert str(short) == (
        "the protective field of 'fast' is 1.60 m too short ahead:"
        " at 1.5 m/s the machine stops after 2.40 m"
    )
    assert not short_fields(fields, FOOTPRINT, VehicleLimits(speed=0.3))


def test_a_narrow_field_is_reported_for_turns():
    field = FieldSet(name="rest", protective=rectangle(2.0), linear=(0, 0.05), theta=(-1, 0))
    fields = ProtectiveFields(sets=[field], response_time=0.2)
    (short,) = short_fields(fields, FOOTPRINT, VehicleLimits())
    assert short.travel == "turning right"
    corner = math.hypot(1.2, 0.4)
    turned = affinity.rotate(FOOTPRINT, -short.reach, (0, 0), use_radians=True)
    assert 0 < short.missing <= corner - 0.5
    assert short.missing >= -turned.bounds[1] - 0.5 - 1e-6


def covered_on_arc(twist, response, limits):
    """Return poses of the footprint on an arc, from a contact to the standstill, in the frame."""
    drive = vehicle_twist((0, 0, 0), twist, seconds=10, limits=limits)
    t = 8.0
    stop = vehicle_stop(drive.state(t + response), t + response, limits=limits)
    (x, y), turned = drive.position(t), drive.rotation(t)
    for k in range(60):
        at = t + (stop.end - t) * k / 59
        motion = drive if at < t + response else stop
        pose = affinity.rotate(FOOTPRINT, motion.rotation(at), (0, 0), use_radians=True)
        dx, dy = motion.position(at)
        pose = affinity.translate(pose, dx - x, dy - y)
        yield affinity.rotate(pose, -turned, (0, 0), use_radians=True)


def test_a_narrow_field_is_reported_for_arcs():
    field = FieldSet(name="fast", protective=rectangle(4.0), linear=(0.3, 1.5), theta=(-0.1, 0.8))
    fields = ProtectiveFields(sets=[field], response_time=0.2)
    (short,) = short_fields(fields, FOOTPRINT, VehicleLimits())
    assert short.travel == "ahead on an arc to the left"
    poses = shapely.union_all([*covered_on_arc((1.5, 0.8), 0.2, VehicleLimits())])
    assert short.speed == 1.5
    assert short.missing == pytest.approx(poses.bounds[3] - 0.5, abs=0.002)
    straight = ProtectiveFields(
        sets=[FieldSet(name="fast", protective=rectangle(4.0), linear=(0.3, 1.5), theta=(0, 0))]
    )
    assert short_fields(straight, FOOTPRINT, VehicleLimits()) == ()


@pytest.mark.parametrize("limits", DRIVES)
def test_computed_fields_contain_arcs(limits):
    top = limits.top_speed
    fields = needed_fields(FOOTPRINT, limits, [0.3, top], response_time=0.2, supplements=BARE)
    for ahead in (-0.99, -0.3, 0.2, 0.5, 0.99):
        for turn in (-0.9, -0.3, 0.04, 0.049, 0.5):
            twist = (ahead * limits.speed, turn)
            drive = vehicle_twist((0, 0, 0), twist, seconds=10, limits=limits)
            (span,) = fields.applying(drive, 8.0, 8.0)
            field = Polygon(span.set.protective).buffer(1e-6)
            assert all(map(field.covers, covered_on_arc(twist, 0.2, limits)))


def test_a_field_behind_is_needed_backwards():
    field = FieldSet(name="back", protective=rectangle(1.3, 1.3), linear=(-0.5, -0.1))
    (short,) = short_fields(ProtectiveFields(sets=[field]), FOOTPRINT, AxisLimits(1.0, 0.5))
    assert (short.travel, short.speed) == ("backwards", 0.5)


def test_swept_areas_contain_every_pose():
    for angle in (-2.0, -0.3, 0.5, 3.0):
        area = swept_turn(FOOTPRINT, angle)
        for k in range(50):
            pose = affinity.rotate(FOOTPRINT, angle * k / 49, (0, 0), use_radians=True)
            assert area.buffer(1e-9).covers(pose)
        area = swept_straight(FOOTPRINT, angle, 1.5)
        for k in range(50):
            s = 1.5 * k / 49
            pose = affinity.translate(FOOTPRINT, s * math.cos(angle), s * math.sin(angle))
            assert area.buffer(1e-9).covers(pose)


@pytest.mark.parametrize(
    ("speeds", "keys", "message"),
    [
        ([], {}, "speeds must be positive and rise, not "),
        ([0.5, 0.5], {}, "speeds must be positive and rise, not 0.5, 0.5"),
        ([-1.0], {}, "speeds must be positive and rise, not -1.0"),
        ([1.0], {"response_time": math.nan}, "response_time must be 0 or more, not nan"),
        ([1.0], {"warning_time": -1}, "warning_time must be 0 or more, not -1"),
    ],
)
def test_invalid_values_are_rejected(speeds, keys, message):
    with pytest.raises(UserError) as why:
        needed_fields(FOOTPRINT, VehicleLimits(), speeds, **{"response_time": 0.2, **keys})
    assert str(why.value) == message


def test_negative_supplements_are_rejected():
    with pytest.raises(UserError, match="wear must be 0 or more, not -1"):
        FieldSupplements(wear=-1)


def test_fields_of_a_holonomic_drive_contain_its_fastest_direction():
    limits = VehicleLimits(speed=1.5, side_speed=0.9)
    fields = needed_fields(
        FOOTPRINT, limits, [limits.top_speed], response_time=0.2, supplements=BARE
    )
    angle = math.atan2(0.9, 1.5)
    reach = stopping_reach(
        limits.along(math.cos(angle), math.sin(angle)), limits.top_speed, 0.2
    ).distance
    dx, dy = reach * math.cos(angle), reach * math.sin(angle)
    for each in fields.sets:
        assert Polygon(each.protective).covers(affinity.translate(FOOTPRINT, dx, dy))


def test_velocities_of_earlier_sets_do_not_count():
    ahead = FieldSet(name="ahead", protective=rectangle(4.0), linear=(0.5, 2.0))
    every = FieldSet(name="every", protective=rectangle(2.3))
    behind = FieldSet(name="behind", protective=rectangle(4.0), linear=(-2.0, 0.0))
    speeds = {
        sets: {
            short.speed
            for short in short_fields(ProtectiveFields(sets=sets), FOOTPRINT, VehicleLimits())
            if short.set == "every" and short.travel == "ahead"
        }
        for sets in ((every,), (ahead, every), (every, ahead))
    }
    assert list(speeds.values()) == [{1.5}, set(), {1.5}]
    (part,) = ProtectiveFields(sets=(ahead, behind, every)).remaining("every", (-1.5, 1.5))
    assert part.linear == (0.0, 0.5)


def farthest(limits, speed, response):
    """Return the travel of a machine that accelerates from rest to a speed, and then stops."""
    drive = vehicle_segment((0, 0, 0), (40.0, 0), limits=limits)
    times = [k * 1e-3 for k in range(10_000)]
    t = next(t for t in times if drive.velocity(t)[0] >= speed)
    stop = vehicle_stop(drive.state(t + response), t + response, limits=limits)
    return float(stop.position(stop.end)[0] - drive.position(t)[0])


@pytest.mark.parametrize("speed", [0.0, 0.02, 0.1, 0.4, 1.0])
@pytest.mark.parametrize("response", [0.05, 0.2, 0.6])
def test_the_travel_is_that_of_a_machine_that_accelerates_from_rest(speed, response):
    limits = VehicleLimits(speed=3.0, acceleration=0.7, jerk=1.5)
    reach = stopping_reach(limits.along(1.0, 0.0), speed, response)
    assert reach.distance == pytest.approx(farthest(limits, speed, response), abs=3e-3)


def ways(limits, response):
    """Return times of a drive from rest, its speeds, and its travels if it stops then."""
    drive = vehicle_segment((0, 0, 0), (40.0, 0), limits=limits)
    for k in range(160):
        t = k * 0.03
        stop = vehicle_stop(drive.state(t + response), t + response, limits=limits)
        yield (
            float(drive.velocity(t)[0]),
            float(stop.position(stop.end)[0] - drive.position(t)[0]),
        )


@pytest.mark.parametrize("response", [0.0, 0.1, 0.35, 1.0])
@pytest.mark.parametrize(("acceleration", "jerk"), [(2.0, 0.5), (0.7, 3.0), (0.5, math.inf)])
def test_the_travel_is_the_maximum_over_all_lower_speeds(acceleration, jerk, response):
    limits = VehicleLimits(speed=1.5, acceleration=acceleration, jerk=jerk)
    found = [*ways(limits, response)]
    for speed in (0.3, 0.8, 1.2, 1.4, 1.5):
        reach = stopping_reach(limits.along(1.0, 0.0), speed, response).distance
        farthest = max(way for v, way in found if v <= speed)
        assert farthest <= reach + 1e-9
        assert reach <= farthest + 0.03 * reach + 0.02


def test_a_machine_at_its_top_speed_gets_no_faster_while_it_responds():
    reach = stopping_reach(AxisLimits(1.5, 0.7), 1.5, 0.4)
    assert reach == pytest.approx((1.5 * 0.4, 1.5**2 / 1.4, 0.4 + 1.5 / 0.7))
    assert stopping_reach(AxisLimits(1.5, 0.7), 99.0, 0.4) == reach
    # Braking with a trapezoid of acceleration: v / a + a / j seconds at half the speed.
    smooth = AxisLimits(1.5, 0.7, 1.5)
    assert stopping_reach(smooth, 1.5, 0.0).distance >= 1.5 / 2 * (1.5 / 0.7 + 0.7 / 1.5) - 1e-9
    assert stopping_reach(smooth, 1.5, 0.4).response <= 1.5 * 0.4


@pytest.mark.parametrize("linear", [(0.8, 2.0), (-2.0, -0.8)])
@pytest.mark.parametrize("theta", [(0.0, 0.0), (0.2, 0.6)])
def test_a_set_for_speeds_beyond_the_machine_is_not_reported(linear, theta):
    tiny = FieldSet(name="tiny", protective=rectangle(1.25, 1.25), linear=linear, theta=theta)
    fields = ProtectiveFields(sets=[tiny], response_time=0.2)
    assert short_fields(fields, FOOTPRINT, VehicleLimits(speed=0.5, turn_speed=1.0)) == ()
    assert short_fields(fields, FOOTPRINT, VehicleLimits(speed=0.9, turn_speed=1.0))


def test_a_set_of_directions_for_speeds_beyond_the_machine_is_not_reported():
    limits = VehicleLimits(speed=0.5, side_speed=0.5)
    keys = {"protective": rectangle(1.25, 1.25), "direction": (-0.3, 0.3)}
    fields = [
        ProtectiveFields(sets=[FieldSet(name="tiny", linear=linear, theta=(0, 0.5), **keys)])
        for linear in ((0.8, 2.0), (0.4, 2.0))
    ]
    assert [bool(short_fields(each, FOOTPRINT, limits)) for each in fields] == [False, True]


def test_a_field_beside_a_holonomic_machine_must_be_long_enough():
    limits = VehicleLimits(side_speed=0.8)
    reach = stopping_reach(limits.along(0.0, 1.0), 0.8, 0.2).distance
    # Wide enough on the left, and 0.3 m short on the right.
    right, left = 0.4 + reach - 0.3, 0.4 + reach + 0.01
    wide = ((-9, -right), (9, -right), (9, left), (-9, left))
    sets = [FieldSet(name="wide", protective=wide, linear=(0.1, 2.0), theta=(0, 0))]
    (short,) = short_fields(ProtectiveFields(sets=sets, response_time=0.2), FOOTPRINT, limits)
    assert (short.travel, short.speed) == ("sideways", 0.8)
    assert short.missing == pytest.approx(0.3, abs=1e-4)
    assert short.reach == pytest.approx(reach)
    sets = [FieldSet(name="all", protective=wide, linear=(0.1, 2.0), theta=(0, 0))]
    assert short_fields(ProtectiveFields(sets=sets, response_time=0.2), FOOTPRINT, DRIVES[0]) == ()


def test_a_field_in_a_direction_of_travel_must_be_long_enough():
    limits = VehicleLimits(speed=1.0, side_speed=1.0)
    reach = stopping_reach(limits.along(0.0, 1.0), 0.6, 0.0).distance
    field = ((-9, -9), (9, -9), (9, 0.4 + reach - 0.2), (-9, 0.4 + reach - 0.2))
    sideways = (math.pi / 4, 3 * math.pi / 4)
    sets = [FieldSet(name="left", protective=field, linear=(0.3, 0.6), direction=sideways)]
    sets = [replace(one, theta=(0, 0)) for one in sets]
    shorts = short_fields(ProtectiveFields(sets=sets), FOOTPRINT, limits)
    worst = max(shorts, key=lambda one: one.missing)
    assert worst.travel == "sideways" and worst.speed == 0.6
    assert worst.missing == pytest.approx(0.2, abs=1e-3)


def test_turning_counts_at_rest_only_and_no_faster_than_the_machine_turns():
    slim = rectangle(9.0, 9.0)
    rest = FieldSet(name="rest", protective=slim, linear=(-0.1, 0.1), theta=(-5.0, 5.0))
    limits = VehicleLimits(turn_speed=0.7)
    shorts = short_fields(ProtectiveFields(sets=[rest], response_time=0.1), FOOTPRINT, limits)
    turns = {one.travel: one for one in shorts if one.travel.startswith("turning")}
    assert set(turns) == {"turning left", "turning right"}
    for one in turns.values():
        assert one.speed == 0.7 and "rad/s" in str(one)
        assert one.reach == pytest.approx(stopping_reach(limits.turning, 0.7, 0.1).distance)
    moving = FieldSet(name="moving", protective=slim, linear=(0.01, 0.1), theta=(-5.0, 5.0))
    shorts = short_fields(ProtectiveFields(sets=[moving], response_time=0.1), FOOTPRINT, limits)
    assert not [one for one in shorts if one.travel.startswith("turning")]


def test_a_narrow_field_is_reported_for_arcs_backwards():
    field = FieldSet(
        name="back", protective=rectangle(1.3, 5.0), linear=(-1.5, -0.3), theta=(-0.8, 0.1)
    )
    fields = ProtectiveFields(sets=[field], response_time=0.2)
    (short,) = short_fields(fields, FOOTPRINT, VehicleLimits())
    assert short.travel == "backwards on an arc to the right"
    poses = shapely.union_all([*covered_on_arc((-1.5, -0.8), 0.2, VehicleLimits())])
    assert short.missing == pytest.approx(max(poses.bounds[3], -poses.bounds[1]) - 0.5, abs=0.002)
    # Braking with a trapezoid of acceleration: v / a + a / j seconds at half the speed.
    braking = 1.5 / 2 * (1.5 / 0.7 + 0.7 / 3.0)
    assert short.reach == pytest.approx(1.5 * 0.2 + braking, rel=0.01)


@pytest.mark.parametrize("angle", [0.0, 0.4, -2.0, 6.0])
def test_the_area_of_a_turn_barely_exceeds_that_of_all_poses(angle):
    poses = [
        affinity.rotate(FOOTPRINT, angle * k / 500, (0, 0), use_radians=True) for k in range(501)
    ]
    area = swept_turn(FOOTPRINT, angle)
    assert area.within(shapely.union_all(poses).buffer(0.02))


def test_the_area_of_a_drive_is_exact_for_a_concave_footprint():
    hook = Polygon([(0, 0), (2, 0), (2, 2), (1.5, 2), (1.5, 0.5), (0, 0.5)])
    poses = [affinity.translate(hook, 0.0, 3.0 * k / 3000) for k in range(3001)]
    area = swept_straight(hook, math.pi / 2, 3.0)
    assert area.symmetric_difference(shapely.union_all(poses)).area < 1e-2
    assert area.area == pytest.approx(0.5 * 5.0 + 1.5 * 3.5)


def test_directions_are_close_together_and_contain_the_ends_and_the_axes():
    found = directions(VehicleLimits(), -1.0, 2.0)
    assert found == sorted(found) and {-1.0, 0.0, math.pi / 2, 2.0} <= set(found)
    assert max(b - a for a, b in itertools.pairwise(found)) <= STEP + 1e-12
    for limits in (VehicleLimits(), AxisLimits(1.0, 1.0)):
        assert main_directions(limits, -1.0, 2.0) == {0.0, math.pi / 2}
        assert main_directions(limits, 0.1, 0.2) == set()
    aslant = math.atan2(0.5, 1.5)
    holonomic = main_directions(VehicleLimits(side_speed=0.5), -1.0, 2.0)
    assert sorted(holonomic) == pytest.approx([-aslant, 0.0, aslant, math.pi / 2])


def test_a_machine_on_rails_needs_no_field_at_its_sides():
    tiny = FieldSet(
        name="side", protective=rectangle(1.25, 1.25), direction=(1.0, 2.0), linear=(0, 2)
    )
    assert short_fields(ProtectiveFields(sets=[tiny]), FOOTPRINT, AxisLimits(1.0, 0.5)) == ()
