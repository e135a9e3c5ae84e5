import math
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import dedent

import pytest
import shapely
from hypothesis import given, settings, strategies as st

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
    drawing.modelspace().add_line((1, 1), (1.05, 2), dxfattribs={"layer": "pillar"})
    with pytest.raises(floorplan.FloorplanError) as wrong:
        load()
    assert len(wrong.value.problems) == 5
    text = str(wrong.value)
    assert "shop.dxf: 5 problems" in text
    assert "layer 'bench', LWPOLYLINE" in text
    assert "is open; close it" in text
    assert "is not a simple polygon" in text
    assert text.count("layer 'pillar', LINE ") == 2


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


@pytest.fixture
def lay(drawing, tmp_path):
    """Save the drawing, and load the floor with this text on top of it."""

    def lay(text):
        drawing.saveas(tmp_path / "shop.dxf")
        (tmp_path / "floor.yaml").write_text("base: shop.dxf\n" + dedent(text))
        return floorplan.load(tmp_path / "floor.yaml")

    return lay


def problems(load, *given):
    with pytest.raises(floorplan.FloorplanError) as wrong:
        load(*given)
    return [str(problem) for problem in wrong.value.problems]


def test_lines_arcs_and_splines_that_meet_are_outlines(drawing, lay):
    space, wall = drawing.modelspace(), {"layer": "A-WALL-FULL"}
    outline(drawing, HALL, "boundary")
    # A slot of two lines and two half circles, one of them turned round; its ends miss by 5 mm.
    space.add_line((2, 1), (4, 1.005), dxfattribs=wall)
    space.add_line((4, 2), (2, 2), dxfattribs=wall)
    space.add_arc((4, 1.5), 0.5, 270, 90, dxfattribs=wall)
    space.add_arc((2, 1.5), 0.5, 90, 270, dxfattribs=wall)
    # A lens of a spline and a line that is drawn twice.
    space.add_spline([(6, 2), (7, 3), (8, 2)], dxfattribs=wall)
    for ends in (((6, 2), (8, 2)), ((8, 2), (6, 2))):
        space.add_line(*ends, dxfattribs=wall)
    layers = "layers: {boundary: [boundary], walls: [a-wall*]}\n"
    plan = lay(layers + "snap: 0.02")
    assert [o.name for o in plan.obstacles] == ["walls1", "walls2"]
    slot, lens = (o.footprint for o in plan.obstacles)
    assert slot.area == pytest.approx(2 + math.pi / 4, abs=0.01)
    assert lens.bounds == pytest.approx((6, 2, 8, 3), abs=2e-3)
    found = problems(lay, layers)
    assert len(found) == 4
    assert all("is open; close it" in one and "0.0050 m away" in one for one in found[:1])


def test_blocks_are_put_where_they_are_inserted(drawing, lay):
    outline(drawing, HALL, "boundary")
    leg = drawing.blocks.new("LEG")
    leg.add_lwpolyline([(0, 0), (1, 0), (1, 0.5)], close=True)  # on layer 0: that of the insert
    table = drawing.blocks.new("TABLE")
    table.add_blockref("LEG", (1, 0), dxfattribs={"xscale": -1})  # mirrored
    table.add_circle((0, 0), 1, dxfattribs={"layer": "notes"})
    space = drawing.modelspace()
    at = {"layer": "bench", "xscale": 2, "yscale": 1, "rotation": 90}
    handle = space.add_blockref("TABLE", (5, 1), dxfattribs=at).dxf.handle
    rows = {"layer": "bench", "column_count": 2, "column_spacing": 2}
    space.add_blockref("LEG", (6, 4), dxfattribs=rows)
    plan = lay("layers: {boundary: [boundary], benches: [bench]}")
    assert [o.name for o in plan.obstacles] == ["benches1", "benches2", "benches3"]
    # x of the leg is mirrored about 1, doubled and turned up; y comes to point to the left.
    corners = {(round(x, 9), round(y, 9)) for x, y in plan.obstacles[0].footprint.exterior.coords}
    assert corners == {(5, 3), (5, 1), (4.5, 1)}
    assert plan.obstacle("benches3").footprint.bounds == (8, 4, 9, 4.5)
    (left_out,) = plan.notices
    assert left_out.field.startswith(f"layer 'notes', INSERT {handle} (TABLE), ")


