"""Floors laid over other floors."""

import json
import math
from textwrap import dedent

import pytest

import floorplan

HALL = """\
boundary: [[0, 0], [10, 0], [10, 6], [0, 6]]
obstacles:
  press: {x: [2, 4], y: [2, 3], z: [0, 1]}
  shelf1: {x: [6, 7], y: [1, 2], z: [0, 2]}
  shelf2: {x: [6, 7], y: [4, 5], z: [0, 2]}
stations: {dock: [1, 1], gate: [9, 5]}
human: {max_speed: 1.5}
"""


@pytest.fixture
def lay(tmp_path):
    def lay(text, base=HALL, name="hall.yaml"):
        (tmp_path / name).write_text(base)
        (tmp_path / "floor.yaml").write_text(f"base: {name}\n" + dedent(text))
        return floorplan.load(tmp_path / "floor.yaml")

    return lay


def problems(lay, *arguments, **more):
    with pytest.raises(floorplan.FloorplanError) as wrong:
        lay(*arguments, **more)
    return [str(problem) for problem in wrong.value.problems]


def test_a_floor_is_laid_over_another_and_corrects_it(lay):
    plan = lay("""\
        name: line 2
        remove: [shelf*]
        move: {press: [0.5, 1]}
        rename: {press: old press}
        obstacles: {press: {x: [6, 7], y: [2, 3], z: [0, 1]}}
        stations: {gate: [9, 1], bench: [5, 5]}
        safe_zone: {at: [1, 5]}
    """)
    assert plan.name == "line 2"
    assert [o.name for o in plan.obstacles] == ["old press", "press"]
    assert plan.obstacles["old press"].footprint.bounds == (2.5, 3, 4.5, 4)
    assert {s.name: s.position for s in plan.stations} == {
        "dock": (1, 1),
        "gate": (9, 1),
        "bench": (5, 5),
    }
    assert plan.human.max_speed == 1.5
    assert plan.safe_zone == floorplan.SafeZone((1, 5))


def test_the_floor_is_turned_about_its_origin(lay):
    plan = lay("""\
        origin: [10, 0]
        rotation: 1.5707963267948966
        safe_zone: {at: [9, 1]}
        agvs:
          size: [1, 0.5]
          height: 1
          max_speed: 1
          max_acceleration: 1
          limits: [0, 3]
          locations: {home: 0}
          start: home
          lanes: {agv1: {origin: [9, 2.5], heading: 1.5707963267948966}}
    """)
    assert plan.boundary.bounds == (-6, -10, 0, 0)
    assert plan.stations["dock"].position == (-1, -9)
    assert plan.safe_zone.position == (-1, -1)
    assert plan.safe_zone.heading == pytest.approx(math.pi / 2)
    assert plan.lanes[0].position(1.0) == pytest.approx((-3.5, -1))


def test_units_of_the_floor_on_top_apply(lay):
    plan = lay("""\
        units: cm
        stations: {bench: [500, 500]}
        obstacles: {post: {center: [900, 300], radius: 10, z: [0, 250]}}
        move: {press: [50, 0]}
    """)
    assert plan.boundary.bounds == (0, 0, 10, 6)
    assert plan.stations["bench"].position == (5, 5)
    assert plan.obstacles["press"].footprint.bounds == (2.5, 2, 4.5, 3)
    assert plan.obstacles["post"].top == 2.5
    assert plan.human.radius == 0.3


def test_wrong_corrections_have_their_lines(lay):
    reported = problems(lay, "remove: [shelf*, pres]\nmove: {shelf1: [0, 1]}\nrename: {a: b}\n")
    assert reported == [
        "line 2, remove[1]: no obstacle of the base is called 'pres'; did you mean 'press'?",
        "line 3, move.shelf1: 'shelf1' is removed as well",
        "line 4, rename.a: no obstacle of the base is called 'a'; there are: press, shelf1, shelf2",
    ]
    reported = problems(
        lay, "origin: [1, 0]\nobstacles: {box: {x: [0, 2], y: [0, 2], z: [0, 1]}}\n"
    )
    assert reported == ["line 1, stations.dock: (0, 1) is inside obstacle 'box'"]


@pytest.mark.parametrize(("at", "hinted"), [("[20, 3]", False), ("[4000, 900]", True)])
def test_lengths_that_may_be_in_another_unit_have_a_hint(lay, at, hinted):
    reported = problems(lay, f"stations: {{gate: {at}}}\n")
    assert ("line 1, base: lengths in this file are metres" in reported[0]) == hinted
    assert "outside the boundary" in reported[-1] and len(reported) == 1 + hinted


