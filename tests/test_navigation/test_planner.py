"""Paths by every planner, and choices of planners with parameters."""

import itertools
import math
import re
import subprocess
import sys

import numpy as np
import pytest
import shapely
from hypothesis import given, settings, strategies as st
from plane_oracle import floor, gap, length, room, shortest
from shapely.geometry import Polygon, box

import floorplan
from navigation import CollisionWorld, Disc, PathPlanner, PlanningError, planners

SAMPLING = [info for info in planners() if info.name != "Roadmap"]


@pytest.fixture(scope="module")
def plan():
    return floorplan.load("ariac2023")


@pytest.fixture
def world(plan):
    return CollisionWorld(plan)


def random_floor(seed):
    rng = np.random.default_rng(seed)
    shapes = []
    for _ in range(rng.integers(1, 9)):
        corners = rng.integers(3, 8)
        angles = np.sort(rng.uniform(0, 2 * math.pi, corners))
        out = rng.uniform(0.3, 1.0, corners) * rng.uniform(0.3, 2.5)
        x, y = rng.uniform(0, 10, 2)
        shape = Polygon(np.column_stack([x + out * np.cos(angles), y + out * np.sin(angles)]))
        if shape.is_valid and shape.area > 1e-3:
            shapes.append(shape)
    notched = Polygon([(0, 0), (10, 0), (10, 4), (7, 4), (7, 5.5), (10, 5.5), (10, 10), (0, 10)])
    return floor(*shapes, boundary=notched if rng.random() < 0.5 else None)


def free_places(world, rng, radius, count):
    low_x, low_y, high_x, high_y = world.plan.boundary.bounds
    found = []
    for _ in range(1000):
        at = tuple(rng.uniform([low_x, low_y], [high_x, high_y]).tolist())
        if gap(world, [at]) > radius + 1e-3:
            found.append(at)
            if len(found) == count:
                break
    return found


def check_path(world, path, start, goal, radius):
    assert path.points.dtype == np.float64
    assert path.points.shape[1] == 2
    assert tuple(path.points[0]) == tuple(start)
    assert tuple(path.points[-1]) == tuple(goal)
    assert np.isfinite(path.points).all()
    assert gap(world, path.points) >= radius - 1e-9
    assert path.length == pytest.approx(length(path.points), rel=1e-12)
    assert path.clearance == pytest.approx(gap(world, path.points), abs=1e-9)
    steps = np.hypot(*np.diff(path.points, axis=0).T)
    assert (steps > 1e-7).all() or len(path.points) == 2


