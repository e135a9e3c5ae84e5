import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings, strategies as st
from plane_oracle import floor, gap, solid
from shapely.geometry import Polygon, box

import floorplan
from floorplan import Floorplan, Human
from navigation import CollisionWorld, Disc, PathPlanner, PlanningError
from navigation.freespace import shrunk

CELL = floorplan.load("ariac2023")


@pytest.fixture
def plan():
    return CELL


@pytest.fixture
def world(plan):
    return CollisionWorld(plan)


def star(rng, x, y, size, corners):
    """Return a polygon around (x, y), usually not convex."""
    angles = np.sort(rng.uniform(0, 2 * math.pi, corners))
    out = rng.uniform(0.2, 1.0, corners) * size
    return Polygon(np.column_stack([x + out * np.cos(angles), y + out * np.sin(angles)]))


@st.composite
def floors(draw):
    """Return floors with obstacles of any shape, some across a boundary with notches."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    shapes = [star(rng, *rng.uniform(-1, 11, 2), rng.uniform(0.3, 2), k) for k in (3, 4, 5, 7, 9)]
    angles = np.linspace(0, 2 * math.pi, 13)[:-1]
    out = rng.uniform(3.0, 5.0, 12)
    boundary = Polygon(np.column_stack([5 + out * np.cos(angles), 5 + out * np.sin(angles)]))
    shapes = [s for s in shapes if s.is_valid and s.area > 1e-3]
    return floor(*shapes, boundary=draw(st.sampled_from([box(0, 0, 10, 10), boundary])))


places = st.tuples(st.floats(-1, 11), st.floats(-1, 11))


@settings(deadline=None, max_examples=60)
@given(floors(), st.lists(st.tuples(places, places), min_size=8, max_size=8), st.floats(0.05, 1))
def test_results_agree_with_plane_geometry(plan, ways, radius):
    world = CollisionWorld(plan)
    for a, b in ways:
        here, along = gap(world, [a]), gap(world, [a, b])
        assert world.distance(a) == pytest.approx(here, abs=2e-6)
        if here > 0:
            assert world.nearest(a)[1] == pytest.approx(here, abs=1e-9)
        assert world.clearance([a, b]) == pytest.approx(along, abs=1e-9)
        if abs(here - radius) > 2e-6:
            assert world.free(a, radius) == (here > radius)
        if abs(along - radius) > 2e-6:
            assert world.segment_free(a, b, radius) == (along > radius)


@settings(deadline=None, max_examples=60)
@given(floors(), places, places, st.floats(0.05, 0.6), st.floats(0.1, 1.5))
def test_bodies_are_obstacles(plan, a, b, radius, size):
    world = CollisionWorld(plan)
    rng = np.random.default_rng(int(size * 1e6))
    shape = star(rng, 5, 5, size, 6)
    assume(shape.is_valid and a != b)
    world.place("pallet", shape)
    world.place("person", Disc((3.0, 3.0), size))
    person = shapely.Point(3, 3)
    rest = solid(world.__class__(plan)).union(shape)

    def true_gap(line):
        return min(rest.distance(line), max(person.distance(line) - size, 0))

    along = true_gap(shapely.LineString([a, b]))
    assert world.distance(a) == pytest.approx(true_gap(shapely.Point(a)), abs=2e-6)
    assert world.clearance([a, b]) == pytest.approx(along, abs=1e-9)
    if abs(along - radius) > 2e-6:
        assert world.segment_free(a, b, radius) == (along > radius)
    alone = world.as_if(away=("pallet", "person")).segment_free(a, b, radius)
    assert alone == CollisionWorld(plan).segment_free(a, b, radius)


def answers(world, radius, points):
    """Return the results of `world` for discs of `radius` at and between `points`."""
    planner = PathPlanner(world, radius)
    found = [world.neighbours(at) for at in points]
    for a, b in itertools.pairwise(points):
        found += [world.segment_free(a, b, radius), world.nearest_free(a, radius)]
        found += [world.exits(a, radius), world.clearance([a, b])]
        try:
            found.append(planner.plan(a, b).points.tolist())
        except PlanningError as why:
            found.append(str(why))
    return found


@settings(deadline=None, max_examples=40)
@given(floors(), st.lists(places, min_size=3, max_size=3), st.floats(0.05, 0.6), st.floats(0.1, 2))
def test_a_world_with_other_bodies_leaves_the_world_unchanged(plan, points, radius, size):
    stands, more = (
        Disc((3.0, 3.0), size),
        {"cart": Disc((6.0, 5.0), size), "crate": box(1, 6, 3, 7)},
    )
    world = CollisionWorld(plan)
    world.place("person", stands)
    world.place("cart", Disc((2.0, 7.0), 0.3))
    before = answers(world, radius, points)
    bodies, changes = world.bodies, world.changes
    space, roadmap = world.free_space(radius), world.roadmap(radius, 0.1)
    around = [roadmap.around(body) for body in bodies]

    moved = CollisionWorld(plan)
    for name, shape in more.items():
        moved.place(name, shape)
    asked = world.as_if(more, away=["person"])
    assert answers(asked, radius, points) == answers(moved, radius, points)
    asked.remove("cart")

    assert (world.bodies, world.changes) == (bodies, changes)
    assert world.free_space(radius) is space
    assert world.roadmap(radius, 0.1) is roadmap
    assert all(roadmap.around(body) is kept for body, kept in zip(bodies, around, strict=True))
    assert answers(world, radius, points) == before


def test_agvs_may_be_away(world):
    assert world.as_if(away=["agv1"]).free((-2.27, 4.8), 0.3)
    assert not world.free((-2.27, 4.8), 0.3)
    with pytest.raises(KeyError, match="no body is called 'agv9'"):
        world.as_if(away=["agv9"])
    with pytest.raises(ValueError, match="belongs to the floorplan"):
        world.as_if({"agv1": Disc((0.0, 0.0), 0.3)}, away=["agv1"])


def test_obstacles_above_a_person_do_not_block(world, plan):
    lintel = plan.obstacle("door_lintel").footprint.centroid
    assert world.free((lintel.x, lintel.y), 0.3)
    assert not CollisionWorld(plan, bottom=2.6, top=3.0).free((lintel.x, lintel.y), 0.3)
    # Only walls reach the heights above the tables.
    assert CollisionWorld(plan, bottom=1.24, top=2.7).free((-7.7, 3.0), 0.3)


def test_agvs_are_at_their_positions(world, plan):
    assert world.nearest((-2.27, 4.8)) == ("agv1", 0.0)
    world.move_agv("agv1", "assembly_front")
    assert world.agv_position("agv1") == 5.6
    assert world.nearest((-7.87, 4.8)) == ("agv1", 0.0)
    assert world.free((-2.27, 4.8), 0.3)
    expected = plan.free(0, 1.75).area - 4 * 1.17 * 0.67
    assert world.walkable.area == pytest.approx(expected)


def test_positions_beyond_a_lane_are_rejected(world):
    with pytest.raises(ValueError, match=r"agv1 can't be at 18\.5 m: its lane runs from 0 to 18"):
        world.move_agv("agv1", 18.5)
    with pytest.raises(ValueError, match="agv1 has no location 'moon'"):
        world.move_agv("agv1", "moon")
    with pytest.raises(KeyError, match="'agv9'"):
        world.move_agv("agv9", 0.0)
    with pytest.raises(ValueError, match="can't be at nan"):
        world.move_agv("agv1", math.nan)


def test_bodies_can_be_placed_and_removed(world):
    at = (-5.0, 0.0)
    world.place("operator2", Disc(at, 0.3))
    assert world.nearest(at) == ("operator2", 0.0)
    assert not world.free((-5.0, 0.5), 0.3)
    world.place("operator2", Disc((-5.0, 5.0), 0.3))
    assert world.free(at, 0.3)
    world.remove("operator2")
    assert world.free((-5.0, 5.0), 0.3)
    with pytest.raises(KeyError, match="no placed body is called 'operator2'"):
        world.remove("operator2")
    with pytest.raises(KeyError, match="no placed body is called 'agv1'"):
        world.remove("agv1")


def test_bodies_above_or_below_do_not_block(world):
    world.place("lamp", Disc((-5.0, 0.0), 0.5), bottom=2.0, top=2.5)
    assert world.free((-5.0, 0.0), 0.3)
    world.place("lamp", Disc((-5.0, 0.0), 0.5), bottom=1.0, top=2.5)
    assert not world.free((-5.0, 0.0), 0.3)
    world.place("lamp", Disc((-5.0, 0.0), 0.5), bottom=2.0, top=2.5)
    assert world.free((-5.0, 0.0), 0.3)


def test_invalid_bodies_are_rejected(world):
    with pytest.raises(ValueError, match="'bin1' belongs to the floorplan"):
        world.place("bin1", Disc((0.0, 0.0), 0.3))
    with pytest.raises(ValueError, match="'agv1' belongs to the floorplan"):
        world.place("agv1", Disc((0.0, 0.0), 0.3))
    with pytest.raises(ValueError, match="must be a Disc or a simple polygon"):
        world.place("bow tie", Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]))
    with pytest.raises(ValueError, match="positive radius"):
        Disc((0.0, 0.0), 0.0)


def test_places_outside_are_not_free(world):
    for at in ((50.0, 0.0), (2.1, 0.0), (0.0, -12.01), (math.nan, 0.0), (math.inf, 0.0)):
        assert not world.free(at, 0.01)
        assert world.distance(at) == 0.0
    assert world.nearest((50.0, 0.0)) == ("boundary", 0.0)


def test_the_nearest_free_place_beside_an_agv(world):
    at = (-2.27, 4.8)
    place = world.nearest_free(at, 0.3)
    assert world.free(place, 0.3 - 1e-6)
    # Perpendicular to the long side of the AGV.
    assert math.dist(at, place) == pytest.approx(0.67 / 2 + 0.3, abs=3e-4)
    assert world.nearest_free((-5.0, 0.0), 0.3) == (-5.0, 0.0)
    assert world.nearest_free((-5.0, 0.0), 30.0) is None


@given(
    st.floats(-22, 2),
    st.floats(-12, 12),
    st.lists(st.tuples(st.floats(-15, 0), st.floats(-9, 9)), max_size=4),
    st.lists(st.floats(0, 1), min_size=len(CELL.lanes), max_size=len(CELL.lanes)),
)
def test_bodies_far_from_a_place_leave_the_nearest_free_one_as_it_is(x, y, discs, shares):
    """To the bit, because a path must not depend on bodies elsewhere."""
    world = CollisionWorld(CELL)
    for k, at in enumerate(discs):
        world.place(f"disc {k}", Disc(at, 0.4))
    for lane, share in zip(CELL.lanes, shares, strict=True):
        low, high = lane.limits
        world.move_agv(lane.name, low + share * (high - low))
    for radius in (0.3, 0.3001):
        assert world.nearest_free((x, y), radius) == world.free_space(radius).nearest((x, y))


@pytest.mark.parametrize("point", [(-2.5, 0.5), (-2.66, 3.0), (-0.6, -4.72)])
def test_free_space_has_no_cracks_at_corners(world, point):
    """A crack beside a corner of a bin would seem to be a free place."""
    place = world.nearest_free(point, 0.3)
    assert world.free(place, 0.3 - 1e-6)


@settings(max_examples=settings.default.max_examples // 2)
@given(st.integers(0, 2**32), st.floats(0.05, 1.0))
def test_free_space_keeps_the_radius_and_loses_at_most_one_percent(seed, radius):
    """Also along walls with dents that are flatter than one percent of the radius."""
    rng = np.random.default_rng(seed)
    shapes = [star(rng, *rng.uniform(0, 10, 2), rng.uniform(0.3, 2), k) for k in (3, 4, 5, 7, 9)]
    for depth in (1e-3, 1e-2, 1e-1):
        x = np.linspace(*np.sort(rng.uniform(0, 10, 2)), 40)
        y = rng.uniform(0, 10) + depth * radius * rng.uniform(-1, 1, len(x))
        shapes.append(Polygon([*zip(x, y, strict=True), (x[-1], 11), (x[0], 11)]))
    things = shapely.union_all([shape for shape in shapes if shape.is_valid])
    room = box(0, 0, 10, 10).difference(things)
    space = shrunk(room, radius)
    assert space.is_empty or shapely.distance(space, room.boundary) >= radius
    points = shapely.points(rng.uniform(0, 10, (1000, 2)))
    inside = shapely.contains_properly(room, points)
    clear = inside & (shapely.distance(points, room.boundary) >= 1.01 * radius)
    assert shapely.intersects(space, points[clear]).all()


@given(st.floats(-22, 2), st.floats(-12, 12))
def test_the_nearest_free_place_is_free_and_near(x, y):
    world = CollisionWorld(CELL)
    place = world.nearest_free((x, y), 0.3)
    assert world.free(place, 0.3 - 1e-6)
    away = math.dist((x, y), place)
    for k in range(36):
        angle = 2 * math.pi * k / 36
        inner = 0.98 * away
        nearer = (x + inner * math.cos(angle), y + inner * math.sin(angle))
        assert away < 1e-9 or not world.free(nearer, 0.301)


def test_a_wall_divides_the_free_space():
    wall = box(4, -1, 6, 11)
    world = CollisionWorld(floor(wall))
    assert len(world.free_space(0.3).pieces) == 2
    assert world.walkable.area == pytest.approx(80)


def test_heights_must_rise(plan):
    with pytest.raises(ValueError, match="heights must rise"):
        CollisionWorld(plan, bottom=1.0, top=1.0)


def test_default_top_is_a_persons_height():
    plan = Floorplan(name="low", boundary=box(0, 0, 5, 5), human=Human(height=0.9))
    world = CollisionWorld(plan)
    assert world.top == 0.9