def test_keys_without_their_base(tmp_path):
    text = "boundary: [[0, 0], [1, 0], [1, 1]]\nsnap: 0.1\nrename: {a: b}\n"
    with pytest.raises(floorplan.FloorplanError) as wrong:
        floorplan.parse(text)
    assert [p.line for p in wrong.value.problems] == [2, 3]
    (tmp_path / "a.yaml").write_text("base: ariac2023\nsnap: 0.1\n")
    with pytest.raises(floorplan.FloorplanError, match="line 2, snap: only a drawing"):
        floorplan.load(tmp_path / "a.yaml")
    (tmp_path / "a.yaml").write_text("base: ariac2023\nrotation: 0.1\n")
    with pytest.raises(
        floorplan.FloorplanError, match="line 2, rotation: a gantry can't be turned"
    ):
        floorplan.load(tmp_path / "a.yaml")


def test_a_base_must_be_there_and_not_above_itself(tmp_path):
    (tmp_path / "a.yaml").write_text("base: b.yaml\n")
    with pytest.raises(floorplan.FloorplanError, match="line 1, base: no such file"):
        floorplan.load(tmp_path / "a.yaml")
    (tmp_path / "b.yaml").write_text("base: a.yaml\n")
    with pytest.raises(floorplan.FloorplanError, match=r"'a.yaml' lies below itself"):
        floorplan.load(tmp_path / "a.yaml")


def test_a_base_may_be_a_text(lay):
    wkt = (
        "POLYGON ((0 0, 1000 0, 1000 600, 0 600, 0 0),"
        "(200 200, 400 200, 400 300, 200 300, 200 200))"
    )
    plan = lay("units: cm\nrename: {obstacle1: press}\n", wkt, "hall.wkt")
    assert plan.boundary.bounds == (0, 0, 10, 6)
    assert plan.obstacles["press"].footprint.bounds == (2, 2, 4, 3)
    assert plan.obstacles["press"].top == 3


def collection(*features):
    return json.dumps(
        {
            "type": "FeatureCollection",
            "units": "m",
            "features": [
                {"type": "Feature", "properties": p, "geometry": {"type": t, "coordinates": c}}
                for p, t, c in features
            ],
        }
    )


def ring(x0, y0, x1, y1):
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]


def test_geojson(lay, tmp_path):
    drawing = collection(
        ({"layer": "Boundary"}, "Polygon", [ring(0, 0, 10, 6)]),
        ({"layer": "A-WALL-1", "top": 2.5}, "Polygon", [ring(1, 1, 4, 4), ring(2, 2, 3, 3)]),
        ({"layer": "A-WALL-2"}, "MultiPolygon", [[ring(5, 1, 6, 2)], [ring(7, 1, 8, 2)]]),
        ({"layer": "notes"}, "LineString", [[0, 0], [1, 1]]),
        ({"kind": "station", "name": "gate"}, "Point", [9, 5]),
    )
    plan = lay("layers: {boundary: [boundary], walls: [A-WALL*]}", drawing, "hall.geojson")
    assert [o.name for o in plan.obstacles] == ["walls1", "walls2", "walls3", "walls4"]
    assert plan.free(0, 1).area == pytest.approx(60 - 8 - 2)
    assert {o.top for o in plan.obstacles} == {2.5, 3.0}
    assert plan.stations["gate"].position == (9, 5)
    assert [p.field for p in plan.notices] == ["layer 'notes', features[3]"]
    (tmp_path / "one.geojson").write_text(
        json.dumps(
            {"type": "Polygon", "units": "m", "coordinates": [ring(0, 0, 10, 6), ring(2, 2, 3, 3)]}
        )
    )
    assert floorplan.load(tmp_path / "one.geojson").obstacles["obstacle1"].footprint.area == 1


