"""People wait for moving vehicles, walk around them, and step out of their way."""

import math
from dataclasses import dataclass

import pytest
import shapely
import shapely.affinity
from run_events import events, first

import floorplan
import navigation
import sim
from navigation import Box, Cylinder, Shapes, minimum_separation
from sim.machines.kinds import machines_on, may_be
from sim.people import walker
from sim.people.crowd import vehicles
from sim.people.crowd.vehicles import cover

TRIAL = """
floorplan: ariac2023
duration: 40.0
rules: observe
people:
- {name: ada, personality: cross.asl, at: [-11.3, 6.0], start: {time: %s}}
%s
agvs: {agv1: [{time: %s, to: 12.0}]}
"""
OTHER = "- {name: bob, personality: rest.asl, at: [-14.0, 9.0], start: {time: 0.0}}"


def crossing(folder, start, drives=0.0, other=""):
    (folder / "cross.asl").write_text("+human_start <- move(-11.3, 3.5, 0).\n")
    (folder / "rest.asl").write_text("+human_start <- true.\n")
    return sim.run(sim.Trial.parse(TRIAL % (start, other, drives), folder=folder))


def arrival(run):
    (arrived,) = [event["t"] for event in run.events if event["kind"] == "arrived"]
    return arrived


@pytest.mark.parametrize("other", ["", OTHER])
@pytest.mark.parametrize(("start", "drives"), [(3.0, 0.0), (4.0, 0.0), (1.5, 2.0), (4.0, 4.2)])
def test_people_do_not_step_into_a_lane_before_an_agv(start, drives, other, tmp_path, monkeypatch):
    run = crossing(tmp_path, start, drives, other)
    assert "path_blocked" not in {event["kind"] for event in run.events}
    plan = run.trial.floorplan
    shapes = Shapes(
        person=Cylinder(radius=plan.human.radius, top=plan.human.height),
        machine=(Box.of_agv(plan.lane("agv1")),),
    )
    apart = minimum_separation(run.motions["ada"], run.motions["agv1"], 0.0, 40.0, shapes=shapes)
    assert apart[1] >= vehicles.TOUCH - 1e-6
    # People who start at once stop on the way, and arrive later.
    monkeypatch.setattr(walker, "among_vehicles", lambda *_: None)
    assert arrival(crossing(tmp_path, start, drives, other)) >= arrival(run) - 1e-9


HEAD_ON = """
floorplan:
  boundary: [[0, -2], [26, -2], [26, 2], [0, 2]]
  stations: {west: [1.0, 0.0]}
duration: 30
rules: observe
people: [{name: ada, personality: west.asl, at: [%s, %s]}]
machines:
  bot: {kind: agv, origin: [6.0, 0.0], limits: [0, 18], size: [1.2, 0.7], height: 0.4,
        max_speed: 1.0, max_acceleration: 0.6, locations: {a: 0}, start: a, %s}
"""
MOVES = "moves: [{time: 0, to: 18.0}]"
LATER = "moves: [{time: 1.5, to: 18.0}]"
HELD = MOVES + "}\ncommands: [{time: 0.0, hold: bot}, {time: 3.0, release: bot}]\nobstacles: {"


@pytest.mark.parametrize("goes", [MOVES, LATER, HELD])
@pytest.mark.parametrize(
    "at", [(18.0, 0.0), (13.3, 0.1), (16.5, -0.4), (12.3, 0.57), (22.7, 0.56), (18.0, -0.2)]
)
def test_a_single_person_avoids_an_oncoming_vehicle(at, goes, tmp_path):
    """A single person walks around a vehicle, whether its start is planned or occurs meanwhile."""
    (tmp_path / "west.asl").write_text("+human_start <- move(1, 0, 0).\n")
    run = sim.run(sim.Trial.parse(HEAD_ON % (*at, goes), folder=tmp_path))
    assert run.motions["bot"].state(30.0).at[0] > 23.9
    shapes = Shapes(person=Cylinder(radius=0.3, top=1.8), machine=(run.scene.machine("bot").box,))
    pair = (run.motions["ada"], run.motions["bot"])
    assert minimum_separation(*pair, 0.0, 30.0, shapes=shapes)[1] >= vehicles.TOUCH - 1e-6
    assert arrival(run) < 24.5


