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


def test_other_forms_of_an_outline(drawing, load):
    # The first is closed by its last corner, the second is an old polyline with heights.
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


def test_layers_that_are_off_are_omitted(drawing, load):
    outline(drawing, HALL, "boundary")
    outline(drawing, BENCH, "bench", close=False)
    drawing.layers.get("bench").off()
    assert load().obstacles == ()


def test_all_problems_are_reported_at_once(drawing, load):
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
    assert "no layer is called 'boundary'; the layers are 'bench'" in str(wrong.value)
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


def problems(load, *arguments):
    with pytest.raises(floorplan.FloorplanError) as wrong:
        load(*arguments)
    return [str(problem) for problem in wrong.value.problems]


def test_lines_arcs_and_splines_that_meet_are_outlines(drawing, lay):
    space, wall = drawing.modelspace(), {"layer": "A-WALL-FULL"}
    outline(drawing, HALL, "boundary")
    # A slot of two lines and two half circles, one of them reversed. Its ends miss by 5 mm.
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
    reported = problems(lay, layers)
    assert len(reported) == 4
    assert all(
        "is open; close it" in one and "0.005 m away; `snap: 0.005`" in one for one in reported[:1]
    )


def test_blocks_are_put_where_they_are_inserted(drawing, lay):
    outline(drawing, HALL, "boundary")
    leg = drawing.blocks.new("LEG")
    # on layer 0, so that it takes the layer of the insert
    leg.add_lwpolyline([(0, 0), (1, 0), (1, 0.5)], close=True)
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
    # The x axis of the leg is mirrored about 1, doubled and turned up. Its y axis points left.
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
def test_nested_blocks_are_placed_by_their_transforms(inner, outer):
    """A block turned inside a stretched block loses its right angles."""
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


def test_a_block_in_itself_is_rejected(drawing, load):
    outline(drawing, HALL, "boundary")
    block = drawing.blocks.new("LOOP")
    for _ in range(3):  # each of which would contain three more
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


def test_a_hollow_group_of_open_lines_is_reported(drawing, lay):
    outline(drawing, HALL, "boundary")
    drawing.modelspace().add_line((2, 2), (4, 2), dxfattribs={"layer": "walls"})
    outline(drawing, [(5, 5)], "walls", close=False)
    groups = "layers: {boundary: [boundary], walls: {layers: [walls], hollow: true}}"
    reported = problems(lay, groups)
    assert [one.count("has no length") for one in reported] == [1, 0]
    assert "is open; close it" in reported[1]


def test_a_pattern_without_a_matching_layer_is_reported(drawing, lay):
    outline(drawing, HALL, "boundary")
    reported = problems(lay, "layers: {boundary: [boundary], walls: [A-WALL*]}")
    assert "walls: no layer of the drawing matches 'A-WALL*'; there are: boundary" in reported


def test_shapes_are_omitted_by_their_handles(drawing, lay):
    outline(drawing, HALL, "boundary")
    handle = outline(drawing, BENCH, "bench", close=False).dxf.handle
    plan = lay(f"leave_out: ['{handle}']")
    assert plan.obstacles == ()
    assert [str(one) for one in plan.notices] == [
        f"layer 'bench', LWPOLYLINE {handle}: is left out as asked"
    ]


def test_a_drawing_without_units_is_not_silently_in_metres(drawing, load, lay):
    drawing.header["$INSUNITS"] = 0
    outline(drawing, [(1000 * x, 1000 * y) for x, y in HALL], "boundary")
    assert "gives no unit" in load().notices[0].message
    plan = lay("units: mm\norigin: [1000, 0]\nstations: {press: [5000, 3000]}")
    assert plan.boundary.bounds == (-1, 0, 9, 6)
    assert plan.stations["press"].position == (4, 3)
    assert plan.notices == ()


def curve(drawing, layer="bench"):
    """Add an empty spline."""
    return drawing.modelspace().add_spline(dxfattribs={"layer": layer})


