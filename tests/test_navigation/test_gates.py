"""One-way gates: paths through them, and the proof that there is none."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings, strategies as st
from plane_oracle import floor, gap, goes_back, room, shortest
from shapely.geometry import LineString, box

import floorplan
from floorplan import Gate
from navigation import CollisionWorld, PathPlanner, PlanningError

RADIUS = 0.3

GATED = """\
boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
obstacles:
  south: {x: [9.8, 10.2], y: [0, 2], z: [0, 3]}
  middle: {x: [9.8, 10.2], y: [3.5, 6.5], z: [0, 3]}
  north: {x: [9.8, 10.2], y: [8, 10], z: [0, 3]}
gates:
  back: {between: [[10, 2], [10, 3.5]], towards: [9, 3]}
  there: {between: [[10, 6.5], [10, 8]], towards: [11, 7]}
"""


def gated_floor(rng):
    """Return boxes on a floor, and gates between them or to the boundary that do not meet."""
    boxes = [
        shapely.affinity.rotate(box(x, y, x + w, y + h), angle)
        for x, y, w, h, angle in rng.uniform([0, 0, 0.3, 0.3, 0], [9, 9, 2.5, 2.5, 90], (6, 5))
    ]
    boxes = [one.intersection(box(0, 0, 10, 10)) for one in boxes]
    plan = floor(*boxes)
    things = [*boxes, plan.boundary.exterior]
    gates = []
    for one, other in itertools.combinations(things, 2):
        line = shapely.shortest_line(one, other)
        inside = line.difference(shapely.union_all(boxes)).length
        meets = any(line.distance(LineString(gate.ends)) < 0.01 for gate in gates)
        if line.length > 2 * RADIUS and inside > line.length - 1e-6 and not meets:
            a, b = (tuple(end) for end in shapely.get_coordinates(line).tolist())
            way = rng.choice([-1, 1])
            towards = (a[0] - way * (b[1] - a[1]), a[1] + way * (b[0] - a[0]))
            gates.append(Gate(name=f"gate{len(gates)}", ends=(a, b), towards=towards))
    return replace(plan, gates=gates)


@settings(max_examples=settings.default.max_examples // 20)
@given(st.integers(0, 2**32))
def test_paths_through_gates_are_the_shortest_or_proved_impossible(seed):
    rng = np.random.default_rng(seed)
    world = CollisionWorld(gated_floor(rng))
    world.place("cart", box(x := rng.uniform(0, 9), y := rng.uniform(0, 9), x + 1.2, y + 0.5))
    planner, gates = PathPlanner(world, RADIUS), world.plan.gates
    drawn = (tuple(at) for at in rng.uniform(0, 10, (400, 2)).tolist())
    places = [*itertools.islice((at for at in drawn if gap(world, [at]) > RADIUS + 1e-3), 5)]
    lengths = shortest(room(world, RADIUS), np.array(places).reshape(-1, 2), gates)
    narrow = shortest(room(world, RADIUS + 1e-3), np.array(places).reshape(-1, 2), gates)
    for (i, start), (j, goal) in itertools.permutations(enumerate(places), 2):
        try:
            path = planner.plan(start, goal)
        except PlanningError as why:
            assert why.reason == "unreachable" and narrow[i, j] == np.inf
            continue
        points = path.points.tolist()
        assert gap(world, points) >= RADIUS - 1e-9
        legs = path.points[:-1], path.points[1:]
        assert not any(goes_back(gate, *legs).any() for gate in gates)
        assert lengths[i, j] - 1e-9 <= path.length <= lengths[i, j] * 1.008 + 1e-3


FEW = {"iterations": 200}


@pytest.mark.parametrize("name", ["Roadmap", "RRTConnect", "RRTstar", "PRM", "BITstar", "KPIECE1"])
def test_every_planner_respects_the_direction(name):
    world = CollisionWorld(floorplan.parse(GATED))
    budget = {"RRTstar": FEW, "BITstar": FEW}.get(name, {})
    for start, goal, shortcut in (((8, 2.75), (12, 2.75), 3.0), ((12, 7.25), (8, 7.25), 7.0)):
        path = PathPlanner(world).plan(start, goal, planner=name, parameters=budget)
        crossed = LineString(path.points).intersection(LineString([(10, 0), (10, 10)]))
        assert crossed.geom_type == "Point" and abs(crossed.y - shortcut) > 2


@pytest.mark.parametrize("planner", ["Roadmap", {"name": "RRTConnect", "iterations": 100}])
def test_gates_that_block_all_paths_are_named(planner):
    closed = CollisionWorld(floorplan.parse(GATED.replace("[11, 7]", "[9, 7]")))
    with pytest.raises(PlanningError) as why:
        PathPlanner(closed).plan((8, 2.75), (12, 2.75), planner=planner)
    assert why.value.reason == "unreachable"
    assert str(why.value).endswith("but through back or there, against the direction")


def test_people_to_whom_a_gate_does_not_apply_pass_it():
    plan = floorplan.parse(GATED.replace("[9, 3]}", "[9, 3], concerns: ['cart*']}"))
    assert len(PathPlanner(CollisionWorld(plan)).plan((8, 2.75), (12, 2.75)).points) == 2
    bound = CollisionWorld(plan, gates=[gate for gate in plan.gates if gate.is_about("cart1")])
    assert len(PathPlanner(bound).plan((8, 2.75), (12, 2.75)).points) > 2


AISLES = """\
boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
obstacles:
  south: {x: [6, 14], y: [0, 2], z: [0, 3]}
  middle: {x: [6, 14], y: [4, 6], z: [0, 3]}
  north: {x: [6, 14], y: [8, 10], z: [0, 3]}
