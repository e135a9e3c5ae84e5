"""Drives of vehicles: obstacles of routes, evasion, and slow zones."""

import math
import textwrap

import numpy as np
import pytest
import shapely
from run_events import events
from shapely.geometry import box

import floorplan
import navigation
import sim
from navigation import PlanningError, VehicleLimits
from sim.core.body import TRAFFIC
from sim.machines.amr.drive import floor_of
from sim.machines.amr.shape import Chassis
from sim.machines.amr.slow_zones import SlowZones

HALL = """
name: hall
boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
stations: {east: [18, 5]}
"""

CORRIDOR = """
name: corridor
boundary: [[0, 0], [20, 0], [20, 1.6], [0, 1.6]]
stations: {east: [18, 0.8]}
"""

CHASSIS = Chassis(footprint=box(-0.6, -0.4, 0.6, 0.4), top=0.5, limits=VehicleLimits())


def started(machines, floor=HALL, more="", t=0.0):
    """Return a simulation of vehicles on a floor, at a time."""
    listed = "".join(f"  {name}: {{kind: amr, {keys}}}\n" for name, keys in machines.items())
    shown = textwrap.indent(floor, "  ")
    text = f"floorplan:\n{shown}\nduration: 120\nrules: observe\n{more}machines:\n{listed}"
    simulation = sim.Simulation(sim.Trial.parse(text))
    simulation.start()
    simulation.advance(t)
    return simulation


def in_hall(t=0.0, at="[3, 5, 0.0]", keys="missions: [{go: east}]", **more):
    """Return a vehicle in a hall at a time, and its simulation."""
    simulation = started({"cart": f"at: {at}, {keys}"}, t=t, **more)
    return simulation.machines["cart"], simulation


def covered(vehicle, motion, begin=None):
    """Return the area that a vehicle covers on a motion."""
    times = np.linspace(motion.start if begin is None else begin, motion.end, 300)
    states = [motion.state(float(t)) for t in times]
    return shapely.union_all([vehicle.shape.footprint(one.at, one.position[2]) for one in states])


# Obstacles of routes.


def test_gates_and_zones_apply_only_to_the_vehicles_that_they_concern():
    plan = floorplan.parse(
        HALL
        + textwrap.dedent("""
        zones:
          mine: {polygon: [[5, 0], [6, 0], [6, 1], [5, 1]], forbidden: true, concerns: [cart]}
          all: {polygon: [[5, 2], [6, 2], [6, 3], [5, 3]], forbidden: true}
          other: {polygon: [[5, 4], [6, 4], [6, 5], [5, 5]], forbidden: true, concerns: [ann]}
          slow: {polygon: [[5, 6], [6, 6], [6, 7], [5, 7]], max_speed: 0.4}
        gates:
          all_gate: {between: [[8, 0], [8, 10]], towards: [9, 2]}
          my_gate: {between: [[10, 0], [10, 10]], towards: [11, 5], concerns: [cart]}
          other_gate: {between: [[12, 0], [12, 10]], towards: [13, 8], concerns: [ann]}
        """)
    )
    world = floor_of(CHASSIS, "cart", plan)
    assert {body.name for body in world.bodies} == {"mine", "all"}
    back = [world.gates.allow((x + 0.5, 5.0), (x - 0.5, 5.0)) for x in (8.0, 10.0, 12.0)]
    assert back == [False, False, True]
    assert world.gates.allow((7.5, 2.0), (13.5, 2.0))
    elsewhere = floor_of(CHASSIS, "fork", plan)
    assert {body.name for body in elsewhere.bodies} == {"all"}
    assert elsewhere.gates.allow((10.5, 5.0), (9.5, 5.0))


def test_a_vehicle_drives_through_a_zone_that_is_forbidden_to_others():
    zone = "zones: {z: {polygon: [[9, 0], [11, 0], [11, 7], [9, 7]], forbidden: true%s}}\n"
    straight, around = (
        in_hall(floor=HALL + zone % whom)[0].preview(18.0, 5.0)
        for whom in (", concerns: [ann]", "")
    )
    area = box(9, 0, 11, 7)
    vehicle, _ = in_hall()
    assert covered(vehicle, straight).intersects(area)
    assert not covered(vehicle, around).intersects(area)