CIRCLE = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
"""Control points of a circle as a rational spline of degree 2."""
WEIGHTS = [1 if k % 2 == 0 else math.sqrt(0.5) for k in range(9)]
TURNS = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]


def circular(drawing, centre, radius):
    spline = curve(drawing)
    spline.dxf.degree = 2
    spline.control_points = [(centre[0] + radius * x, centre[1] + radius * y) for x, y in CIRCLE]
    spline.knots, spline.weights = TURNS, WEIGHTS
    spline.closed = True


def test_a_rational_spline_is_within_a_millimetre(drawing, load):
    outline(drawing, [(-30, -30), (30, -30), (30, 30), (-30, 30)], "boundary")
    circular(drawing, (1, 2), 20)
    (tank,) = load().obstacles
    assert tank.footprint.hausdorff_distance(shapely.Point(1, 2).buffer(20, 500)) < 1.1e-3


def test_a_spline_ends_where_its_knots_say(drawing, load):
    outline(drawing, [(-30, -30), (30, -30), (30, 30), (-30, 30)], "boundary")
    spline = curve(drawing)
    corners = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    spline.set_closed(corners, degree=3)  # a uniform one: it reaches none of its control points
    (pond,) = load().obstacles
    times = [(k + s / 50) for k in range(4) for s in range(50)]
    points = []
    for t in times:
        k, u = divmod(t, 1)
        basis = [(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, -3 * u**3 + 3 * u**2 + 3 * u + 1, u**3]
        near = [corners[(int(k) + i) % 4] for i in range(4)]
        points.append([sum(b * c[i] for b, c in zip(basis, near, strict=True)) / 6 for i in (0, 1)])
    assert pond.footprint.hausdorff_distance(shapely.Polygon(points)) < 5e-3
    assert pond.footprint.area == pytest.approx(shapely.Polygon(points).area, rel=1e-3)


def test_a_closed_spline_through_points_is_an_area(drawing, load):
    outline(drawing, [(-30, -30), (30, -30), (30, 30), (-30, 30)], "boundary")
    angles = [math.tau * k / 12 for k in range(12)]
    spline = curve(drawing)
    spline.fit_points = [(10 * math.cos(a), 10 * math.sin(a), 0) for a in angles]
    spline.closed = True
    (pond,) = load().obstacles
    # Smooth everywhere, also where it begins.
    assert pond.footprint.hausdorff_distance(shapely.Point(0, 0).buffer(10, 100)) < 0.02


@pytest.mark.parametrize("kind", ["circle", "arcs", "bulges", "hatch"])
def test_large_arcs_are_within_a_millimetre(drawing, lay, kind):
    space, at = drawing.modelspace(), {"layer": "bench"}
    if kind == "circle":
        space.add_circle((0, 0), 50, dxfattribs=at)
    elif kind == "arcs":
        for begin in (0, 180):
            space.add_arc((0, 0), 50, begin, begin + 180, dxfattribs=at)
    elif kind == "bulges":
        points = [(50, 0, 1), (-50, 0, 1)]
        space.add_lwpolyline(points, format="xyb", close=True, dxfattribs=at)
    else:
        edges = space.add_hatch(dxfattribs=at).paths.add_edge_path()
        edges.add_arc((0, 0), 50, 0, 180)
        edges.add_arc((0, 0), 50, 180, 360)
    plan = lay("""\
        boundary: [[-60, -60], [60, -60], [60, 60], [-60, 60]]
        layers: {benches: [bench]}
    """)
    (hall,) = plan.obstacles
    assert hall.footprint.hausdorff_distance(shapely.Point(0, 0).buffer(50, 500)) < 1.2e-3


def test_a_hatch_is_bounded_by_edges_in_any_direction(drawing, lay):
    edges = drawing.modelspace().add_hatch(dxfattribs={"layer": "bench"}).paths.add_edge_path()
    edges.add_line((4, 0), (0, 0))
    edges.add_arc((2, 0), 2, 0, 90)  # from the begin of the line, backwards
    spline = edges.add_spline(control_points=[(0, 0), (0, 1), (2, 2)], degree=2, weights=[1, 1, 1])
    spline.knot_values = [0, 0, 0, 1, 1, 1]
    plan = lay("""\
        boundary: [[-60, -60], [60, -60], [60, 60], [-60, 60]]
        layers: {benches: [bench]}
    """)
    (bench,) = plan.obstacles
    # A quarter of a disc, and the area below the parabola (2 u², 2 u).
    assert bench.footprint.area == pytest.approx(math.pi + 8 / 3, abs=5e-3)
    assert bench.footprint.bounds == pytest.approx((0, 0, 4, 2), abs=2e-3)


def test_the_frame_of_a_spline_fit_polyline_is_not_drawn(drawing, load):
    outline(drawing, HALL, "boundary")
    frame = [(0, 0), (10, 6), (0, 6), (10, 0)]
    line = drawing.modelspace().add_polyline2d(frame + BENCH, dxfattribs={"layer": "bench"})
    line.dxf.flags = 1 | 4  # closed and fitted
    for k, vertex in enumerate(line.vertices):
        vertex.dxf.flags = 16 if k < 4 else 8
    assert load().obstacles["bench"].footprint.equals(shapely.Polygon(BENCH))


def test_the_width_of_a_line_is_part_of_its_shape(drawing, lay):
    space = drawing.modelspace()
    outline(drawing, HALL, "boundary")
    donut = {"layer": "pillar", "const_width": 0.2}
    space.add_lwpolyline([(8, 5, 1), (8.2, 5, 1)], format="xyb", close=True, dxfattribs=donut)
    outline(drawing, [(1, 1), (4, 1), (4, 3)], "wall", close=False, const_width=0.3)
    space.add_lwpolyline([(1, 5, 0.4, 0.2), (3, 5)], format="xyse", dxfattribs={"layer": "wedge"})
    old = {"layer": "old", "default_start_width": 0.1, "default_end_width": 0.1}
    space.add_polyline2d([(6, 1), (9, 1)], dxfattribs=old)
    plan = lay("layers: {boundary: [boundary], all: [pillar, wall, wedge, old]}")
    pillar, wall, wedge, old = sorted(plan.obstacles, key=lambda o: o.name)
    disc = shapely.Point(8.1, 5).buffer(0.2, 100)
    assert pillar.footprint.hausdorff_distance(disc) < 1.5e-3
    corners = [(1, 0.85), (4.15, 0.85), (4.15, 3), (3.85, 3), (3.85, 1.15), (1, 1.15)]
    assert wall.footprint.normalize().equals_exact(shapely.Polygon(corners).normalize(), 1e-9)
    assert wedge.footprint.equals(shapely.Polygon([(1, 4.8), (3, 4.9), (3, 5.1), (1, 5.2)]))
    assert old.footprint.bounds == pytest.approx((6, 0.95, 9, 1.05))
    assert plan.notices == ()


def test_a_wide_outline_is_an_area_with_a_notice_or_a_hollow_wall(drawing, lay):
    outline(drawing, HALL, "boundary", const_width=0.2)
    block = drawing.blocks.new("ROOM")
    block.add_lwpolyline(BENCH, close=True, dxfattribs={"const_width": 0.05})
    drawing.modelspace().add_blockref(
        "ROOM", (0, 0), dxfattribs={"layer": "room", "xscale": 2, "yscale": 2}
    )
    plan = lay("layers: {boundary: [boundary], rooms: [room]}")
    assert plan.boundary.bounds == pytest.approx((0.1, 0.1, 9.9, 5.9))
    assert plan.obstacles["rooms"].footprint.bounds == pytest.approx((3.95, 3.95, 8.05, 6.05))
    assert [one.message.split(" wide")[0] for one in plan.notices] == [
        "is drawn 0.200 m",
        "is drawn 0.100 m",
    ]
    plan = lay("layers: {boundary: [boundary], rooms: {layers: [room], hollow: true}}")
    assert sum(o.footprint.area for o in plan.obstacles) == pytest.approx(4.1 * 2.1 - 3.9 * 1.9)


def test_ends_with_three_decimals_meet(drawing, load):
    outline(drawing, HALL, "boundary")
    space, at = drawing.modelspace(), {"layer": "bench"}
    # A rounded corner: the arc of 0.7 m ends up to 6e-6 m beside the lines.
    space.add_line((2, 2), (4.3, 2), dxfattribs=at)
    space.add_arc((4.3, 2.7), 0.7, 270.0004, 359.9996, dxfattribs=at)
    space.add_line((5, 2.7), (5, 4), dxfattribs=at)
    for ends in (((5, 4), (2, 4)), ((2, 4.0004), (2, 2))):
        space.add_line(*ends, dxfattribs=at)
    space.add_ellipse((8, 3), (1, 0), 0.5, 0, 6.283185, dxfattribs={"layer": "pond"})
    bench, pond = load().obstacles
    assert bench.footprint.area == pytest.approx(6 - 0.49 * (1 - math.pi / 4), abs=2e-3)
    assert pond.footprint.area == pytest.approx(math.pi / 2, abs=5e-3)


def test_a_curve_in_many_short_lines_stays_a_curve(drawing, load):
    outline(drawing, HALL, "boundary")
    space = drawing.modelspace()
    ring = [(8 + 0.1 * math.cos(a / 1000), 3 + 0.1 * math.sin(a / 1000)) for a in range(6283)]
    for begin, end in zip(ring[::4], [*ring[4::4], ring[0]], strict=False):
        end = (end[0] + 1e-5, end[1])  # of 0.4 mm, and none meets the next one exactly
        space.add_line(begin, end, dxfattribs={"layer": "pillar"})
    assert load().obstacles["pillar"].footprint.area == pytest.approx(math.pi / 100, rel=1e-3)


def test_a_gap_that_is_too_wide_is_shown_with_the_snap_that_closes_it(drawing, lay):
    outline(drawing, HALL, "boundary")
    for ends in (((2, 2), (4, 2)), ((4, 2), (4, 3)), ((4, 3), (2, 2.00123))):
        drawing.modelspace().add_line(*ends, dxfattribs={"layer": "bench"})
    reported = problems(lay, "title: shop")
    (snap,) = {one.split("`snap: ")[1].split("`")[0] for one in reported if "snap" in one}
    assert float(snap) == pytest.approx(0.0013)
    assert len(lay(f"snap: {snap}").obstacles) == 1


def test_a_drawing_without_a_boundary_names_its_layers_first(drawing, load, lay):
    for k in range(30):
        outline(drawing, [(k, 0), (k, 1)], "A-WALL", close=False)
    outline(drawing, BENCH, "A-DESK")
    reported = problems(load)
    assert reported[0].startswith("no layer is called 'boundary'")
    assert "'A-DESK', 'A-WALL'" in reported[0] and "`layers`" in reported[0] and "30" in reported[0]
    assert len(reported) == 6
    reported = problems(lay, "layers: {walls: [A-WALL]}")
    assert (
        "'boundary'" in reported[0] and "'A-DESK', 'A-WALL'" in reported[0] and len(reported) == 6
    )


def test_ignored_layers_have_one_notice_each(drawing, lay):
    outline(drawing, HALL, "boundary")
    for k in range(30):
        outline(drawing, [(k, 0), (k, 1)], "A-DIMS", close=False)
    outline(drawing, BENCH, "A-DESK")
    plan = lay("layers: {boundary: [boundary]}")
    assert [one.field.split(",")[0] for one in plan.notices] == ["layer 'A-DIMS'", "layer 'A-DESK'"]
    assert plan.notices[0].message == "30 shapes are on a layer that no group has"