@given(
    inner=st.tuples(
        st.sampled_from([1, -1, 2, -0.5]), st.sampled_from([1, -2]), st.integers(0, 12)
    ),
    outer=st.tuples(
        st.sampled_from([1, -1, 2, -0.5]), st.sampled_from([1, -2]), st.integers(0, 12)
    ),
)
@settings(max_examples=30, deadline=None)
def test_blocks_in_blocks_stand_where_their_transforms_put_them(inner, outer):
    """Of a block turned in another that is stretched, right angles are none any more."""
    leg = shapely.Polygon([(0, 0), (0.4, 0), (0.4, 0.2)])
    drawing = ezdxf.new(units=ezdxf.units.M)
    block = drawing.blocks.new("LEG")
    block.add_lwpolyline(leg.exterior.coords[:-1], close=True)
    block.add_lwpolyline([(1, 1, -1), (1, 0.5, -1)], close=True, format="xyb")  # a disc
    within = (drawing.blocks.new("TABLE"), drawing.modelspace())
    footprints = [leg, shapely.Point(1, 0.75).buffer(0.25, quad_segs=90)]
    for name, at, (x, y, turn), space in zip(
        ("LEG", "TABLE"), ((0.3, 0.1), (5, 5)), (inner, outer), within, strict=True
    ):
        look = {"layer": "M", "xscale": x, "yscale": y, "rotation": 30 * turn}
        space.add_blockref(name, at, dxfattribs=look)
        a = math.radians(30 * turn)
        c, s = math.cos(a), math.sin(a)
        affine = [c * x, -s * y, s * x, c * y, *at]
        footprints = [shapely.affinity.affine_transform(f, affine) for f in footprints]
    corners = [(-9, -9), (20, -9), (20, 20), (-9, 20)]
    drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": "boundary"})
    with TemporaryDirectory() as folder:
        drawing.saveas(Path(folder, "shop.dxf"))
        plan = floorplan.load(Path(folder, "shop.dxf"))
    read = sorted((o.footprint for o in plan.obstacles), key=lambda f: len(f.exterior.coords))
    assert len(read) == 2
    assert read[0].hausdorff_distance(footprints[0]) < 1e-9
    assert read[1].hausdorff_distance(footprints[1]) < 2e-3


def test_a_block_in_itself_is_refused(drawing, load):
    outline(drawing, HALL, "boundary")
    block = drawing.blocks.new("LOOP")
    for _ in range(3):  # each of which would have three in it, and so on
        block.add_blockref("LOOP", (1, 0))
    drawing.modelspace().add_blockref("LOOP", (1, 1))
    assert "the block 'LOOP' contains itself" in problems(load)[0]


def test_hatches_hollow_walls_and_walls_by_their_centre_lines(drawing, lay):
    space = drawing.modelspace()
    outline(drawing, HALL, "walls")
    outline(drawing, [(0.5, 0.5), (4.8, 0.5), (4.8, 5.5), (0.5, 5.5)], "walls")
    outline(drawing, [(5.2, 0.5), (9.5, 0.5), (9.5, 5.5), (5.2, 5.5)], "walls")
    hatch = space.add_hatch(dxfattribs={"layer": "shafts"})
    hatch.paths.add_polyline_path([(1, 1), (3, 1), (3, 3), (1, 3)], is_closed=True)
    hatch.paths.add_polyline_path([(1.5, 1.5), (2.5, 1.5), (2.5, 2.5)], is_closed=True, flags=0)
    space.add_line((6, 3), (9, 3), dxfattribs={"layer": "fences"})
    plan = lay("""\
        boundary: [[0, 0], [10, 0], [10, 6], [0, 6]]
        layers:
          walls: {layers: [walls], hollow: true, z: [0, 4]}
          shafts: [shafts]
          fences: {layers: [fences], line_width: 0.1}
        stations: {left: [4, 4], shaft: [2.2, 1.85], right: [7, 1]}
        human: {radius: 0.1}
    """)
    assert plan.free(0, 1).area == pytest.approx(2 * 4.3 * 5 - 3.5 - 3.1 * 0.1)
    assert plan.free(3.5, 4).area == pytest.approx(2 * 4.3 * 5)
    assert all(not o.footprint.interiors for o in plan.obstacles)


def test_a_hollow_group_of_open_lines_is_told(drawing, lay):
    outline(drawing, HALL, "boundary")
    drawing.modelspace().add_line((2, 2), (4, 2), dxfattribs={"layer": "walls"})
    outline(drawing, [(5, 5)], "walls", close=False)
    groups = "layers: {boundary: [boundary], walls: {layers: [walls], hollow: true}}"
    found = problems(lay, groups)
    assert [one.count("has no length") for one in found] == [1, 0]
    assert "is open; close it" in found[1]


def test_a_layer_that_matches_nothing(drawing, lay):
    outline(drawing, HALL, "boundary")
    found = problems(lay, "layers: {boundary: [boundary], walls: [A-WALL*]}")
    assert "walls: no layer of the drawing matches 'A-WALL*'; there are: boundary" in found


def test_shapes_are_left_out_by_their_handles(drawing, lay):
    outline(drawing, HALL, "boundary")
    handle = outline(drawing, BENCH, "bench", close=False).dxf.handle
    plan = lay(f"leave_out: ['{handle}']")
    assert plan.obstacles == ()
    assert [str(one) for one in plan.notices] == [
        f"layer 'bench', LWPOLYLINE {handle}: is left out as asked"
    ]


def test_a_drawing_without_units_is_not_taken_for_metres_in_silence(drawing, load, lay):
    drawing.header["$INSUNITS"] = 0
    outline(drawing, [(1000 * x, 1000 * y) for x, y in HALL], "boundary")
    assert "gives no unit" in load().notices[0].message
    plan = lay("units: mm\norigin: [1000, 0]\nstations: {press: [5000, 3000]}")
    assert plan.boundary.bounds == (-1, 0, 9, 6)
    assert plan.stations["press"].position == (4, 3)
    assert plan.notices == ()