def test_people_are_avoided_only_if_there_is_room():
    vehicle, _ = in_hall(1.0)
    assert vehicle.avoid({"ann": (10.0, 5.0)}, 0.5)
    radius = 0.5 + vehicle._stage.floorplan.human.radius
    motion = vehicle.preview(18.0, 5.0)
    assert covered(vehicle, motion).distance(shapely.Point(10.0, 5.0)) >= radius
    assert not vehicle.avoid({"ann": (10.0, 9.5)}, 0.1)
    simulation = started({"cart": "at: [2, 0.8, 0.0], controller: parked"}, CORRIDOR)
    vehicle = simulation.machines["cart"]
    vehicle.avoid({"ann": (10.0, 0.8)}, 0.3)
    motion = vehicle.preview(18.0, 0.8)
    assert motion.position(motion.end) == pytest.approx((18.0, 0.8))


def test_a_person_close_by_does_not_block_the_start():
    vehicle, _ = in_hall()
    vehicle.avoid({"ann": (3.9, 5.0), "bob": (3.0, 5.0)}, 0.5)
    motion = vehicle.preview(18.0, 5.0)
    area = covered(vehicle, motion)
    assert area.distance(shapely.Point(3.9, 5.0)) > 0.25
    assert motion.position(motion.end) == pytest.approx((18.0, 5.0))


def test_a_route_avoids_stationary_vehicles_and_no_moving_ones():
    machines = {
        "cart": "at: [3, 5, 0.0], controller: parked",
        "stands": "at: [10, 5, 1.57], controller: parked",
        "drives": "at: [14, 1, 1.57], missions: [{go: [14, 9]}]",
    }
    simulation = started(machines, t=2.0)
    vehicle = simulation.machines["cart"]
    area = covered(vehicle, vehicle.preview(18.0, 5.0))
    parked, driving = (simulation.machines[name] for name in ("stands", "drives"))
    assert not area.intersects(parked.shape.footprint((10.0, 5.0), 1.57))
    assert driving.body.motion.end > 2.0
    assert sorted(body.name for body in vehicle._drive.world.bodies) == ["stands"]
    simulation.advance(30.0)
    vehicle.preview(17.0, 4.0)
    assert sorted(body.name for body in vehicle._drive.world.bodies) == ["drives", "stands"]


def test_a_route_avoids_no_vehicle_that_waits_in_traffic():
    machines = {
        "cart": "at: [3, 5, 0.0], controller: parked",
        "waits": "at: [10, 5, 1.57], controller: parked",
    }
    simulation = started(machines, t=1.0)
    vehicle, other = (simulation.machines[name] for name in machines)
    for waits in (True, False):
        other.stand_for(TRAFFIC, waits)
        vehicle.preview(18.0, 5.0 if waits else 5.1)
        placed = [body.name for body in vehicle._drive.world.bodies]
        assert placed == ([] if waits else ["waits"])


def test_a_vehicle_that_may_leave_is_no_permanent_obstacle():
    machines = {
        "cart": "at: [2, 0.8, 0.0], missions: [{go: east}]",
        "idle": "at: [8, 0.8, 0.0], controller: parked",
    }
    vehicle = started(machines, CORRIDOR).machines["cart"]
    with pytest.raises(PlanningError):
        vehicle.preview(18.0, 0.8)
    machines["idle"] = "at: [8, 0.8, 0.0]"
    vehicle = started(machines, CORRIDOR).machines["cart"]
    motion = vehicle.preview(18.0, 0.8)
    assert motion.position(motion.end) == pytest.approx((18.0, 0.8))


