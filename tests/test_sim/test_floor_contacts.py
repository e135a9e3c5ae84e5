"""Contacts of machines with the floor and with people, at the time they happen."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from run_events import events
from shapely import affinity

import floorplan
import navigation
import sim

FLOOR = """
boundary: [[0, 0], [16, 0], [16, 12], [0, 12]]
safe_zone: {at: [1, 1]}
obstacles: {rack: {x: [8, 9], y: [1, 5], z: [%s, 3]}}
gantry:
  x: {range: [1, 15], max_speed: 0.8, max_acceleration: 0.5, max_jerk: 2.0}
  y: {range: [1, 11], max_speed: 0.8, max_acceleration: 0.5, max_jerk: 2.0}
  start: [3.0, 10.0, 0.0]
  torso: {size: [0.8, 0.8], z: [1.9, 3.4]}
  arm: {mount: [0.3, 2.2], reach: 0.7, bottom: 1.3}
  rail_height: 3.6
  tray_height: 1.4
agvs:
  size: [1.2, 0.8]
  height: 0.5
  max_speed: 1.0
  max_acceleration: 0.5
  limits: [0, 12]
  locations: {start: 0, end: 12}
  start: start
  lanes: {agv: {origin: [2, 8]}}
"""
CONTROLLERS = """
import math
import random

import navigation
import simpy


def ahead(vehicle):
    yield vehicle.twist((0.8, 0.0), 30.0)


def backwards(vehicle):
    yield vehicle.twist((-0.8, 0.0), 30.0)


def turning(vehicle):
    yield vehicle.twist((0.0, 0.5), 20.0)


def again_and_again(vehicle):
    for _ in range(3):
        yield vehicle.twist((0.8, 0.0), 9.0)
        yield vehicle.twist((-0.8, 0.0), 1.0)


def pushing(vehicle):
    return (0.8, 0.0)


def sliding(vehicle):
    yield vehicle.twist((0.0, -0.5, 0.0), 8.0)
    for _ in range(20):
        yield vehicle.twist((0.5, 0.0, 0.0), 0.5)


def previewed(vehicle):
    yield vehicle.follow(vehicle.preview(12.0, 3.0))


def interrupted(vehicle):
    vehicle.interrupt_on("contact")
    try:
        yield vehicle.twist((0.8, 0.0), 30.0)
    except simpy.Interrupt as why:
        assert why.cause == "contact"
        yield vehicle.twist((-0.8, 0.0), 2.0)


def through(gantry):
    yield gantry.move_to(3.0, 3.0)
    yield gantry.follow(navigation.gantry_move(gantry.state, (13.0, 3.0, 1.0), gantry.now))
    yield gantry.move_to(3.0, 3.0)


def erratic(vehicle):
    draw = random.Random(f"{vehicle.name} {vehicle.now:.3f}").uniform
    return draw(-0.8, 1.2), draw(-0.6, 0.6), draw(-0.9, 0.9)
