"""Floors made in Python are checked by the rules of floorplan files."""

from dataclasses import replace

import pytest
from shapely.geometry import Polygon, box

import floorplan
from floorplan import Door, Floorplan, Human, Obstacle, SafeZone, Station
from navigation import CollisionWorld

SHOP = Floorplan(name="shop", boundary=box(0, 0, 10, 10))
CELL = floorplan.load("ariac2023")
CROSSED = Polygon([(3, 3), (7, 7), (7, 3), (3, 7)])


def press(footprint, bottom=0.0, top=1.0):
    return {"obstacles": (Obstacle(name="press", footprint=footprint, bottom=bottom, top=top),)}


CART = {"lanes": (replace(CELL.lanes[0], origin=(2.0, 5.0), heading=0.0, limits=(0.0, 17.0)),)}
"""Its AGV is 0.67 m wide, 1.21 m high, and stands at the origin of its lane."""


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"boundary": CROSSED}, r"boundary: .*edges cross at \[5 5\]"),
        (press(CROSSED), r"obstacles.press: .*edges cross at \[5 5\]"),
        (press(Polygon()), "obstacles.press: encloses no area"),
        (press(box(1, 1, 2, 2), 1.0, 0.5), r"obstacles.press.z: must rise .* 1 … 0.5"),
        (press(box(1, 1, 2, 2), float("nan")), r"obstacles.press.z: must rise .* nan … 1"),
        (
            {"obstacles": (Obstacle(name="a", footprint=box(1, 1, 2, 2), bottom=0, top=1),) * 2},
            "obstacles.a: 2 of them",
        ),
        ({"stations": (Station("a", (1, 1)), Station("a", (2, 2)))}, "stations.a: 2 of them"),
        ({"stations": (Station("a", (11, 1)),)}, r"stations.a: \(11, 1\) is outside"),
        ({"safe_zone": SafeZone((0.1, 5.0))}, "safe_zone.at: .*does not fit"),
        ({"patrol": ("nowhere",)}, "patrol: no station is called 'nowhere'"),
        ({"human": Human(radius=-0.1)}, "human.radius: must be more than 0 .* not -0.1"),
        ({"human": Human(max_speed=float("nan"))}, "human.max_speed: must be more than 0"),
        ({"human": Human(max_speed=1e-300)}, "human.max_speed: must be at least 1e-06"),
        ({"boundary": box(0, 0, 5e6, 9)}, "boundary: is more than 1,000,000 m long"),
        ({"lanes": (replace(CELL.lanes[0], start="away"),)}, "agvs.lanes.agv1: .*'away'"),
        ({"lanes": CELL.lanes[:1] * 2}, "agvs.lanes.agv1: 2 of them"),
        (CART | {"safe_zone": SafeZone((2.1, 4.9))}, r"safe_zone.at: .* is inside agv1, which st"),
        (CART | press(box(5, 4, 5.2, 4.8)), r"agv1: agv1 drives through obstacle 'press'"),
        ({"gantry": replace(CELL.gantry, start=(9.0, 0.0, 0.0))}, "gantry.start: x = 9"),
    ],
)
def test_an_impossible_floor_is_rejected(changes, message):
    plan = replace(SHOP, **changes)
    with pytest.raises(floorplan.FloorplanError, match=message) as error:
        floorplan.check(plan)
    assert str(error.value).startswith("floorplan 'shop': ")
    with pytest.raises(floorplan.FloorplanError, match=message):
        CollisionWorld(plan)


@pytest.mark.parametrize("changes", [press(box(5, 4, 5.2, 4.665)), press(box(5, 4, 6, 6), 1.21, 3)])
def test_an_agv_may_pass_close_by_and_below(changes):
    floorplan.check(replace(SHOP, **CART | changes))


@pytest.mark.parametrize("name", floorplan.builtin())
def test_every_builtin_floor_is_valid(name):
    floorplan.check(replace(floorplan.load(name)))


def test_all_problems_are_reported_at_once():
    plan = replace(SHOP, human=Human(radius=0.0), patrol=("nowhere",), boundary=CROSSED)
    with pytest.raises(floorplan.FloorplanError, match="3 problems"):
        floorplan.check(plan)


def test_a_door_without_width_hides_no_problem_of_others():
    doors = [
        Door(name="slit", ends=((1.0, 1.0), (1.0, 1.0))),
        Door(name="far", ends=((1.0, 1.0), (99.0, 1.0))),
    ]
    with pytest.raises(floorplan.FloorplanError, match=r"(?s)slit.*far.*outside the boundary"):
        floorplan.check(replace(SHOP, doors=doors))
