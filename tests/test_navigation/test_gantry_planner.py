import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely.geometry import box

import floorplan
from floorplan import Obstacle
from navigation import GantryPlanner, PlanningError


@pytest.fixture(scope="module")
def plan():
    return floorplan.load("ariac2023")


def test_a_path_is_straight_over_low_obstacles(plan):
    """Tables, bins and the conveyor are lower than the folded arm."""
    path = GantryPlanner(plan).plan((-14.4, -7.0, 0.0), (0.4, 7.0, math.pi))
    assert path.points.tolist() == [[-14.4, -7.0, 0.0], [0.4, 7.0, math.pi]]


def test_a_path_leads_around_a_disc_to_keep_out_of(plan):
    person, radius = (-7.0, 0.0), 3.5
    start, goal = (-12.0, 0.5, 0.0), (-2.0, -0.5, 1.0)
    path = GantryPlanner(plan).plan(start, goal, keep_out=[(*person, radius)])
    assert tuple(path.points[0]) == start
    assert tuple(path.points[-1]) == goal
    line = shapely.LineString(path.points[:, :2])
    assert line.distance(shapely.Point(person)) >= radius
    # Tangents and an arc, with bends of 30 degrees.
    away = math.hypot(5, 0.5)
    arc = math.pi - 2 * math.acos(radius / away)
    exact = 2 * math.sqrt(away**2 - radius**2) + radius * arc
    assert exact <= path.length <= exact * 1.02
    assert (np.diff(path.points[:, 2]) > 0).all()


def test_a_path_leads_around_tall_walls(plan):
    wall = Obstacle(name="press", footprint=box(-8, -7.9, -7, 4), bottom=0.0, top=2.0)
    low = Obstacle(name="press", footprint=wall.footprint, bottom=0.0, top=1.05)
    start, goal = (-12.0, 0.0, 0.0), (-3.0, 0.0, 0.0)
    tall = GantryPlanner(replace(plan, obstacles=(*plan.obstacles, wall))).plan(start, goal)
    assert shapely.LineString(tall.points[:, :2]).distance(wall.footprint) >= 0.9
    assert len(tall.points) > 2
    over = GantryPlanner(replace(plan, obstacles=(*plan.obstacles, low))).plan(start, goal)
    assert len(over.points) == 2
    across = Obstacle(name="press", footprint=box(-8, -9, -7, 9), bottom=0.0, top=2.0)
    with pytest.raises(PlanningError) as cut:
        GantryPlanner(replace(plan, obstacles=(*plan.obstacles, across))).plan(start, goal)
    assert cut.value.reason == "unreachable"


def test_agvs_count_on_request(plan):
    start, goal = (-12.0, 4.8, 0.0), (-3.0, 4.8, 0.0)
    assert len(GantryPlanner(plan).plan(start, goal).points) == 2
    assert len(GantryPlanner(plan, agvs={"agv1": "assembly_front"}).plan(start, goal).points) > 2


def test_a_path_leads_out_of_a_disc_around_the_start(plan):
    person, start, goal = (-7.0, 0.0), (-5.0, 0.0, 0.0), (-12.0, 0.0, 0.0)
    path = GantryPlanner(plan).plan(start, goal, keep_out=[(*person, 3.5)])
    assert shapely.LineString(path.points[:, :2]).distance(shapely.Point(person)) >= 2.0 - 1e-3
    with pytest.raises(PlanningError) as blocked:
        GantryPlanner(plan).plan(start, (-7.5, 0.0, 0.0), keep_out=[(*person, 3.5)])
    assert blocked.value.reason == "goal_blocked"


def test_discs_of_earlier_queries_are_removed(plan):
    planner = GantryPlanner(plan)
    start, goal = (-12.0, 0.0, 0.0), (-2.0, 0.0, 0.0)
    planner.plan(start, goal, keep_out=[(-7.0, 0.0, 3.0), (-4.0, 2.0, 1.0)])
    with pytest.raises(PlanningError):
        planner.plan(start, goal, keep_out=[(-2.0, 0.0, 3.0)])
    assert len(planner.plan(start, goal).points) == 2


def test_sampling_planners_find_paths(plan):
    way = GantryPlanner(plan).plan(
        (-12.0, 0.0, 0.0),
        (-2.0, 0.0, 0.0),
        keep_out=[(-7.0, 0.0, 3.5)],
        planner="RRTConnect",
    )
    assert way.planner == "RRTConnect"
    assert shapely.LineString(way.points[:, :2]).distance(shapely.Point(-7, 0)) >= 3.5


def test_poses_beyond_an_axis_are_rejected(plan):
    with pytest.raises(ValueError, match=r"the goal's x = 5 is outside .* -14\.4 … 0\.4"):
        GantryPlanner(plan).plan((-7.0, 0.0, 0.0), (5.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="the start's rotation = 7"):
        GantryPlanner(plan).plan((-7.0, 0.0, 7.0), (0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="has no gantry"):
        GantryPlanner(replace(plan, gantry=None))