def test_an_obstacle_on_the_route_makes_a_vehicle_brake_and_drive_around_it():
    pallet = "obstacles: {p: {x: [12, 12.5], y: [4, 6], z: [0, 1], there: [[5.0, 90.0]]}}\n"
    vehicle, simulation = in_hall(4.9, more=pallet)
    straight = vehicle.body.motion
    simulation.advance(60.0)
    run = simulation.finish()
    assert run.motions["cart"].position(60.0) == pytest.approx(straight.position(straight.end))
    assert not covered(vehicle, run.motions["cart"]).intersects(box(12, 4, 12.5, 6))
    beside = pallet.replace("[4, 6]", "[8, 9]")
    vehicle, simulation = in_hall(4.9, more=beside)
    straight = vehicle.body.motion
    simulation.advance(6.0)
    assert vehicle.body.motion is straight


def test_a_held_vehicle_stays_when_an_obstacle_comes_on_its_route():
    more = (
        "commands: [{time: 6.0, hold: cart}]\n"
        "obstacles: {p: {x: [12.8, 13.3], y: [4, 6], z: [0, 1], there: [[6.5, 90.0]]}}\n"
    )
    vehicle, simulation = in_hall(6.2, more=more)
    assert vehicle.body.motion.end > 6.6
    stands = vehicle.body.motion.position(99.0)
    simulation.advance(40.0)
    assert vehicle.body.at == pytest.approx(tuple(stands)) and vehicle.disabled


def test_a_blocked_vehicle_plans_again_every_two_seconds():
    machines = {"cart": "at: [2, 0.8, 0.0], missions: [{go: east}]"}
    wall = "obstacles: {w: {x: [9, 9.2], y: [0, 1.6], z: [0, 1], there: [[0.0, 5.0]]}}\n"
    simulation = started(machines, CORRIDOR, wall, 60.0)
    run = simulation.finish()
    (blocked,) = events(run, "machine_blocked")
    (done,) = events(run, "job_done")
    assert blocked["t"] == 0.0
    moves = next(piece.begin for piece in run.motions["cart"].pieces if piece.moves)
    assert moves == pytest.approx(5.0, abs=1e-6) and done["t"] > moves


# Evading.


def test_a_detour_leads_around_taken_areas_and_is_no_longer_than_allowed():
    vehicle, simulation = in_hall(2.0)
    wall = box(9.0, 2.0, 11.0, 10.0)
    vehicle.stand_for("test", True)
    simulation.advance(6.0)
    direct = vehicle._drive.seconds([vehicle.position, (18.0, 5.0, 0.0)])
    assert not vehicle.detour([wall], 0.5)
    assert not vehicle.detour([box(9.0, 0.0, 11.0, 10.0)], math.inf)
    assert vehicle.detour([wall], 60.0)
    assert vehicle.goal == (18.0, 5.0)
    vehicle.stand_for("test", False)
    simulation.advance(6.01)
    motion = vehicle.body.motion
    assert not covered(vehicle, motion, 6.0).intersects(wall)
    assert motion.end - 6.0 > direct
    assert motion.position(motion.end) == pytest.approx((18.0, 5.0))


def test_a_vehicle_evades_to_a_place_off_the_courses_of_others():
    vehicle, simulation = in_hall(2.0)
    vehicle.stand_for("test", True)
    simulation.advance(6.0)
    x, y, _rotation = vehicle.position
    wall = [box(9.0, 0.0, 9.5, 10.0)]
    for courses in ([], [box(0.0, 3.0, 20.0, 7.0)], [box(0.0, 2.0, 20.0, 10.0)]):
        evasion = vehicle.evade(wall, courses)
        place = vehicle.shape.footprint(evasion.aside[:2], evasion.aside[2])
        assert not place.intersects(shapely.union_all([*wall, *courses]))
        assert math.dist(evasion.aside[:2], (x, y)) > 0.4
    vehicle.stand_for("test", False)
    simulation.advance(6.01)
    motion = vehicle.body.motion
    assert motion.position(motion.end) == pytest.approx((18.0, 5.0))
    assert covered(vehicle, motion, 6.0).distance(shapely.Point(evasion.aside[:2])) < 1e-6


