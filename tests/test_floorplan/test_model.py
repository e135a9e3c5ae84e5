"""The floorplan value, and the figures of the built-in floors."""

import copy
import math
import pickle
from dataclasses import asdict, replace

import pytest
import shapely

import floorplan

FACTS = {
    # name: (x range, y range, z range), as in the files of the competition
    "assembly_table1": ((-8.2, -7.2), (2.42, 3.58), (0.0, 1.0)),
    "assembly_table4": ((-13.2, -12.2), (-3.58, -2.42), (0.0, 1.0)),
    "bin1": ((-2.234, -1.566), (3.041, 3.709), (0.0, 0.79)),
    "bin8": ((-2.984, -2.316), (-3.709, -3.041), (0.0, 0.79)),
    "conveyor": ((-0.94, -0.15), (-4.51, 4.50), (0.0, 0.92)),
    "kit_tray_table2": ((-1.98, -0.62), (5.27, 6.19), (0.0, 0.73)),
    "disposal_bin1": ((-2.565, -1.835), (-0.435, 0.435), (0.0, 0.48)),
    "warehouse_west": ((-22.0, -21.75), (-11.8, 11.8), (0.0, 4.0)),
    "warehouse_pier4": ((-16.25, -16.0), (-0.55, 0.55), (0.0, 4.0)),
}


@pytest.fixture(scope="module")
def ariac():
    return floorplan.load("ariac2023")


@pytest.mark.parametrize("name", FACTS)
def test_ariac_obstacles_are_where_the_competition_has_them(ariac, name):
    obstacle = ariac.obstacle(name)
    (x0, x1), (y0, y1), (bottom, top) = FACTS[name]
    assert obstacle.footprint.bounds == pytest.approx((x0, y0, x1, y1))
    assert (obstacle.bottom, obstacle.top) == (bottom, top)


def test_ariac_has_all_obstacles(ariac):
    kinds = [name.rstrip("0123456789") for name in (o.name for o in ariac.obstacles)]
    assert kinds.count("assembly_table") == 4
    assert kinds.count("bin") == 8
    assert kinds.count("kit_tray_table") == 2
    assert kinds.count("disposal_bin") == 3
    assert kinds.count("warehouse_pier") == 6
    assert [s.name for s in ariac.stations] == ["station1", "station2", "station3", "station4"]
    assert ariac.patrol == ("station4", "station2", "station1", "station3")
    assert [station.name for station in ariac.patrolled] == [*ariac.patrol]
    assert ariac.safe_zone == floorplan.SafeZone((-15.0, -10.0), math.pi)
    assert ariac.human == floorplan.Human(
        radius=0.3, height=1.75, max_speed=1.0, max_acceleration=2.5, goal_tolerance=0.25
    )


def test_people_walk_below_the_lintels_and_through_the_door(ariac):
    walking = ariac.free(0.0, ariac.human.height)
    assert walking.contains(shapely.Point(-16.1, -10.0))
    assert not walking.contains(shapely.Point(-16.1, -7.0))
    overhead = ariac.free(3.0, 3.5)
    assert not overhead.contains(shapely.Point(-16.1, -10.0))


@pytest.mark.parametrize(
    ("agv", "y"), [("agv1", 4.8), ("agv2", 1.2), ("agv3", -1.2), ("agv4", -4.8)]
)
def test_agvs_run_along_minus_x(ariac, agv, y):
    lane = ariac.lane(agv)
    for location, q in {"kitting": 0, "assembly_front": 5.6, "warehouse": 17}.items():
        assert lane.lane_position(location) == q
        assert lane.position(q) == pytest.approx((-2.27 - q, y), abs=1e-12)
    assert lane.footprint(0).bounds == pytest.approx(
        (-2.27 - 0.585, y - 0.335, -2.27 + 0.585, y + 0.335)
    )


def test_agvs_know_the_assembly_stations(ariac):
    assert ariac.lane("agv2").lane_position("as2") == 10.6
    assert ariac.lane("agv4").lane_position("as3") == 5.6
    with pytest.raises(ValueError, match="agv1 has no location 'as3'"):
        ariac.lane("agv1").lane_position("as3")
    with pytest.raises(ValueError, match="its lane runs from 0 to 18"):
        ariac.lane("agv1").lane_position(18.5)


def test_gantry_reports_a_pose_out_of_range(ariac):
    assert ariac.gantry.faults((-7.0, 0.0, 0.0)) == []
    faults = ariac.gantry.faults((1.0, -8.0, float("nan")))
    assert [fault.split(" = ")[0] for fault in faults] == ["x", "y", "rotation"]


@pytest.mark.parametrize("name", floorplan.builtin())
def test_every_builtin_floorplan_loads_and_pickles(name):
    plan = floorplan.load(name)
    assert plan.name == name
    assert plan.title
    assert pickle.loads(pickle.dumps(plan)) == plan


def test_an_unknown_name_is_answered_with_the_known_ones(ariac):
    assert ariac.stations["station2"] is ariac.stations[1] is ariac.station("station2")
    assert "station2" in ariac.stations
    assert "bin1" not in ariac.stations
    for things, name, near in (
        (ariac.stations, "staton1", "'station1'"),
        (ariac.lanes, "agv9", "'agv"),
        (ariac.obstacles, "conveyer", "'conveyor'"),
        (floorplan.Floorplan(name="hall", boundary=shapely.box(0, 0, 1, 1)).lanes, "agv1", "none"),
    ):
        with pytest.raises(KeyError, match=near):
            things[name]


def test_named_objects_stay_plain_values(ariac):
    listed = replace(ariac, stations=[*ariac.stations])
    assert listed == ariac
    assert hash(listed.stations) == hash(tuple(ariac.stations))
    assert asdict(ariac)["lanes"][0]["name"] == "agv1"
    assert copy.deepcopy(ariac) == ariac
    assert len(repr(ariac)) < 100


def test_values_are_shown_in_a_line_and_not_as_polygons():
    plan = floorplan.load("ariac2023")
    zone = floorplan.Zone(name="bay", area=plan.boundary, max_speed=0.5)
    values = [*plan.obstacles, *plan.stations, *plan.lanes, plan.gantry, plan.obstacles, zone]
    for value in (*values, plan, plan.safe_zone, plan.human, plan.gates):
        assert len(repr(value)) < 120 and "POLYGON" not in repr(value)
    assert "'assembly_table1'" in repr(plan.obstacles) and "27 more" in repr(plan.obstacles)
    assert repr(zone) == "<Zone 'bay': 24 x 24 m, at most 0.5 m/s>"


def test_a_notebook_shows_a_small_picture():
    shown = floorplan.load("ariac2023")._repr_html_()
    assert "ariac2023" in shown and shown.count("<path") == 3 and shown.count("<circle") == 4
    assert len(shown) < 5000
    square = shapely.box(0, 0, 9, 9)
    stations = (floorplan.Station("<b>", (1.0, 1.0)),)
    shown = floorplan.Floorplan(name="<i>", boundary=square, stations=stations)._repr_html_()
    assert "<b>" not in shown and "<i>" not in shown
