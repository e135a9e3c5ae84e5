import math

import pytest

import floorplan

ezdxf = pytest.importorskip("ezdxf")

HALL = [(0, 0), (10, 0), (10, 6), (0, 6)]
BENCH = [(2, 2), (4, 2), (4, 3), (2, 3)]


@pytest.fixture
def drawing():
    drawing = ezdxf.new(setup=False)
    drawing.units = ezdxf.units.M
    for layer in ("boundary", "bench", "pillar"):
        drawing.layers.add(layer)
    return drawing


@pytest.fixture
def load(drawing, tmp_path):
    def load():
        drawing.saveas(tmp_path / "shop.dxf")
        return floorplan.load(tmp_path / "shop.dxf")

    return load


def outline(drawing, points, layer, close=True, **more):
    return drawing.modelspace().add_lwpolyline(
        points, close=close, dxfattribs={"layer": layer, **more}
    )


def test_outlines_by_layer(drawing, load):
    outline(drawing, HALL, "boundary")
    outline(drawing, BENCH, "bench")
    outline(drawing, [(x + 4, y) for x, y in BENCH], "bench", elevation=0.5, thickness=0.4)
    drawing.modelspace().add_circle((8, 5), 0.25, dxfattribs={"layer": "pillar"})
    drawing.modelspace().add_text("Hall 3", dxfattribs={"layer": "bench"})
    plan = load()
    assert plan.name == "shop"
    assert plan.boundary.bounds == (0, 0, 10, 6)
    assert [o.name for o in plan.obstacles] == ["bench1", "bench2", "pillar"]
    assert plan.obstacle("bench1").footprint.bounds == (2, 2, 4, 3)
    assert (plan.obstacle("bench1").bottom, plan.obstacle("bench1").top) == (0.0, 3.0)
    assert plan.obstacle("bench2").bottom == pytest.approx(0.5)
    assert plan.obstacle("bench2").top == pytest.approx(0.9)
    assert plan.obstacle("pillar").footprint.area == pytest.approx(math.pi / 16, rel=0.02)


@pytest.mark.parametrize(("unit", "metre"), [(4, 0.001), (5, 0.01), (1, 0.0254), (0, 1.0)])
def test_units(drawing, load, unit, metre):
    drawing.header["$INSUNITS"] = unit
    outline(drawing, HALL, "Boundary")
    assert load().boundary.bounds == pytest.approx((0, 0, 10 * metre, 6 * metre))


def test_other_ways_to_draw_an_outline(drawing, load):
    # Closed by its last corner, and an old polyline with heights.
    outline(drawing, [*HALL, HALL[0]], "boundary", close=False)
    drawing.modelspace().add_polyline3d(
        [(x, y, 0) for x, y in BENCH], close=True, dxfattribs={"layer": "bench"}
    )
    # A bulge of 1 is a half circle.
    drawing.modelspace().add_lwpolyline(
        [(6, 2, 1), (8, 2, 0)], format="xyb", close=True, dxfattribs={"layer": "pillar"}
    )
    plan = load()
    assert plan.boundary.area == pytest.approx(60)
    assert plan.obstacle("bench").footprint.area == pytest.approx(2)
    assert plan.obstacle("pillar").footprint.area == pytest.approx(math.pi / 2, rel=0.01)


def test_numbers_do_not_lead_to_the_name_of_another_layer(drawing, load):
    drawing.layers.add("bench2")
    outline(drawing, HALL, "boundary")
    for k, layer in enumerate(("bench", "bench2", "bench")):
        outline(drawing, [(x / 4 + 2 * k, y) for x, y in BENCH], layer)
    names = [obstacle.name for obstacle in load().obstacles]
    assert sorted(names) == ["bench1", "bench2", "bench3"]


def test_layers_that_are_off_are_left_out(drawing, load):
    outline(drawing, HALL, "boundary")
    outline(drawing, BENCH, "bench", close=False)
    drawing.layers.get("bench").off()
    assert load().obstacles == ()


def test_everything_wrong_is_said_at_once(drawing, load):
    outline(drawing, HALL, "boundary")
    outline(drawing, BENCH, "bench", close=False)
    outline(drawing, [(0, 0), (1, 1), (1, 0), (0, 1)], "bench")
    outline(drawing, [(0, 0), (1, 1)], "bench")
    drawing.modelspace().add_line((0, 0), (1, 1), dxfattribs={"layer": "pillar"})
    drawing.modelspace().add_line((0, 0), (1, 1), dxfattribs={"layer": "pillar"})
    with pytest.raises(floorplan.FloorplanError) as wrong:
        load()
    assert len(wrong.value.problems) == 4
    text = str(wrong.value)
    assert "shop.dxf: 4 problems" in text
    assert "layer 'bench', LWPOLYLINE" in text
    assert "is open; close it" in text
    assert "is not a simple polygon" in text
    assert "layer 'pillar': 2 LINE can't be read as outlines" in text


def test_one_boundary(drawing, load):
    outline(drawing, BENCH, "bench")
    with pytest.raises(floorplan.FloorplanError) as wrong:
        load()
    assert "expected one outline on the layer 'boundary', found 0" in str(wrong.value)
    assert "layers with outlines: bench" in str(wrong.value)
    outline(drawing, HALL, "boundary")
    outline(drawing, HALL, "BOUNDARY")
    with pytest.raises(floorplan.FloorplanError, match="found 2"):
        load()


def test_no_drawing(tmp_path):
    with pytest.raises(floorplan.FloorplanError, match="no such file"):
        floorplan.load(tmp_path / "none.dxf")
    (tmp_path / "text.dxf").write_text("hello\n")
    with pytest.raises(floorplan.FloorplanError, match=r"text\.dxf: is not a DXF drawing"):
        floorplan.load(tmp_path / "text.dxf")
    (tmp_path / "empty.dxf").write_text("")
    with pytest.raises(floorplan.FloorplanError, match=r"empty\.dxf: "):
        floorplan.load(tmp_path / "empty.dxf")


def test_a_drawing_may_be_cut_anywhere(drawing, tmp_path):
    outline(drawing, HALL, "boundary")
    whole, cut = tmp_path / "whole.dxf", tmp_path / "cut.dxf"
    drawing.saveas(whole)
    data = whole.read_bytes()
    for length in (*range(100), *range(100, len(data) - 50, 797)):
        cut.write_bytes(data[:length])
        with pytest.raises(floorplan.FloorplanError):
            floorplan.load(cut)
