import pytest
import shapely
from hypothesis import given, strategies as st
from sample_files import files

import floorplan


def write(folder, text, name="hall.wkt"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


HALL = "POLYGON ((0 0, 10 0, 10 6, 0 6, 0 0), (2 2, 3 2, 3 3, 2 3, 2 2), (5 2, 6 2, 6 4, 5 2))"


def test_walkable_area_with_holes(tmp_path):
    plan = floorplan.load(write(tmp_path, HALL))
    assert plan.name == "hall"
    assert plan.boundary.bounds == (0, 0, 10, 6)
    assert [o.name for o in plan.obstacles] == ["obstacle1", "obstacle2"]
    assert plan.free(0, 1.75).equals(shapely.from_wkt(HALL))
    assert all((o.bottom, o.top) == (0.0, 3.0) for o in plan.obstacles)


def test_polygons_that_touch_are_one_floor(tmp_path):
    text = "GEOMETRYCOLLECTION (POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0)), MULTIPOLYGON ("
    text += "((4 1, 8 1, 8 3, 4 3, 4 1)), ((7 0, 9 0, 9 9, 7 9, 7 0))))"
    plan = floorplan.load(write(tmp_path, text))
    assert plan.boundary.area == pytest.approx(16 + 6 + 18)
    assert plan.obstacles == ()


def test_heights_in_the_text_are_ignored(tmp_path):
    plan = floorplan.load(write(tmp_path, "POLYGON Z ((0 0 1, 4 0 1, 4 4 1, 0 4 1, 0 0 1))"))
    assert plan.boundary.area == 16
    assert not plan.boundary.has_z


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("POLYGON ((0 0, 1 0, 1 1, 0 1", "is not well-known text"),
        ("", "is not well-known text"),
        ("walls", "is not well-known text"),
        ("ü(", "is not well-known text"),
        ("ü" * 600 + "(", "is not well-known text"),
        ("POLYGON EMPTY", "is empty: there is no area to walk on"),
        ("GEOMETRYCOLLECTION EMPTY", "is empty"),
        ("LINESTRING (0 0, 1 1)", "expected a POLYGON, found a LINESTRING"),
        ("GEOMETRYCOLLECTION (POLYGON ((0 0, 4 0, 4 4, 0 0)), POINT (1 1))", "polygon 2 of 2"),
        ("POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0), (5 5, 6 5, 6 6, 5 5))", "Hole lies outside shell"),
        ("POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))", "is not a simple polygon: edges cross at"),
        ("POLYGON ((0 0, 4 0, 2 2, 4 4, 0 4, 2 2, 0 0))", "is not a simple polygon"),
        ("POLYGON ((0 0, 4 0, 2 0, 0 0))", "polygon"),
        ("MULTIPOLYGON (((0 0, 1 0, 1 1, 0 0)), ((5 5, 6 5, 6 6, 5 5)))", "2 separate areas"),
        ("POLYGON ((0 0, 4 0, nan 4, 0 0))", "not numbers of at most 1e+10 m"),
        ("POLYGON ((0 0, 4e10 0, 4 4, 0 0))", "not numbers of at most 1e+10 m"),
    ],
)
def test_an_invalid_text_is_rejected(tmp_path, text, words):
    with pytest.raises(floorplan.FloorplanError) as wrong:
        floorplan.load(write(tmp_path, text))
    assert words in str(wrong.value)
    assert "hall.wkt" in str(wrong.value)
    assert "\n" not in str(wrong.value)


def test_a_missing_file_is_reported():
    with pytest.raises(floorplan.FloorplanError, match="no such file"):
        floorplan.load("nowhere.wkt")


@given(st.text(alphabet="POLYGN()0123. ,-e\n", max_size=60))
def test_any_text_is_a_floor_or_one_clear_error(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("text") / "any.wkt"
    path.write_text(text)
    try:
        plan = floorplan.load(path)
    except floorplan.FloorplanError:
        return
    assert plan.boundary.is_valid


@pytest.mark.parametrize(
    "path", files("rooms.wkt", "annex.wkt", real="floors/*.wkt"), ids=lambda path: path.stem
)
def test_free_space_on_floors_of_jupedsim(path):
    area = shapely.union_all(list(shapely.from_wkt(path.read_text()).geoms))
    assert floorplan.load(path).free(0, 1.75).equals(area)