@settings(max_examples=settings.default.max_examples // 10)
@given(st.integers(0, 2**32), st.floats(0.1, 0.5))
def test_paths_are_safe_and_the_shortest(seed, radius):
    world = CollisionWorld(random_floor(seed))
    rng = np.random.default_rng(seed)
    world.place("person", Disc(tuple(rng.uniform(0, 10, 2).tolist()), 0.3))
    world.place("cart", box(x := rng.uniform(0, 9), y := rng.uniform(0, 9), x + 1.2, y + 0.5))
    planner = PathPlanner(world, radius)
    places = free_places(world, rng, radius, 8)
    lengths = shortest(room(world, radius), np.array(places))
    for (i, start), (j, goal) in itertools.combinations(enumerate(places), 2):
        try:
            path = planner.plan(start, goal)
        except PlanningError as why:
            assert why.reason == "unreachable"
            # With one more millimetre there is certainly no path.
            narrow = room(world, radius + 1e-3)
            both = shapely.MultiPoint([start, goal])
            assert not any(part.covers(both) for part in shapely.get_parts(narrow))
            continue
        check_path(world, path, start, goal, radius)
        # The oracle cuts its corners by 0.5 % of the radius.
        assert lengths[i, j] - 1e-9 <= path.length <= lengths[i, j] * 1.008 + 1e-3


def test_a_path_takes_the_shorter_side_of_a_row_of_bins():
    row = [box(1.0 + k, 4.0, 1.9 + k, 5.0) for k in range(8)]
    path = PathPlanner(CollisionWorld(floor(*row)), 0.3).plan((1.5, 5.5), (1.5, 3.5))
    assert path.length < 4.0


def test_a_free_path_is_straight(world):
    path = PathPlanner(world, 0.3).plan((-15.0, -10.0), (-5.0, 3.75))
    assert len(path.points) == 2
    assert path.length == math.dist((-15.0, -10.0), (-5.0, 3.75))


def test_paths_avoid_agvs_at_their_present_positions(world):
    planner = PathPlanner(world, 0.3)
    start, goal = (-11.3, 6.0), (-11.3, 3.5)
    assert len(planner.plan(start, goal).points) == 2
    world.move_agv("agv1", 9.0)
    there = planner.plan(start, goal)
    assert len(there.points) > 2
    check_path(world, there, start, goal, 0.3)
    world.move_agv("agv1", 9.3)
    moved = planner.plan(start, goal)
    check_path(world, moved, start, goal, 0.3)
    assert moved.length != there.length
    world.move_agv("agv1", "kitting")
    assert len(planner.plan(start, goal).points) == 2


def test_paths_do_not_depend_on_earlier_queries(plan):
    def ways(order):
        world = CollisionWorld(plan)
        planner = PathPlanner(world, 0.3)
        found = {}
        for k in order:
            rng = np.random.default_rng(k)
            for lane in plan.lanes:
                world.move_agv(lane.name, float(rng.uniform(*lane.limits)))
            start, goal = free_places(world, rng, 0.3, 2)
            found[k] = planner.plan(start, goal).points.tolist()
        return found

    assert ways(range(20)) == ways(reversed(range(20)))


def test_a_person_is_no_obstacle_for_their_own_path(world):
    at = (-10.0, 0.0)
    world.place("operator", Disc(at, 0.3))
    with pytest.raises(PlanningError) as blocked:
        PathPlanner(world, 0.3).plan(at, (-5.0, 0.0))
    assert blocked.value.reason == "start_blocked"
    assert "operator" in str(blocked.value)
    assert len(PathPlanner(world, 0.3, ignore=("operator",)).plan(at, (-5.0, 0.0)).points) == 2


def test_any_point_of_a_path_is_a_valid_start(world):
    """Any point of a path is a valid start and goal, also beside a corner."""
    planner = PathPlanner(world, 0.3)
    start, goal = (-15.0, -10.0), (-1.5, 0.0)
    points = planner.plan(start, goal).points
    rng = np.random.default_rng(0)
    for k in range(len(points) - 1):
        for share in (0.0, *rng.uniform(0, 1, 3)):
            here = tuple((points[k] + share * (points[k + 1] - points[k])).tolist())
            check_path(world, planner.plan(here, goal), here, goal, 0.3)
            check_path(world, planner.plan(start, here), start, here, 0.3)


def test_a_start_slightly_too_close_has_a_path(world):
    planner = PathPlanner(world, 0.3)
    # Assembly table 1 ends at x = -7.2.
    path = planner.plan((-6.9005, 3.0), (-5.0, 3.75))
    assert tuple(path.points[0]) == (-6.9005, 3.0)
    assert gap(world, path.points) == pytest.approx(0.2995)
    assert gap(world, path.points[1:]) >= 0.3
    with pytest.raises(PlanningError) as blocked:
        planner.plan((-6.902, 3.0), (-5.0, 3.75))
    assert blocked.value.reason == "start_blocked"
    with pytest.raises(PlanningError) as blocked:
        planner.plan((-5.0, 3.75), (-6.9005, 3.0))
    assert blocked.value.reason == "goal_blocked"
    assert "0.2995 m from assembly_table1" in str(blocked.value)


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ((-7.5, 3.0), "the goal (-7.5, 3) is inside assembly_table1"),
        ((-2.27, 3.0), "is 0.0546 m from bin1; a radius of 0.3 m does not fit"),
        ((50.0, 1.0), "the goal (50, 1) is outside the boundary"),
        ((-2.3, 4.9), "is inside agv1"),
        ((1.9, 0.0), "is 0.100 m from the boundary"),
    ],
)
def test_a_blocked_goal_names_the_obstacle(world, goal, words):
    with pytest.raises(PlanningError) as blocked:
        PathPlanner(world, 0.3).plan((-15.0, -10.0), goal)
    assert blocked.value.reason == "goal_blocked"
    assert words in str(blocked.value)