def test_a_vehicle_evades_by_another_path_if_that_is_not_much_longer():
    vehicle, simulation = in_hall(2.0)
    vehicle.stand_for("test", True)
    simulation.advance(6.0)
    assert vehicle.evade([box(9.0, 3.0, 11.0, 7.0)], []).aside is None
    assert vehicle.evade([box(0.0, 0.0, 20.0, 10.0)], []) is None
    idle, _ = in_hall(2.0, keys="controller: parked")
    assert idle.evade([], []) is None


def test_only_a_vehicle_without_missions_makes_way():
    courses = [box(0.0, 4.0, 20.0, 6.0)]
    busy, _ = in_hall(1.0)
    assert not busy.make_way([], courses)
    parked, _ = in_hall(1.0, keys="controller: parked")
    assert not parked.make_way([], courses)
    stopped, _ = in_hall(1.0, keys="missions: []", more="commands: [{time: 0.5, hold: cart}]\n")
    assert not stopped.make_way([], courses)
    idle, simulation = in_hall(1.0, keys="missions: []")
    assert idle.may_leave and not parked.may_leave
    assert not idle.make_way([box(1.0, 3.0, 2.3, 7.0)], [box(0.0, 0.0, 20.0, 10.0)])
    assert idle.make_way([], courses)
    simulation.advance(20.0)
    assert not idle.shape.footprint(idle.body.at, idle.position[2]).intersects(courses[0])


def test_a_vehicle_that_has_completed_its_missions_makes_way():
    idle, _simulation = in_hall(20.0)
    assert idle.jobs_done == 1 and idle.make_way([], [box(16.0, 4.0, 20.0, 6.0)])


# Commands.


def test_the_velocity_of_a_vehicle_is_in_its_own_frame():
    vehicle, simulation = in_hall(keys="controller: parked, drive: holonomic", at="[3, 5, 0.7]")
    vehicle.twist((0.4, 0.2, 0.3), 5.0)
    simulation.advance(4.0)
    assert vehicle.twist_now == pytest.approx((0.4, 0.2, 0.3), abs=1e-3)


def test_a_limit_of_the_speed_slows_a_twist_on_its_arc():
    vehicle, _ = in_hall(keys="controller: parked, drive: holonomic")
    slow = vehicle._drive.slowed
    twist = navigation.vehicles.Twist(0.6, 0.8, 0.5)
    assert slow(twist) == twist
    vehicle.limit_speed(0.5)
    assert slow(twist) == pytest.approx((0.3, 0.4, 0.25))
    assert slow(navigation.vehicles.Twist(0.0, 0.0, 0.5)) == (0.0, 0.0, 0.5)
    assert slow(navigation.vehicles.Twist(0.3, 0.0, 0.5)) == (0.3, 0.0, 0.5)


def test_a_new_target_on_the_way_stops_first_and_the_same_one_drives_on():
    vehicle, simulation = in_hall(keys="controller: parked")
    vehicle.move_to(18.0, 5.0)
    simulation.advance(4.0)
    speed = vehicle.state.speed
    vehicle.move_to(18.0, 5.0)
    assert vehicle.body.motion.velocity(4.0)[0] == pytest.approx(speed)
    rest = vehicle.body.motion
    times = np.linspace(4.0, rest.end - 2.5, 50)
    assert rest.velocity(times)[:, 0].min() >= speed - 1e-6
    vehicle.move_to(10.0, 9.0)
    motion = vehicle.body.motion
    assert motion.position(motion.end) == pytest.approx((10.0, 9.0))
    assert np.abs(motion.position(np.linspace(4.0, 5.0, 20))[:, 1] - 5.0).max() < 1e-9


def test_a_preview_equals_the_move_and_moves_nothing():
    vehicle, simulation = in_hall(keys="controller: parked")
    vehicle.move_to(18.0, 5.0, 1.0)
    simulation.advance(3.0)
    before = vehicle.body.motion
    for target in ((18.0, 5.0, 1.0), (12.0, 8.0), (3.0, 2.0, 0.5)):
        preview = vehicle.preview(*target, speed_share=0.7)
        assert vehicle.body.motion is before
        assert preview.start == 3.0 and preview.state(3.0).position == pytest.approx(
            before.state(3.0).position
        )
    vehicle.move_to(12.0, 8.0, speed_share=0.7)
    motion = vehicle.body.motion
    assert motion.position(motion.end) == pytest.approx((12.0, 8.0))
    assert np.hypot(*motion.velocity(np.linspace(9.0, motion.end, 200)).T).max() <= 0.7 * 1.5 + 1e-9


