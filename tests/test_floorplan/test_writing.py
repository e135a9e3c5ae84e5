"""Floors that are written and read again stay the same."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, strategies as st
from shapely.geometry import Point, Polygon, box

import floorplan

BUILT_IN = [floorplan.load(name) for name in floorplan.builtin()]
RING = box(3, 3, 6, 6).difference(box(4, 4, 5, 5))
PLAN = floorplan.Floorplan(
    name="yard: 1",
    boundary=box(0, 0, 20, 12).difference(box(15, 9, 16, 10)),
    obstacles=[
        floorplan.Obstacle(name="press", footprint=box(6.1, 4.2, 9, 12), bottom=0.0, top=2.0),
        floorplan.Obstacle(name="pillar", footprint=Point(13, 5).buffer(0.5), bottom=0.0, top=3.0),
        floorplan.Obstacle(name="1e3", footprint=RING, bottom=0.0, top=1e-5),
        floorplan.Obstacle(
            name="beam", footprint=Polygon([(0, 0), (1, 0), (0, 1)]), bottom=2.5, top=3.0
        ),
    ],
    stations=[floorplan.Station("gate", (18, 8)), floorplan.Station("no", (18.1, 8))],
    patrol=("no", "gate", "no"),
    safe_zone=floorplan.SafeZone((1.5, 1.5), 0.1),
    human=floorplan.Human(radius=0.25),
    lanes=[
        floorplan.Lane(
            name="a",
            origin=(2, 10),
            heading=0.0,
            limits=(0, 3),
            locations={"home": 0.0},
            start="home",
            length=1,
            width=0.5,
            height=1,
            max_speed=2,
            max_acceleration=2,
        ),
        floorplan.Lane(
            name="b",
            origin=(2, 8),
            heading=0.1,
            limits=(-1, 2),
            locations={"x": 1.0},
            start="x",
            length=1,
            width=0.6,
            height=1,
            max_speed=2,
            max_acceleration=3,
            serves={"out": "x"},
        ),
    ],
    title="A yard",
)


@pytest.mark.parametrize("plan", [PLAN, *BUILT_IN])
def test_floorwalkers_own_format_contains_everything(plan, tmp_path):
    plan.save(tmp_path / "floor.yaml")
    assert floorplan.load(tmp_path / "floor.yaml") == plan
    assert floorplan.parse(replace(plan, patrol=()).to_yaml()).patrol == ()


def test_numbers_and_flags_of_numpy_are_written_as_plain_values():
    door = floorplan.Door(
        name="in", ends=np.array([(2.0, 0.5), (3.0, 0.5)]), is_open=np.False_, height=np.float64(2)
    )
    zones = [
        floorplan.Zone(name="out", area=box(4, 0, 5, 1), forbidden=np.True_, concerns=("a*",)),
        floorplan.Zone(name="slow", area=box(4, 2, 5, 3), max_speed=np.float32(0.5)),
    ]
    plan = floorplan.Floorplan(name="room", boundary=box(0, 0, 9, 9), doors=[door], zones=zones)
    again = floorplan.parse(plan.to_yaml())
    assert again.doors == (replace(door, ends=((2.0, 0.5), (3.0, 0.5))),)
    assert again.zones == plan.zones


@pytest.mark.parametrize("plan", BUILT_IN)
def test_geojson_contains_the_obstacles_of_the_floor(plan, tmp_path, floorwalker):
    plan.save(tmp_path / "floor.yaml")
    plan.save(tmp_path / "floor.geojson")
    again = floorplan.load(tmp_path / "floor.geojson")
    for name in ("boundary", "obstacles", "stations", "safe_zone"):
        assert getattr(again, name) == getattr(plan, name)
    done = floorwalker("convert", tmp_path / "floor.yaml", tmp_path / "converted.geojson")
    _, _, words = done.stderr.strip().partition(" cannot contain: ")
    assert words == ", ".join(
        words
        for words, contained in (
            ("AGVs", plan.lanes),
            ("the gantry", plan.gantry),
            ("the patrol", plan.patrol),
            ("measures of people", plan.human != floorplan.Human()),
        )
        if contained
    )


@pytest.mark.parametrize("plan", BUILT_IN)
def test_wkt_contains_the_walkable_area(plan, tmp_path):
    plan.save(tmp_path / "floor.wkt")
    area = floorplan.load(tmp_path / "floor.wkt").free(0, 1)
    assert area.symmetric_difference(plan.free(0, plan.human.height)).area < 1e-9


corners = st.floats(0.5, 8.0).map(lambda value: round(value, 3))
sizes = st.floats(0.05, 2.0)


@given(st.lists(st.tuples(corners, corners, sizes, sizes), max_size=5), st.floats(0.05, 0.3))
def test_a_map_shows_no_free_space_that_is_not_free(tmp_path_factory, rectangles, resolution):
    blocks = [
        floorplan.Obstacle(name=f"o{k}", footprint=box(x, y, x + w, y + h), bottom=0.0, top=1.0)
        for k, (x, y, w, h) in enumerate(rectangles)
    ]
    plan = floorplan.Floorplan(name="hall", boundary=box(0, 0, 10.0, 9.0), obstacles=blocks)
    path = tmp_path_factory.mktemp("map") / "hall.yaml"
    plan.save(path, resolution=resolution)
    again = floorplan.load(path).free(0, 1)
    area = plan.free(0, 1)
    # Outlines move by less than half a cell when a map is read.
    assert area.buffer(0.46 * resolution).covers(again)
    core = area.buffer(-2 * math.sqrt(2) * resolution)
    largest = max(shapely.get_parts(core), key=lambda part: part.area)
    assert again.buffer(1e-9).covers(largest)


def test_a_floor_that_cannot_be_written_is_reported(tmp_path):
    def says(match, plan, name, kind=ValueError, **more):
        with pytest.raises(kind, match=match):
            plan.save(tmp_path / name, **more)

    says(r"files that end in one of \.yaml", PLAN, "floor.dxf")
    says("a resolution belongs to a ROS map", PLAN, "floor.wkt", resolution=0.1)
    says("a resolution belongs to a ROS map", PLAN, "floor.pgm", resolution=0.0)
    says("is too large", PLAN, "floor.pgm", resolution=0.001)
    wall = floorplan.Obstacle(name="wall", footprint=box(9, -1, 10, 13), bottom=0.0, top=2.0)
    hall = floorplan.Floorplan(name="hall", boundary=box(0, 0, 20, 12), obstacles=[wall])
    says("walk on 2 separate areas", hall, "floor.wkt")
    full = replace(hall, obstacles=[replace(wall, footprint=box(-1, -1, 21, 13))])
    says("walk nowhere", full, "floor.pgm")
    crossed = replace(hall, boundary=Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]))
    says("boundary: is not a simple polygon", crossed, "floor.yaml", floorplan.FloorplanError)
    assert not [*tmp_path.iterdir()]


def test_a_file_that_could_not_be_read_again_is_not_written(tmp_path, monkeypatch):
    plan = floorplan.load("warehouse")
    monkeypatch.setattr("floorplan.plan.MOST_TEXT", 1000)
    with pytest.raises(ValueError, match="of more than 1,000 can't be read"):
        plan.save(tmp_path / "floor.yaml")
    assert not (tmp_path / "floor.yaml").exists()


def test_arrays_of_doors_gates_and_the_safe_zone_are_written_as_numbers():
    plan = floorplan.Floorplan(
        name="hall",
        boundary=box(0, 0, 10, 6),
        doors=[
            floorplan.Door(
                name="d",
                ends=np.array([[5.0, 0.0], [5.0, 6.0]]),
                is_open=np.bool_(False),
                thickness=np.float64(0.2),
            )
        ],
        gates=[floorplan.Gate(name="g", ends=((7, 0), (7, 6)), towards=np.array([8.0, 1.0]))],
        safe_zone=floorplan.SafeZone(np.array([1.0, 1.0])),
    )
    again = floorplan.parse(plan.to_yaml())
    assert again.doors["d"].ends == ((5.0, 0.0), (5.0, 6.0))
    assert not again.doors["d"].is_open
    assert again.doors["d"].thickness == 0.2
    assert again.gates["g"].towards == (8.0, 1.0)
    assert again.safe_zone == floorplan.SafeZone((1.0, 1.0))


@pytest.mark.parametrize(
    ("keys", "place"),
    [
        ("doors: {d: {betwen: [[5, 0], [5, 6]]}}", "doors.d.betwen"),
        ("doors: {d: {between: [[5, 0], [5, 6]], name: x}}", "doors.d.name"),
        ("doors: {d: {between: [[5, 0], [5, 6]], is_open: true}}", "doors.d.is_open"),
        ("gates: {g: {between: [[5, 0], [5, 6]], toward: [1, 1]}}", "gates.g.toward"),
        ("safe_zone: {position: [1, 1]}", "safe_zone.position"),
    ],
)
def test_only_the_names_of_keys_are_read_and_suggested(keys, place):
    with pytest.raises(floorplan.FloorplanError) as info:
        floorplan.parse(f"name: hall\nboundary: [[0, 0], [9, 0], [9, 6], [0, 6]]\n{keys}\n")
    problem = next(one for one in info.value.problems if one.field == place)
    assert problem.message.startswith("unknown key; ")
    assert problem.line == 3
    assert "\0" not in problem.message
    assert "'name'" not in problem.message