FLOOR = """
boundary: [[0, 0], [12, 0], [12, 8], [0, 8]]
safe_zone: {at: [1, 1]}
stations: {a: [10, 1.5], b: [10, 6.5]}
obstacles:
  wall: {x: [0, 12], y: [4.60, 4.65], z: [0, 2.5]}
  east: {x: [7.9, 8.2], y: [2, 4.6], z: [0, 2.5]}
  south: {x: [6.6, 7.9], y: [2, 3.45], z: [0, 2.5]}
agvs:
  size: [1.17, 0.67]
  height: 1.2
  max_speed: 2.0
  max_acceleration: 2.0
  limits: [0, 2.8]
  locations: {home: 0, far: 2.8}
  start: home
  lanes:
    cart: {origin: [4.0, 3.9], heading: 0}
"""
WALL = shapely.box(0, 4.60, 12, 4.65)


@pytest.fixture
def run(tmp_path):
    def go(person, moves="[]", floor=FLOOR, rules="{agv_law: {fixed: 0.01}}"):
        (tmp_path / "floor.yaml").write_text(floor)
        (tmp_path / "to_a.asl").write_text("+human_start <- move(10, 1.5, 0).")
        (tmp_path / "put.asl").write_text("!go. +!go <- .wait(10000); teleport_safe.")
        (tmp_path / "tell.asl").write_text("!t. +!t : safe_zone(X, Y) <- .print(home, X, Y).")
        (tmp_path / "stay.asl").write_text("!stay. +!stay.")
        text = (
            f"floorplan: floor.yaml\nduration: 30\nrules: {rules}\n"
            f"people: [{{name: p, {person}}}]\nagvs: {{cart: {moves}}}\n"
        )
        return sim.run(sim.Trial.parse(text, folder=tmp_path))

    return go


def kinds(run):
    return [event["kind"] for event in run.events]


def clearance(run):
    at = run.motions["p"].position([k / 100 for k in range(3001)])
    return float(shapely.distance(shapely.points(at), WALL).min())


def test_people_do_not_leave_through_a_wall(run):
    """The nearest free place is behind the wall, and the nearest reachable one is along it."""
    result = run("personality: to_a.asl, at: [4.0, 4.29], start: {time: 1}")
    assert "arrived" in kinds(result)
    assert clearance(result) >= 0.3 - 1e-3
    assert result.motions["p"].position(30.0) == pytest.approx((10, 1.5))


def test_a_person_without_an_exit_stays(run):
    """The person is in a niche 1 m deep, in front of which an AGV has stopped."""
    niche = "personality: to_a.asl, at: [7.6, 4.1], start: {time: 10}"
    result = run(niche, "[{time: 0, to: far}]")
    blocked = first(result, "path_blocked")
    assert "the start (7.6, 4.1)" in blocked["message"]
    assert "cart" in blocked["message"]
    assert result.motions["p"].position(30.0) == pytest.approx((7.6, 4.1))


def test_exits_are_clear_except_of_the_obstacle_that_is_too_close():
    world = navigation.CollisionWorld(sim.Trial.load("ariac2023").floorplan)
    beside = (-2.7, 0.76)  # between an AGV and a disposal bin
    assert not world.free(beside, 0.3)
    (place,) = world.exits(beside, 0.3)
    assert world.free(place, 0.3)
    assert world.as_if(away=["agv2"]).segment_free(beside, place, 0.3 - 1e-4)
    gaps = [world.plan.lane("agv2").footprint(0.0).distance(shapely.Point(beside))]
    gaps.append(world.plan.lane("agv2").footprint(0.0).distance(shapely.Point(place)))
    assert gaps[1] >= 0.3 > gaps[0]
    # This place is too close to a static obstacle.
    assert world.exits((-2.7, 0.7), 0.3) == []


def test_a_person_is_moved_beside_an_agv_at_home(run):
    home = FLOOR.replace("at: [1, 1]", "at: [6.8, 4.2]")
    stay = "personality: stay.asl, at: [2, 2]"
    result = run(stay, "[{time: 0, to: far}]", home, "{agv_law: {fixed: 9}}")
    # No teleport ends where the AGV is about to stop.
    for teleport in events(result, "teleport"):
        place, cart = shapely.Point(teleport["to"]), result.trial.floorplan.lane("cart")
        assert cart.footprint(2.8).distance(place) >= 0.3
        assert 0.1 < place.distance(shapely.Point(6.8, 4.2)) < 2.0
    program = "personality: put.asl, at: [2, 2]"
    result = run(program, "[{time: 0, to: far}]", home)
    (teleport,) = events(result, "teleport")
    assert clearance(result) >= 0.3 - 1e-3
    at = teleport["to"]
    assert result.trial.floorplan.lane("cart").footprint(2.8).distance(shapely.Point(at)) >= 0.3
    assert at[1] < 4.3
    assert math.dist(at, (6.8, 4.2)) < 1.5