def test_a_vehicle_is_at_a_place_only_when_it_rests_there():
    vehicle, _simulation = in_hall(keys="controller: parked")
    assert vehicle._drive.is_at((3.0, 5.0)) and vehicle._drive.is_at((3.0, 5.0, math.tau))
    assert not vehicle._drive.is_at((3.0, 5.0, 0.1)) and not vehicle._drive.is_at((3.001, 5.0))
    vehicle.move_to(18.0, 5.0)
    assert not vehicle._drive.is_at((3.0, 5.0))


# Slow zones.

SHAPE = CHASSIS.shape("cart")


def slow_drive(zones, begin, to, limits=CHASSIS.limits, rotation=0.0):
    """Return the motion from rest through slow zones, and its slow areas with their speeds."""
    made = [
        floorplan.Zone(name=f"z{k}", area=area, max_speed=speed)
        for k, (area, speed) in enumerate(zones)
    ]
    slow = SlowZones(made, SHAPE)
    return slow.path((*begin, rotation), [(*to, rotation)], 0.0, limits)


def check_limits(motion, zones, limits=CHASSIS.limits):
    """Compare a motion with the limits of zones and of the vehicle, by samples and pieces."""
    times = np.arange(0.0, motion.end, 0.01)
    speed = np.hypot(*motion.velocity(times).T)
    for t, v in zip(times.tolist(), speed.tolist(), strict=True):
        state = motion.state(t)
        here = SHAPE.footprint(state.at, state.position[2]).buffer(-1e-4)
        for area, most in zones:
            assert v <= most + 1e-6 or not here.intersects(area), (t, v)
    for piece in motion.pieces:
        c, s = math.cos(piece.rotation[0]), math.sin(piece.rotation[0])
        for u in (0.0, piece.end - piece.begin):
            for way, top in (((c, s), limits.speed), ((-s, c), limits.side_speed)):
                _, v, a, j = (
                    way[0] * x + way[1] * y for x, y in zip(piece.x, piece.y, strict=True)
                )
                assert abs(v + 2 * a * u + 3 * j * u * u) <= top + 1e-6
                assert abs(2 * a + 6 * j * u) <= limits.acceleration + 1e-6
                assert abs(6 * j) <= limits.jerk + 1e-6
    along = (motion.position(times) - motion.position(0.0)) @ (
        (motion.position(motion.end) - motion.position(0.0))
        / np.linalg.norm(motion.position(motion.end) - motion.position(0.0))
    )
    assert (np.diff(along) >= -1e-9).all()


CASES = {
    "one": [(box(12, 0, 18, 8), 0.4)],
    "steps down": [(box(12, 0, 12.3, 8), 0.8), (box(12.3, 0, 18, 8), 0.2)],
    "steps up": [(box(12, 0, 15, 8), 0.2), (box(15, 0, 15.3, 8), 0.8)],
    "over each other": [(box(10, 0, 18, 8), 0.9), (box(12, 0, 14, 8), 0.3)],
    "at the start": [(box(0, 0, 6, 8), 0.3)],
    "at the end": [(box(24, 0, 30, 8), 0.3)],
    "thin": [(box(15, 0, 15.01, 8), 0.1)],
    "a corner": [(shapely.Polygon([(15, 3.7), (15.2, 3), (14.8, 3)]), 0.3)],
    "two": [(box(9, 0, 10, 8), 0.5), (box(15, 0, 17, 8), 0.2)],
    "next to each other": [(box(9, 0, 12, 8), 0.4), (box(13.2 + 1e-7, 0, 15, 8), 0.4)],
    "beside": [(box(9, 4.5, 12, 8), 0.4)],
    "faster": [(box(9, 0, 12, 8), 2.5)],
}


