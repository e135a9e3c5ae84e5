import math

import numpy as np
import pytest
import shapely
from sample_files import SAMPLES, files

import floorplan

FREE, UNKNOWN, OCCUPIED = 254, 205, 0

YAML = """\
image: map.pgm
resolution: 0.5
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def pgm(path, pixels, top=255):
    pixels = np.asarray(pixels)
    kind = ">u2" if top > 255 else "u1"
    header = f"P5\n# a comment\n{pixels.shape[1]} {pixels.shape[0]}\n{top}\n".encode()
    path.write_bytes(header + pixels.astype(kind).tobytes())


@pytest.fixture
def load(tmp_path):
    def load(pixels, text=YAML, **image):
        pgm(tmp_path / "map.pgm", pixels, **image)
        (tmp_path / "map.yaml").write_text(text, encoding="utf-8")
        return floorplan.load(tmp_path / "map.yaml")

    return load


def room(rows=8, columns=12):
    pixels = np.full((rows, columns), OCCUPIED)
    pixels[1:-1, 1:-1] = FREE
    return pixels


def test_cells_become_metres(load):
    pixels = room()
    pixels[2:4, 3] = OCCUPIED
    pixels[2:4, 4] = UNKNOWN
    plan = load(pixels)
    assert plan.name == "map"
    # The first row of the image is its upper edge.
    assert plan.boundary.bounds == pytest.approx((-0.5, 2.5, 4.5, 5.5))
    (thing,) = plan.obstacles
    assert thing.footprint.bounds == pytest.approx((0.5, 4.0, 1.5, 5.0))


def test_an_image_is_rejected_with_a_hint_to_its_settings(load, tmp_path):
    load(room())
    with pytest.raises(floorplan.FloorplanError, match="ROS map") as wrong:
        floorplan.load(tmp_path / "map.pgm")
    assert str(tmp_path / "map.yaml") in str(wrong.value)


def test_turned_origin(load):
    straight = load(room())
    text = YAML.replace("2.0, 0.0]", "2.0, 0.5235987755982988]")
    turned = load(room(), text)
    back = shapely.affinity.rotate(turned.boundary, -30, origin=(-1.0, 2.0))
    assert back.symmetric_difference(straight.boundary).area < 1e-9


def test_the_largest_free_area_is_the_floor(load):
    pixels = room(12, 12)
    pixels[4] = OCCUPIED
    plan = load(pixels)
    assert plan.boundary.area == pytest.approx(10 * 6 * 0.25)


def test_negated(load):
    text = YAML.replace("negate: 0", "negate: 1")
    assert load(255 - room(), text).boundary.equals(load(room()).boundary)


def test_thresholds(load):
    pixels = room()
    pixels[3, 5] = 255 - int(0.3 * 255)  # 30 % occupied
    assert len(load(pixels).obstacles) == 1
    lenient = YAML.replace("free_thresh: 0.196", "free_thresh: 0.35")
    assert load(pixels, lenient).obstacles == ()


def test_unknown_grey_is_as_free_as_the_threshold_says(load):
    pixels = room()
    pixels[3, 5] = UNKNOWN
    assert len(load(pixels).obstacles) == 1
    assert load(pixels, YAML.replace("0.196", "0.25")).obstacles == ()


def test_scale_mode_treats_intermediate_values_as_occupied(load):
    pixels = room()
    pixels[3, 5] = 128
    assert len(load(pixels, YAML + "mode: scale\n").obstacles) == 1


def test_raw_values_are_percentages(load):
    pixels = np.full((8, 12), 100)
    pixels[1:-1, 1:-1] = 0
    pixels[3, 3], pixels[3, 6], pixels[3, 9] = 255, 10, 40
    plan = load(pixels, YAML + "mode: raw\n")
    assert len(plan.obstacles) == 2
    assert load(pixels, YAML + "mode: raw\n", top=65535).obstacles != ()


def test_plain_and_deep_pgm(load, tmp_path):
    expected = load(room()).boundary
    lines = "\n".join(" ".join(map(str, row)) for row in room())
    (tmp_path / "map.pgm").write_text(f"P2 # plain\n12 8\n255\n{lines}\n")
    assert floorplan.load(tmp_path / "map.yaml").boundary.equals(expected)
    assert load(room() * 257, top=65535).boundary.equals(expected)


def test_png(load, tmp_path):
    image = pytest.importorskip("PIL.Image")
    expected = load(room()).boundary
    (tmp_path / "map.yaml").write_text(YAML.replace("map.pgm", "map.png"))
    image.fromarray(room().astype("u1")).save(tmp_path / "map.png")
    assert floorplan.load(tmp_path / "map.yaml").boundary.equals(expected)
    grey = image.fromarray(room().astype("u1")).convert("RGBA")
    grey.putpixel((5, 3), (254, 254, 254, 0))  # transparent pixels are unknown
    grey.save(tmp_path / "map.png")
    assert len(floorplan.load(tmp_path / "map.yaml").obstacles) == 1
    grey.putpixel((5, 3), (254, 0, 0, 255))
    grey.save(tmp_path / "map.png")
    with pytest.raises(floorplan.FloorplanError, match=r"map\.png': is in colour"):
        floorplan.load(tmp_path / "map.yaml")


@pytest.mark.parametrize(
    "key", ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"]
)
def test_missing_keys_are_named(load, key):
    text = "".join(line for line in YAML.splitlines(True) if not line.startswith(key))
    with pytest.raises(floorplan.FloorplanError, match=f"{key}: is missing"):
        load(room(), text)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("resolution: 0.5", "resolution: -1.0", "line 2, resolution: expected at least 0.0001"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0]", "origin"),
        ("free_thresh: 0.196", "free_thresh: 0.9", "free_thresh (0.9) must not be above"),
        ("free_thresh: 0.196", "free_thresh: 25", "free_thresh"),
        ("negate: 0", "negate: maybe", "negate"),
        ("image: map.pgm", "image: other.pgm", "line 1, image: "),
        ("image: map.pgm", "image: map.yaml", "'map.yaml': is not an image"),
        ("free_thresh: 0.196", "free_thresh: 0.0", "no cell of map.pgm is free"),
        (
            "image: map.pgm",
            'image: "a\\0b"',
            "line 1, image: a text can't have the character U+0000",
        ),
        ("image: map.pgm", f"image: {'x' * 20_000}", "can't be read: File name too long"),
        ("resolution: 0.5", "resolution: 1.0e+308", "resolution: expected at most 1000"),
        ("resolution: 0.5", "resolution: 1.0e-300", "resolution: expected at least 0.0001"),
        ("[-1.0, 2.0", "[1.0e+30, 2.0", "origin[0]: expected at most 1e+10"),
        ("negate: 0", "negate: 0\nmode: colourful", "line 5, mode: expected 'trinary', 'scale'"),
    ],
)
def test_an_invalid_map_is_rejected(load, old, new, words):
    with pytest.raises(floorplan.FloorplanError) as wrong:
        load(room(), YAML.replace(old, new))
    assert words in str(wrong.value)
    assert len(str(wrong.value)) < 2000


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"P5\n12 8\n255\n\x00\x00", "is cut short: 2 of 96 pixels"),
        (b"P5" + b"\n" * 100 + b"6& 6\n255\n", "its header is broken"),
        (b"P5\n" + b"1" * 9000 + b" 1\n255\n", "its header is broken"),
        (b"P5\ntwelve 8\n255\n", "its header is broken"),
        (b"P2\n2 1\n255\n7 x\n", "something in it is no number"),
        (b"P2\n2 1\n255\n7 1e300\n", "a number in it is not from 0 to 255"),
        (b"P5\n0 8\n255\n", "has no pixels"),
        (b"P5\n99999999 99999999\n255\n", "at most 64,000,000 can be read"),
        (b"P5\n1 1\n99999\nx", "its white is 99999"),
    ],
)
def test_broken_images(load, tmp_path, data, words):
    load(room())
    (tmp_path / "map.pgm").write_bytes(data)
    with pytest.raises(floorplan.FloorplanError) as wrong:
        floorplan.load(tmp_path / "map.yaml")
    assert words in str(wrong.value)


def test_a_wall_of_one_cell_stays_shut_and_a_door_of_three_open(load):
    """Outlines are also simplified on slopes."""
    pixels = room(60, 120)
    for column in range(1, 119):
        row = 20 + round(column / 7)
        pixels[row, column] = OCCUPIED
        pixels[row - 1, column] = OCCUPIED if column % 7 == 3 else pixels[row - 1, column]
    shut = load(pixels).free(0, 1)
    assert shut.geom_type == "Polygon"
    assert shut.bounds[3] < 30 or shut.area < 60 * 120 * 0.25 * 0.7
    pixels[:, 60:63] = np.where(room(60, 120)[:, 60:63] == FREE, FREE, pixels[:, 60:63])
    door = load(pixels).free(0, 1)
    assert door.area > shut.area * 1.3
    # A disc half as wide as the door passes.
    assert door.buffer(-0.5 / 2).geom_type == "Polygon"


@pytest.mark.slow
def test_noise_is_rejected(load):
    speckled = np.where(np.random.default_rng(0).random((1500, 1500)) < 0.5, FREE, OCCUPIED)
    with pytest.raises(floorplan.FloorplanError, match="corners, of at most 1,000,000: clear it"):
        load(speckled)
    dotted = np.full((800, 800), FREE)
    dotted[1:-1:2, 1:-1:2] = OCCUPIED
    with pytest.raises(floorplan.FloorplanError, match="outlines, of at most 100,000: clear it"):
        load(dotted)


def test_a_map_file_beside_its_image():
    plan = floorplan.load(SAMPLES / "hall_map.yaml")
    assert plan.boundary.bounds == pytest.approx((-3.5, -2.5, 3.5, 2.5))
    assert sorted(o.footprint.area for o in plan.obstacles) == pytest.approx([0.16, 2.4])
    # Unknown cells are free by the threshold of the map.
    assert plan.free(0, 1.75).area == pytest.approx(35.0 - 2.4 - 0.16)
    assert plan.free(0, 1.75).contains(shapely.Point(-2.5, -2.0))

    for path in files(real="ariac2023/ariac_map.yaml"):
        plan = floorplan.load(path)
        assert plan.boundary.bounds == pytest.approx((-22.3, -14.9, 4.55, 14.6))
        # The stations and the safe zone of the true floor are also free on its map.
        floor = floorplan.load("ariac2023")
        free = plan.free(0, 1.75)
        for place in [*(s.position for s in floor.stations), floor.safe_zone.position]:
            assert free.contains(shapely.Point(place))
    for path in files(real="floors/small_warehouse.yaml"):
        # The free area is at most that of all its cells.
        warehouse = floorplan.load(path)
        assert 250 < warehouse.free(0, 1.75).area < (92516 + 18918) * 0.05**2


def test_large_maps_load(load):
    rng = np.random.default_rng(0)
    pixels = np.full((4000, 4000), FREE)
    for _ in range(400):
        row, column = rng.integers(0, 3900, 2)
        pixels[row : row + rng.integers(3, 90), column : column + rng.integers(3, 90)] = OCCUPIED
    plan = load(pixels, YAML.replace("0.5", "0.05"))
    assert plan.boundary.area == pytest.approx(200 * 200, rel=0.02)
    assert len(plan.obstacles) > 200
    assert math.isclose(plan.free(0, 1).area, (pixels == FREE).sum() * 0.05**2, rel_tol=1e-3)


def test_a_cell_at_the_threshold_is_free(load):
    white = np.where(room() == FREE, 255, OCCUPIED)
    assert load(white, YAML.replace("free_thresh: 0.196", "free_thresh: 0.0")).boundary.area == 15
    raw = np.where(room() == FREE, 20, 100)
    text = YAML.replace("free_thresh: 0.196", "free_thresh: 0.2") + "mode: raw\n"
    assert load(raw, text).boundary.area == 15


@pytest.fixture
def masked(tmp_path):
    def masked(pixels, zones, text=YAML + "mode: scale\n", units="m"):
        pgm(tmp_path / "map.pgm", pixels)
        (tmp_path / "keepout.yaml").write_text(text)
        k = 1000 if units == "mm" else 1
        corners = [[-1 * k, 2 * k], [5 * k, 2 * k], [5 * k, 6 * k], [-1 * k, 6 * k]]
        floor = f"units: {units}\nboundary: {corners}\nzones: {zones}\n"
        return floorplan.parse(floor, file=str(tmp_path / "floor.yaml")).zones

    return masked


@pytest.mark.parametrize("units", ["m", "mm"])
def test_a_keepout_mask_is_a_forbidden_zone(masked, units):
    pixels = np.full((8, 12), 255)
    pixels[1:3, 1:3] = pixels[5, 6:9] = 0
    pixels[6, 1:5] = 128  # costly, but not forbidden
    zones = masked(pixels, "{mask: keepout.yaml}", units=units)
    assert [(zone.name, zone.forbidden) for zone in zones] == [("mask1", True), ("mask2", True)]
    assert zones[0].area.bounds == pytest.approx((-0.5, 4.5, 0.5, 5.5))
    (zone,) = masked(pixels[:4], "{aisle: {mask: keepout.yaml, max_speed: 0.3, concerns: [agv*]}}")
    assert (zone.name, zone.max_speed, zone.concerns) == ("aisle", 0.3, ("agv*",))


def test_a_speed_mask_gives_limits_by_the_values_of_cells(masked):
    pixels = np.full((8, 12), 255)
    pixels[1:3, 1:3] = 255 - 25
    pixels[5, 6:9] = 255 - 50
    raw = YAML + "mode: raw\n"
    pixels = np.where(pixels == 255, 0, 255 - pixels)  # percentages
    zones = masked(pixels, "{slow: {mask: keepout.yaml, base: 1.0, multiplier: -0.01}}", raw)
    assert {zone.max_speed: zone.area.area for zone in zones} == pytest.approx(
        {0.75: 1.0, 0.5: 0.75}
    )
    with pytest.raises(floorplan.FloorplanError, match="value 50"):
        masked(pixels, "{slow: {mask: keepout.yaml, base: 0.5, multiplier: -0.01}}", raw)


@pytest.mark.parametrize(
    ("zone", "word"),
    [
        ("{mask: none.yaml}", "no such file"),
        ("{a: {mask: keepout.yaml, x: [0, 1], y: [0, 1]}}", "footprint"),
        ("{a: {mask: keepout.yaml, one_way: [1, 0]}}", "mask"),
        ("{a: {x: [0, 1], y: [0, 1], max_speed: 1, multiplier: 1}}", "mask"),
        ("{mask: keepout.yaml}", "0 zones"),
    ],
)
def test_an_invalid_mask_is_rejected(masked, zone, word):
    with pytest.raises(floorplan.FloorplanError, match=word):
        masked(np.full((8, 12), 255), zone)


def test_a_tiff_is_named(load, tmp_path):
    load(room())
    (tmp_path / "map.pgm").write_bytes(b"II*\0" + bytes(100))
    with pytest.raises(floorplan.FloorplanError, match="TIFF, which is not supported"):
        floorplan.load(tmp_path / "map.yaml")