def test_an_unreachable_goal_reports_the_gap():
    world = CollisionWorld(floor(box(4, -1, 6, 6), box(4, 6.5, 6, 11)))
    with pytest.raises(PlanningError) as cut:
        PathPlanner(world, 0.3).plan((2.0, 5.0), (8.0, 5.0))
    assert cut.value.reason == "unreachable"
    assert "0.50 m wide between thing" in str(cut.value)
    assert "a radius up to 0.25 m would pass" in str(cut.value)
    assert PathPlanner(world, 0.249).plan((2.0, 5.0), (8.0, 5.0)).length > 6


@pytest.mark.parametrize("radius", [0.2, 0.2001, 0.21])
def test_a_gap_barely_too_narrow_is_reported(radius):
    world = CollisionWorld(floor(box(4, 0.2, 5, 9.6)))
    with pytest.raises(PlanningError, match=r"at \(4.50, 9.80\)") as cut:
        PathPlanner(world, radius).plan((1.0, 1.0), (8.0, 4.0))
    widest, needed = re.findall(r"(\d\.\d+) m (?:wide|are needed)", str(cut.value))
    assert float(widest) < float(needed)


def test_an_unreachable_goal_names_the_wall():
    world = CollisionWorld(floor(box(4, -1, 6, 11)))
    with pytest.raises(PlanningError, match=r"no way, however narrow, .* thing0 cuts") as cut:
        PathPlanner(world, 0.3).plan((2.0, 5.0), (8.0, 5.0))
    assert cut.value.reason == "unreachable"


def test_an_agv_in_the_only_door_blocks_all_paths(world):
    planner = PathPlanner(world, 0.3)
    start, goal = (-15.0, -10.0), (-19.0, 0.0)
    assert planner.plan(start, goal).length < 12
    world.place("pallets", box(-16.5, -11.5, -15.8, -8.5))
    for k in (1, 2, 3, 4):
        world.move_agv(f"agv{k}", 13.8)
    with pytest.raises(PlanningError) as cut:
        planner.plan(start, goal)
    assert cut.value.reason == "unreachable"
    assert "agv" in str(cut.value)
    world.move_agv("agv3", "kitting")
    check_path(world, planner.plan(start, goal), start, goal, 0.3)


def test_a_person_passes_gaps_of_their_width():
    """Between two corners, where circumscribed arcs would meet."""
    corners = [Polygon([(0, 4), (5, 5), (0, 6)]), Polygon([(10, 4), (5.601, 5), (10, 6)])]
    world = CollisionWorld(floor(*corners))
    path = PathPlanner(world, 0.3).plan((5.0, 2.0), (5.0, 8.0))
    check_path(world, path, (5.0, 2.0), (5.0, 8.0), 0.3)
    with pytest.raises(PlanningError):
        PathPlanner(world, 0.301).plan((5.0, 2.0), (5.0, 8.0))


def test_a_path_to_the_start_has_no_length(world):
    path = PathPlanner(world, 0.3).plan((-15.0, -10.0), (-15.0, -10.0))
    assert path.length == 0
    assert path.points.shape == (2, 2)


def test_invalid_queries_are_rejected(world):
    planner = PathPlanner(world, 0.3)
    with pytest.raises(ValueError, match="the start must be a finite x and y"):
        planner.plan((math.nan, 0), (0, 0))
    with pytest.raises(ValueError, match="the goal must be a finite x and y"):
        planner.plan((-15, -10), (0, 0, 0))
    with pytest.raises(ValueError, match="a radius must be positive"):
        PathPlanner(world, 0.0)
    with pytest.raises(ValueError, match="no planner is called 'RTConnect'; did you mean 'RRTC"):
        planner.plan((-15, -10), (-5, 3.75), planner="RTConnect")
    with pytest.raises(ValueError, match="Roadmap has no parameters, found range"):
        planner.plan((-15, -10), (-5, 3.75), parameters={"range": 1.0})


@pytest.mark.parametrize("name", [info.name for info in SAMPLING])
def test_every_sampling_planner_finds_a_path(world, name):
    planner = PathPlanner(world, 0.3)
    start, goal = (-15.0, -10.0), (-19.0, 0.0)
    path = planner.plan(start, goal, planner=name, seed=3)
    check_path(world, path, start, goal, 0.3)
    assert path.planner == name
    again = planner.plan(start, goal, planner=name, seed=3)
    assert path.points.tolist() == again.points.tolist()
    # Also if the straight path is free.
    check_path(world, planner.plan(start, (-12.0, -9.0), planner=name), start, (-12.0, -9.0), 0.3)