def test_home_is_the_safe_zone_for_any_start(run):
    rules = "{agv_law: {fixed: 9}}"
    start = "personality: stay.asl, at: [2, 2]"
    for more, home in (("", [1, 1]), (", home: [2, 6]", [2, 6])):
        result = run(start + more, "[{time: 5, to: far}]", rules=rules)
        assert {tuple(e["to"]) for e in result.events if e["kind"] == "teleport"} == {(*home,)}
        assert result.motions["p"].position(1.0) == pytest.approx((2, 2))
        assert result.motions["p"].position(30.0) == pytest.approx(home)
    result = run("personality: stay.asl, home: [2, 6]")
    assert result.motions["p"].position(1.0) == pytest.approx((2, 6))
    believed = run("personality: tell.asl, home: [2, 6]")
    assert [e["text"] for e in believed.events if e["kind"] == "said"] == ["home26"]


def test_an_obstacle_on_the_position_of_a_person_blocks_the_goal():
    """The search for a detour must end, even if an obstacle covers both start and goal."""
    text = """
floorplan: {boundary: [[0, 0], [10, 0], [10, 6], [0, 6]], stations: {a: [5, 3]}}
duration: 12
obstacles: {pallet: {x: [4.5, 5.5], y: [2, 4], z: [0, 1], there: [[3]]}}
people:
  - {name: ada, at: [5, 3]}
  - {name: ben, at: [2, 1], personality: external}
"""
    run = sim.run(sim.Trial.parse(text))
    blocked = [e for e in run.events if e["kind"] == "path_blocked" and e["t"] >= 3]
    assert any("inside pallet" in e.get("message", "") for e in blocked)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.6, -0.8)])
@pytest.mark.parametrize(
    ("length", "width", "count"),
    [(1.2, 0.8, 3), (2.0, 1.0, 4), (2.01, 1.0, 5), (0.4, 1.0, 1), (0.5, 1.0, 1), (0.51, 1.0, 2)],
)
def test_discs_cover_a_vehicle_closely(length, width, count, direction):
    shape = sim.MachineShape(
        name="agv",
        kind="agv",
        category="vehicle",
        length=length,
        width=width,
        top=1.0,
        top_speed=1.0,
        direction=direction,
    )
    middles, radius = cover(shape)
    assert len(middles) == count
    c, s = direction
    box = shapely.affinity.affine_transform(
        shapely.box(-length / 2, -width / 2, length / 2, width / 2), [c, -s, s, c, 0.0, 0.0]
    )
    discs = shapely.union_all([shapely.Point(at).buffer(radius, 64) for at in middles])
    assert box.difference(discs.buffer(1e-3)).is_empty
    across = [-s * x + c * y for x, y in shapely.get_coordinates(discs).tolist()]
    assert width / 2 < max(across) <= 1.12 * width / 2


@pytest.mark.parametrize(
    "outline",
    [
        ((-1.2, -0.4), (1.2, -0.4), (1.2, 0.4), (-1.2, 0.4)),
        ((-0.3, -0.4), (1.2, -0.4), (1.2, 0.4), (-0.3, 0.4)),
        ((-0.3, -1.0), (0.4, -1.0), (0.4, 0.6), (-0.3, 0.6)),
    ],
)
def test_discs_of_a_turning_vehicle_cover_its_actual_pose(outline):
    shape = sim.MachineShape(
        name="cart",
        kind="cart",
        category="vehicle",
        length=2.4,
        width=2.0,
        top=1.0,
        top_speed=1.0,
        outline=outline,
    )
    middles, radius = cover(shape)
    area = shapely.Polygon(outline)
    discs = shapely.union_all([shapely.Point(at).buffer(radius, 64) for at in middles])
    assert area.difference(discs.buffer(1e-3)).is_empty
    west, south, east, north = area.bounds
    low_x, low_y, high_x, high_y = discs.bounds
    sides = (low_y, south, high_y, north)
    if north - south > east - west:
        sides = (low_x, west, high_x, east)
    low, right, high, left = sides
    half = (left - right) / 2
    assert right - low == pytest.approx(high - left, abs=1e-3)
    assert 0.0 < high - left <= 0.06 * half


def test_a_kind_states_the_category_of_its_machines_before_any_exists():
    for shape in machines_on(floorplan.load("ariac2023")):
        assert sim.KINDS[shape.kind].category == shape.category

    @dataclass(frozen=True)
    class Cart(sim.MachineModel):
        category = "vehicle"

        def shape(self, name, plan): ...

        def make(self, name, stage): ...

    assert may_be("robot", sim.MachineEntry("gantry")) and not may_be(
        "robot", sim.MachineEntry("agv")
    )
    assert may_be("robot", sim.MachineEntry("own:Cart")) and not may_be(
        "robot", sim.MachineEntry(Cart)
    )