@pytest.mark.parametrize("name", CASES)
def test_a_drive_through_slow_zones_keeps_all_limits_and_loses_little_time(name):
    zones = CASES[name]
    motion = slow_drive(zones, (2.0, 4.0), (28.0, 4.0))
    assert motion.position(motion.end) == pytest.approx((28.0, 4.0))
    check_limits(motion, zones)
    # The time at the speeds of the zones, plus braking and acceleration.
    cuts = np.arange(2.0, 28.0, 1e-3) + 5e-4
    top = np.full(len(cuts), 1.5)
    swept = box(0, 3.6, 30, 4.4)
    for area, speed in zones:
        inside = area.intersection(swept)
        if inside.area:
            low, _, high, _ = inside.bounds
            inside = (cuts > low - 0.6) & (cuts < high + 0.6)
            top[inside] = np.minimum(top[inside], speed)
    least = float((1e-3 / top).sum())
    changes = 2 + len({*top.tolist()})
    assert least <= motion.end <= least + 2.5 * changes
    far = [t for t in np.arange(0.0, motion.end, 0.05) if motion.position(t)[0] > 21.0]
    if name != "at the end":
        assert np.hypot(*motion.velocity(far).T).max() == pytest.approx(1.5, abs=1e-6)


def test_zones_without_an_effect_leave_the_usual_drive():
    usual = navigation.vehicle_segment((2.0, 4.0, 0.0), (28.0, 4.0))
    for name in ("beside", "faster"):
        assert slow_drive(CASES[name], (2.0, 4.0), (28.0, 4.0)).pieces == usual.pieces
    there = slow_drive([(box(12, 0, 18, 8), 0.4)], (2.0, 4.0), (11.0, 4.0))
    assert there.end == pytest.approx(navigation.vehicle_segment((2, 4, 0), (11, 4)).end)


@pytest.mark.parametrize("rotation", [0.0, 0.5, math.pi / 2, math.pi])
def test_slow_zones_apply_to_the_footprint_at_any_rotation(rotation):
    limits = VehicleLimits(side_speed=1.2)
    zones = [(box(12, 0, 14, 8), 0.3)]
    motion = slow_drive(zones, (2.0, 4.0), (28.0, 4.5), limits, rotation)
    check_limits(motion, zones, limits)
    assert motion.position(motion.end) == pytest.approx((28.0, 4.5))


def test_only_zones_with_a_limit_for_the_vehicle_count():
    area = box(12, 0, 18, 8)
    zones = [
        floorplan.Zone(name="a", area=area, max_speed=0.4),
        floorplan.Zone(name="b", area=area, max_speed=0.4, concerns=("ann",)),
        floorplan.Zone(name="c", area=area, max_speed=0.2, concerns=("cart",)),
        floorplan.Zone(name="d", area=area, forbidden=True),
    ]
    assert [speed for _, speed in SlowZones(zones, SHAPE).areas] == [0.4, 0.2]


def test_a_vehicle_under_way_slows_down_before_a_zone_or_as_soon_as_it_can():
    zones = [floorplan.Zone(name="z", area=box(12, 0, 18, 8), max_speed=0.4)]
    slow = SlowZones(zones, SHAPE)
    usual = navigation.vehicle_segment((2.0, 4.0, 0.0), (28.0, 4.0))
    for t, before in ((4.0, True), (8.2, False)):
        state = usual.state(t)
        motion = slow.path(state, [(28.0, 4.0, 0.0)], t, CHASSIS.limits)
        assert motion.velocity(t)[0] == pytest.approx(1.5)
        assert motion.position(motion.end) == pytest.approx((28.0, 4.0))
        times = np.arange(t, motion.end, 0.01)
        x, v = motion.position(times)[:, 0], motion.velocity(times)[:, 0]
        assert v.min() >= -1e-6
        inside = (x > 11.4) & (x < 18.6) if before else (x > 15.0) & (x < 18.6)
        assert v[inside].max() <= 0.4 + 1e-6