"""
HOOK = ((-0.1, -0.2), (1, -0.2), (1, 0.2), (0.3, 0.2), (0.3, 0.9), (-0.1, 0.9))
KEYS = {"kind": "amr", "at": (3.0, 3.0, 0.0)}


@pytest.fixture
def drive(tmp_path):
    """Run a vehicle with one of the controllers, on a floor with a rack above a height."""
    (tmp_path / "contact_controllers.py").write_text(CONTROLLERS)

    def run(controller, *, rack=0, trial="", gantry="parked", **keys):
        entry = {**KEYS, "controller": f"contact_controllers:{controller}", **keys}
        if controller in ("parked", "oblivious"):
            entry["controller"] = controller
        listed = ", ".join(f"{key}: {_in_yaml(value)}" for key, value in entry.items())
        floor = "\n".join("  " + line for line in (FLOOR % rack).splitlines())
        path = tmp_path / "wall.trial.yaml"
        path.write_text(
            f"floorplan:{floor}\nduration: 30\nrules: observe\ngantry: {{controller: {gantry}}}\n"
            f"{trial}\nmachines:\n  amr: {{{listed}}}\n"
        )
        return sim.run(sim.Trial.load(path))

    return run


def _in_yaml(value):
    return str(
        [*map(list, value)]
        if isinstance(value, tuple) and isinstance(value[0], tuple)
        else [*value]
        if isinstance(value, tuple)
        else value
    )


def test_a_vehicle_stops_before_a_rack(drive):
    run = drive("ahead")
    (contact,) = events(run, "contact")
    motion = run.motions["amr"]
    assert (contact["machine"], contact["with"], contact["speed"]) == ("amr", "rack", 0.8)
    assert contact["at"] == pytest.approx([8.0, 3.4], abs=1e-5)
    assert motion.state(30.0).position == pytest.approx((7.4, 3.0, 0.0), abs=2e-6)
    assert motion.state_before(contact["t"]).speed == pytest.approx(0.8)
    assert motion.state(contact["t"] + 1e-6).speed == 0.0
    assert run.summary["contacts_with_floor"] == 1


def test_a_vehicle_that_only_reports_continues_through_the_rack_and_out_of_the_hall(drive):
    run = drive("ahead", on_contact="report")
    assert [event["with"] for event in events(run, "contact")] == ["rack", "boundary"]
    assert run.motions["amr"].state(30.0).at[0] > 20.0


def test_a_vehicle_passes_below_a_rack_only_without_a_high_load(drive):
    """A vehicle passes below a rack, but not with a load on top."""
    below = drive("ahead", rack=0.4)
    assert [event["with"] for event in events(below, "contact")] == ["boundary"]
    loaded = drive("ahead", rack=0.4, load=(1.0, 0.6, 0.5))
    assert [event["with"] for event in events(loaded, "contact")] == ["rack"]


def test_a_vehicle_can_leave_what_it_has_touched_and_touch_it_again(drive):
    run = drive("again_and_again")
    assert len(events(run, "contact", **{"with": "rack"})) == 3
    x = run.motions["amr"].position(np.linspace(0, 30, 3000))[:, 0]
    assert x.max() < 7.4 + 2e-6


def test_a_vehicle_that_pushes_against_a_rack_stands_still(drive):
    """Its function commands it ten times a second, but leaves no piece of motion behind."""
    run = drive("pushing", rate=10)
    (contact,) = events(run, "contact")
    pieces = run.motions["amr"].pieces_from(contact["t"])
    assert all(piece.stands for piece in pieces if piece.begin >= contact["t"])


def test_a_holonomic_vehicle_slides_along_a_wall(drive):
    run = drive("sliding", drive="holonomic")
    assert len(events(run, "contact")) == 1
    x, y = run.motions["amr"].state(30.0).at
    assert x > 6.0 and y == pytest.approx(0.4, abs=2e-6)


@pytest.mark.parametrize(
    ("controller", "at", "footprint", "end"),
    [
        ("backwards", (12.0, 3.0, 0.0), ((-1.5, -0.4), (0.1, -0.4), (0.1, 0.4), (-1.5, 0.4)), 10.5),
        ("turning", (7.35, 6.0, math.pi / 2), (), None),
        # The corner of the rack is in the notch of the footprint, so within its hull.
        ("ahead", (4.0, 0.5, 0.0), HOOK, 7.7),
    ],
)
def test_contacts_use_the_exact_footprint(drive, controller, at, footprint, end):
    keys = {"footprint": footprint} if footprint else {}
    run = drive(controller, at=at, **keys)
    contacts = events(run, "contact")
    if end is None:
        assert contacts == []
    else:
        assert run.motions["amr"].state(30.0).at[0] == pytest.approx(end, abs=2e-6)


def test_a_vehicle_that_turns_on_the_spot_touches_with_its_corner(drive):
    run = drive("turning", at=(7.45, 3.0, math.pi / 2))
    (contact,) = events(run, "contact")
    reach = math.hypot(0.6, 0.4)
    assert contact["at"][0] == pytest.approx(8.0, abs=1e-5)
    turned = run.motions["amr"].state(30.0).position[2] - math.pi / 2
    assert math.cos(math.atan2(0.6, 0.4) - turned) * reach == pytest.approx(0.55, abs=1e-5)
    assert contact["speed"] == pytest.approx(0.5 * reach, rel=0.05)


def test_planned_motions_touch_no_obstacle(drive):
    run = drive("previewed")
    assert run.summary["contacts_with_floor"] == 0
    assert run.motions["amr"].state(30.0).at == pytest.approx((12.0, 3.0), abs=1e-3)


def test_a_contact_interrupts_a_controller(drive):
    run = drive("interrupted")
    assert len(events(run, "contact")) == 1
    assert run.motions["amr"].state(30.0).at[0] < 7.0


BOX = "obstacles: {{box: {{x: [{}, {}], y: [2, 9], z: [0, 1], there: [[{}, 20]]}}}}"


def test_an_obstacle_stops_a_vehicle_on_which_it_is_put_down(drive):
    """A stationary vehicle may leave the obstacle, and a moving one cannot brake before it."""
    run = drive("parked", trial=BOX.format(3.2, 4.0, 2))
    (contact,) = events(run, "contact")
    assert (contact["t"], contact["with"], contact["speed"]) == (2.0, "box", 0.0)
    trial = BOX.format(4.6, 5.0, 3)
    run = drive("oblivious", trial=trial, missions="[{go: [12, 3, 0]}]")
    (contact,) = events(run, "contact")
    assert 3.0 <= contact["t"] < 3.5 and contact["speed"] > 0.5
    left = drive("again_and_again", trial=BOX.format(3.2, 4.0, 0.5))
    assert events(left, "contact")[0]["t"] == 0.5
    assert left.motions["amr"].position(np.linspace(0, 20, 400))[:, 0].min() < 2.2


def test_only_an_obstacle_that_is_still_there_and_as_low_as_the_vehicle_stops_it(drive):
    gone = BOX.format(4.6, 5.0, 0.5).replace("20", "1")
    run = drive("ahead", trial=gone)
    assert [event["with"] for event in events(run, "contact")] == ["rack"]
    above = BOX.format(4.6, 5.0, 0.5).replace("[0, 1]", "[1.5, 2]")
    run = drive("ahead", trial=above)
    assert [event["with"] for event in events(run, "contact")] == ["rack"]


def test_an_agv_continues_when_its_obstacle_is_removed(drive):
    """The AGV can no longer brake before the box."""
    trial = BOX.format(8.4, 9.0, 6.2) + "\nagvs: {agv: [{time: 0, to: end}]}"
    run = drive("parked", trial=trial)
    (contact,) = events(run, "contact")
    assert contact["machine"] == "agv" and 0.0 < contact["speed"] < 1.0
    assert run.motions["agv"].state(19.0).at[0] == pytest.approx(7.8, abs=2e-6)
    assert run.motions["agv"].state(30.0).at[0] > 12.0


def test_a_gantry_stops_before_an_obstacle_as_high_as_its_torso(drive):
    run = drive("parked", at=(12.0, 10.0, 0.0), gantry="contact_controllers:through")
    (contact,) = events(run, "contact")
    assert (contact["machine"], contact["with"]) == ("gantry", "rack")
    assert run.motions["gantry"].state(30.0).at == pytest.approx((3.0, 3.0), abs=0.5)


def test_a_custom_machine_is_held_where_it_touches_an_obstacle(tmp_path):
    (tmp_path / "carts.py").write_text("""