zones:
  back: {x: [7, 13], y: [2, 4], one_way: [-1, 0]}
  there: {polygon: [[7, 6], [13.2, 6], [13, 8], [7, 8]], one_way: [2, 0], max_speed: 0.5}
agvs:
  size: [1.0, 0.5]
  height: 1.0
  max_speed: 1.0
  max_acceleration: 1.0
  limits: [0, 12]
  locations: {west: 0, east: 12}
  start: west
  lanes: {cart: {origin: [4, 7]}}
"""


def test_one_way_zones_are_passed_in_their_direction():
    plan = floorplan.parse(AISLES)
    assert floorplan.parse(plan.to_yaml()) == plan
    planner = PathPlanner(CollisionWorld(plan))
    for start, goal, y in (((5, 5), (15, 5), 7), ((15, 5), (5, 5), 3)):
        points = planner.plan(start, goal).points
        crossed = LineString(points).intersection(LineString([(10, 0), (10, 10)]))
        assert abs(crossed.y - y) < 1
    # From within, the path back leaves at the end and leads around the other aisle.
    assert planner.plan((10, 7), (8, 7)).length == pytest.approx(2)
    assert planner.plan((8, 7), (5, 7)).length > 12
    one_way = AISLES.replace("[-1, 0]", "[1, 0]")
    with pytest.raises(PlanningError, match=r"but through back \(exit\) or there \(exit\)") as why:
        PathPlanner(CollisionWorld(floorplan.parse(one_way))).plan((15, 5), (5, 5))
    assert why.value.reason == "unreachable"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[-1, 0]", "[0, 0]"), "zones.back.one_way: is no direction"),
        (("[-1, 0]", "[1, 1]"), "it has 2 and 2"),
        (
            ("x: [7, 13], y: [2, 4]", "x: [7, 13], y: [2.5, 4]"),
            "a one-way zone goes from wall to wall",
        ),
        (("one_way: [-1, 0]", "one_way: [-1, 0], forbidden: true"), "zones.back: give forbidden"),
    ],
)
def test_invalid_one_way_zones_are_rejected(change, message):
    with pytest.raises(floorplan.FloorplanError) as refused:
        floorplan.parse(AISLES.replace(*change))
    assert message in str(refused.value)


def test_a_position_on_the_line_is_behind_the_gate():
    world = CollisionWorld(floorplan.parse(GATED))
    planner = PathPlanner(world)
    assert len(planner.plan((10, 7.25), (12, 7.25)).points) == 2
    assert len(planner.plan((8, 7.25), (10, 7.25)).points) == 2
    assert planner.plan((10, 7.25), (9, 7.25)).length > 9