def test_wrong_geojson(tmp_path):
    path = tmp_path / "hall.geojson"

    def found(text):
        path.write_text(text)
        return problems(floorplan.load, path)

    assert found('{"trial": "a"}') == ["is not GeoJSON: it has no type, as 'FeatureCollection'"]
    assert found('{"type": \n"Poly') == ["line 2: is not JSON: Unterminated string starting at"]
    degrees = {"type": "Polygon", "coordinates": [], "crs": {"properties": {"name": "EPSG:4326"}}}
    assert "are degrees" in found(json.dumps(degrees))[0]
    assert found(
        collection(
            ({}, "Point", [1, 1]),
            ({"kind": "desk"}, "Point", [1, 1]),
            ({"kind": "obstacle"}, "LineString", [[0, 0], [1, 1]]),
            ({"kind": "obstacle", "top": "high"}, "Polygon", [ring(0, 0, 1, 1)]),
            ({"kind": "obstacle"}, "Polygon", [[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]]),
            ({"kind": "station"}, "Point", [1, 1]),
            ({"kind": "boundary"}, "Polygon", [[[0, 0]]]),
            ({"kind": "station", "name": "a"}, "Point", [1, "x"]),
        )
    )[:2] == [
        "features[0]: has neither kind nor layer; the kinds are boundary, obstacle, station,"
        " safe_zone",
        "features[1]: has the kind 'desk'; the kinds are boundary, obstacle, station, safe_zone",
    ]


def test_geojson_lines_have_a_width(lay, tmp_path):
    lines = ([[1, 1], [4, 1], [4, 4]], [[[6, 1], [8, 1]], [[6, 4], [8, 4]]])
    drawing = collection(
        ({"layer": "boundary"}, "Polygon", [ring(0, 0, 10, 6)]),
        ({"layer": "fence", "name": "east"}, "LineString", lines[0]),
        ({"layer": "fence"}, "MultiLineString", lines[1]),
        ({"kind": "obstacle", "name": "rail", "line_width": 0.2}, "LineString", [[1, 5], [9, 5]]),
    )
    text = "units: m\nlayers: {boundary: [boundary], fences: {layers: [fence], line_width: 0.1}}"
    plan = lay(text, drawing, "hall.geojson")
    assert plan.obstacles["east"].footprint.area == pytest.approx(6.1 * 0.1)
    assert [o.name for o in plan.obstacles] == ["east", "fences1", "fences2", "rail"]
    assert plan.obstacles["rail"].footprint.bounds == pytest.approx((0.9, 4.9, 9.1, 5.1))
    reported = problems(lay, "units: m\n", drawing, "hall.geojson")
    assert "LineString" in reported[0] and "line_width" in reported[0]


@pytest.mark.parametrize("whole", [True, False])
def test_geojson_without_a_crs_is_in_degrees_unless_it_says_metres(lay, tmp_path, whole):
    area = {"type": "Polygon", "coordinates": [ring(8.404, 49.013, 8.4042, 49.0132)]}
    data = area if whole else json.loads(collection(({"kind": "boundary"}, "Polygon", [[]])))
    if not whole:
        data["features"][0]["geometry"] = area
        del data["units"]

    def load(**more):
        (tmp_path / "a.geojson").write_text(json.dumps({**data, **more}))
        return floorplan.load(tmp_path / "a.geojson")

    (problem,) = problems(load)
    assert "degrees" in problem and '"units": "m"' in problem
    assert load(units="m").boundary.bounds[1] == 49.013
    assert load(units="cm").boundary.bounds[1] == pytest.approx(0.49013)
    assert load(crs={"type": "name", "properties": {"name": "EPSG:25832"}}).boundary
    (problem,) = problems(lambda: load(units="pc"))
    assert "units" in problem and "mm" in problem
    assert lay("units: m", json.dumps(data), "b.geojson").boundary.bounds[1] == 49.013


def test_a_floor_of_a_wrong_unit_is_noticed(lay, tmp_path):
    wkt = "POLYGON ((0 0, 20 0, 20 12, 0 12, 0 0))"
    (notice,) = lay("units: mm", wkt, "hall.wkt").notices
    assert "unit is mm" in notice.message and "`units`" in notice.message
    assert "person" in notice.message
    assert lay("units: m", wkt, "hall.wkt").notices == ()
    (tmp_path / "hall.wkt").write_text(wkt.replace("20", "20000").replace("12", "12000"))
    assert "10 km" in floorplan.load(tmp_path / "hall.wkt").notices[0].message
    (notice,) = floorplan.parse("boundary: [[0, 0], [20000, 0], [20000, 12000]]").notices
    assert "unit is m;" in notice.message


def test_one_notice_for_all_features_of_an_ignored_layer(lay):
    shapes = [({"layer": "notes"}, "Point", [k, 1]) for k in range(9)]
    drawing = collection(({"layer": "hall"}, "Polygon", [ring(0, 0, 200, 6)]), *shapes)
    plan = lay("layers: {boundary: [hall]}", drawing, "hall.geojson")
    assert [str(one) for one in plan.notices] == [
        "layer 'notes': 9 shapes are on a layer that no group has"
    ]