@pytest.mark.parametrize("name", [info.name for info in SAMPLING])
def test_the_world_proves_that_a_sampling_planner_has_no_path(name):
    world = CollisionWorld(floor(box(4, -1, 6, 11)))
    with pytest.raises(PlanningError) as cut:
        PathPlanner(world, 0.3).plan(
            (2.0, 5.0), (8.0, 5.0), planner=name, parameters={"iterations": 100}
        )
    assert cut.value.reason == "unreachable"


def test_fcl_tests_all_links_of_a_path(world, monkeypatch):
    start, goal = (-15.0, -10.0), (-19.0, 0.0)
    ask, asked = CollisionWorld.segment_free, []

    def recorded_segment_free(self, a, b, radius, among=None):
        asked.append({a, b})
        return ask(self, a, b, radius, among)

    monkeypatch.setattr(CollisionWorld, "segment_free", recorded_segment_free)
    # Another radius, because results for others are cached with the floor.
    path = PathPlanner(world, 0.3 + 1e-9).plan(start, goal)
    points = [*map(tuple, path.points.tolist())]
    assert len(points) > 2
    assert all({a, b} in asked for a, b in itertools.pairwise(points))


def test_a_path_avoids_links_that_fcl_rejects(world, monkeypatch):
    start, goal = (-15.0, -10.0), (-19.0, 0.0)
    ask, rejected = CollisionWorld.segment_free, []

    def rejecting(self, a, b, radius, among=None):
        return {a, b} not in rejected and ask(self, a, b, radius, among)

    monkeypatch.setattr(CollisionWorld, "segment_free", rejecting)

    def path():
        # Another radius, because results for others are cached with the floor.
        planner = PathPlanner(world, 0.3 + 2e-9)
        planner.roadmap().verdicts.clear()
        return [*map(tuple, planner.plan(start, goal).points.tolist())]

    shortest = path()
    for k in range(3):
        points = path()
        assert length(points) >= length(shortest)
        assert gap(world, points) >= 0.3
        assert not any({a, b} in rejected for a, b in itertools.pairwise(points))
        rejected.append({points[k], points[k + 1]})