from dataclasses import dataclass

import floorplan
import navigation
import sim


@dataclass(frozen=True)
class Cart(sim.MachineModel):
    at: tuple[float, float]

    def shape(self, name, plan):
        return sim.MachineShape(
            name=name,
            kind="cart",
            category="vehicle",
            length=1.0,
            width=0.6,
            top=1.0,
            top_speed=1.0,
        )

    def make(self, name, stage):
        return Rolling(self, name, stage)


class Rolling(sim.Machine):
    def __init__(self, model, name, stage):
        self.shape = model.shape(name, stage.floorplan)
        self.body = sim.Body(stage.clock, name, "cart", navigation.standing(model.at))
        self.held = False

    def begin(self):
        (x, y), now = self.body.at, self.body.clock.now
        self.body.follow(navigation.walk([(x, y), (x + 12.0, y)], now, max_speed=1.0))

    def hold(self, stands):
        self.held = stands
""")
    trial = sim.Trial.parse(
        "floorplan:"
        + "\n".join("  " + line for line in (FLOOR % 0).splitlines())
        + "\nduration: 20\nrules: observe\nmachines: {cart: {kind: 'carts:Cart', at: [3, 3]}}\n",
        folder=tmp_path,
    )
    simulation = sim.Simulation(trial)
    simulation.advance(trial.duration)
    cart = simulation.machines["cart"]
    assert cart.held
    assert cart.body.at == pytest.approx((7.5, 3.0), abs=2e-6)
    assert simulation.finish().summary["contacts_with_floor"] == 1


@pytest.mark.parametrize("at", [(3.0, 3.0, 0.0), (12.0, 8.0, 2.0), (5.0, 6.0, -1.0)])
def test_a_vehicle_with_any_twists_never_overlaps_an_obstacle(drive, at):
    run = drive("erratic", rate=5, at=at, drive="holonomic")
    floor = shapely.box(0, 0, 16, 12).difference(shapely.box(8, 1, 9, 5)).buffer(3e-6)
    motion = run.motions["amr"]
    for t in np.arange(0.0, 30.0, 0.02):
        x, y, rotation = motion.state(t).position
        turned = affinity.rotate(
            shapely.box(-0.6, -0.4, 0.6, 0.4), rotation, origin=(0, 0), use_radians=True
        )
        assert floor.covers(affinity.translate(turned, x, y))
    for contact in events(run, "contact"):
        assert motion.state_before(contact["t"]).speed >= 0.0


def test_contacts_with_people_are_events_when_they_happen(drive):
    """The vehicle passes a recorded person who blocks its course without evading."""
    track = navigation.Motion.from_samples(t=[0.0, 30.0], xy=[(6.0, 3.6), (6.0, 3.6)])
    trial = drive("ahead").trial
    people = (sim.PersonEntry("ada", recorded=track),)
    simulation = sim.Simulation(replace(trial, people=people))
    simulation.advance(3.3)
    assert not any(event["kind"] == "contact" for event in simulation.events)
    simulation.advance(3.42)
    (contact,) = (event for event in simulation.events if event["kind"] == "contact")
    assert (contact["person"], contact["machine"]) == ("ada", "amr")
    assert contact["speed"] == pytest.approx(0.8)
    simulation.advance(30.0)
    run = simulation.finish()
    touched = [event for event in events(run, "contact") if "person" in event]
    assert run.summary["contacts"] == len(touched) == 1
    x, _ = run.motions["amr"].state(contact["t"]).at
    aside = 3.6 - 3.4
    radius = trial.floorplan.human.radius
    assert 6.0 - (x + 0.6) == pytest.approx(math.sqrt(radius**2 - aside**2), abs=2e-6)


@pytest.mark.parametrize(("top", "touches"), [(3.0, 1), (1.2, 0)])
def test_a_gantry_touches_obstacles_as_tall_as_its_torso(top, touches):
    plan = sim.Trial.parse("floorplan: ariac2023").floorplan
    footprint = shapely.box(-6.2, -0.2, -5.8, 0.2)
    pillar = floorplan.Obstacle(name="pillar", footprint=footprint, bottom=0.0, top=top)
    plan = replace(plan, obstacles=(*plan.obstacles, pillar))
    moves = (sim.Job("move", target=(-2.0, 0.0, 0.0)),)
    gantry = sim.GantryEntry("oblivious", at=(-9.0, 0.0, 0.0), jobs=moves)
    run = sim.run(sim.Trial(plan, duration=30.0, gantry=gantry))
    assert [event["with"] for event in run.events if event["kind"] == "contact"] == (
        ["pillar"] * touches
    )
    x, _ = run.motions["gantry"].position(30.0)
    torso, _, _, _ = plan.gantry.torso
    assert x == pytest.approx(-6.2 - torso / 2 if touches else -2.0, abs=1e-5)