@settings(max_examples=settings.default.max_examples // 5)
@given(st.integers(0, 2**32), st.floats(0.05, 1.0))
def test_free_segments_are_those_of_plane_geometry(seed, radius):
    world = CollisionWorld(random_floor(seed))
    walls, rng = world.walls, np.random.default_rng(seed)
    for a, b in rng.uniform(0, 10, (40, 2, 2)):
        if rng.random() < 0.3:
            b = np.where(rng.random(2) < 0.5, a, b)
        assert walls.inside(*a.tolist()) == bool(shapely.contains_xy(world.floor, *a))
        apart = gap(world, [a, b])
        if abs(apart - radius) > 1e-9 and gap(world, [a]) > radius:
            assert walls.touched(*a.tolist(), *b.tolist(), radius) == (apart <= radius)


def test_cached_paths_expire_when_a_body_moves(world):
    planner = PathPlanner(world, 0.3, keep=2)
    question = ((-11.3, 6.0), (-11.3, 3.5))
    path = planner.plan(*question)
    assert planner.plan(*question) is path
    assert planner.plan(*question, planner="RRT") is not path
    world.move_agv("agv1", 9.0)
    assert len(planner.plan(*question).points) > 2
    world.move_agv("agv1", "kitting")
    assert planner.plan(*question).points.tolist() == path.points.tolist()


def test_a_budget_that_is_too_small_is_reported(world):
    with pytest.raises(PlanningError, match="RRT found no") as spent:
        PathPlanner(world, 0.3).plan(
            (-15, -10), (-1.5, 0.0), planner="RRT", parameters={"iterations": 5}
        )
    assert spent.value.reason == "not_found"


def test_parameters_are_set_by_name(world):
    planner = PathPlanner(world, 0.3)

    def ask(**parameters):
        return planner.plan((-15, -10), (-19, 0), planner="RRT", parameters=parameters)

    assert ask(range=0.5).points.tolist() != ask(range=5.0).points.tolist()
    assert len(ask(range=0.5, simplify=False).points) > len(ask(range=0.5).points)
    with pytest.raises(ValueError, match=r"RRT has no parameter 'rnage'; did you mean 'range'"):
        ask(rnage=0.5)
    with pytest.raises(ValueError, match="'range' must be a number, 0 or more, found -1"):
        ask(range=-1.0)
    with pytest.raises(ValueError, match="'goal_bias' must be a number, 0 or more, found 'x'"):
        ask(goal_bias="x")
    with pytest.raises(ValueError, match="'intermediate_states' must be true or false, found 1"):
        ask(intermediate_states=1)
    with pytest.raises(ValueError, match="'iterations' must be a whole number above 0, found 0"):
        ask(iterations=0)
    with pytest.raises(ValueError, match="a seed must be a whole number"):
        planner.plan((-15, -10), (-19, 0), planner="RRT", seed=-1)
    with pytest.raises(ValueError, match="a seed must be a whole number"):
        planner.plan((-15, -10), (-19, 0), planner="RRT", seed=1.5)
    one, other = (
        planner.plan((-15, -10), (-19, 0), planner="RRT", seed=seed) for seed in (3, np.int64(3))
    )
    assert one.points.tolist() == other.points.tolist()


def test_nothing_is_printed_at_exit():
    """Both OMPL's log and nanobind's list of leaks are suppressed."""
    code = (
        "import floorplan, navigation\n"
        "world = navigation.CollisionWorld(floorplan.load('ariac2023'))\n"
        "planner = navigation.PathPlanner(world, 0.3)\n"
        "for name in ('Roadmap', 'RRTConnect', 'PRM', 'BITstar', 'AORRTC'):\n"
        "    planner.plan((-15, -10), (-19, 0), planner=name)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == ""
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("given", "name", "parameters"),
    [
        ("RRTConnect", "RRTConnect", {}),
        ("BITstar: {samples_per_batch: 50}", "BITstar", {"samples_per_batch": 50}),
        ({"name": "RRTConnect", "range": 1.0}, "RRTConnect", {"range": 1.0}),
        ("{name: PRM, simplify: false}", "PRM", {"simplify": False}),
        ("my_planner:Straight", "my_planner:Straight", {}),
        ("my_planner:Straight: {step: 0.5}", "my_planner:Straight", {"step": 0.5}),
    ],
)
def test_a_choice_has_several_forms(world, given, name, parameters):
    choice = PathPlanner(world, planner=given).choice
    assert (choice.name, dict(choice.parameters)) == (name, parameters)
    assert PathPlanner(world, planner=str(choice)).choice == choice


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("", "a planner is a name, or {name: RRTConnect, range: 1.0}; found ''"),
        ("{{", "is not YAML"),
        ({"name": 3}, "found 3 as its name"),
        ("RRT: [1]", "the parameters of RRT are {name: value, …}; found [1]"),
        ({"RRT": {"range": {}}}, "parameter 'range' of RRT must be a value"),
        ("RRTConect", "no planner is called 'RRTConect'; did you mean 'RRTConnect'?"),
        ("STRRTstar", "STRRTstar plans in space and time; navigation.plan_among"),
        ("RRT: {rnge: 1}", "RRT has no parameter 'rnge'; did you mean 'range'?"),
        ("RRT: {range: .nan}", "parameter 'range' must be a number, 0 or more, found nan"),
        ("BITstar: {iterations: 0}", "parameter 'iterations' must be a whole number above 0"),
        ("Roadmap: {range: 1}", "Roadmap has no parameters, found range"),
    ],
)
def test_invalid_choices_are_rejected(world, given, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        PathPlanner(world, planner=given)


def test_a_path_planner_uses_its_choice():
    planner = PathPlanner(
        CollisionWorld(floorplan.load("ariac2023")), planner="RRTConnect: {range: 1.0}"
    )
    question = ((-15.0, -10.0), (-19.0, 0.0))
    path = planner.plan(*question)
    assert path.planner == "RRTConnect"
    other = PathPlanner(planner.world).plan(
        *question, planner="RRTConnect", parameters={"range": 1.0}
    )
    assert path.points.tolist() == other.points.tolist()
    assert planner.plan(*question, planner="Roadmap").planner == "Roadmap"
