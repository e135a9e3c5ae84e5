import itertools

import numpy as np
import pytest
import shapely

import floorplan
from navigation import CollisionWorld


def written(path, rows):
    head = f"type octile\nheight {len(rows)}\nwidth {len(rows[0])}\nmap\n"
    path.write_text(head + "\n".join(rows) + "\n")
    return path


def test_cells_become_metres_with_the_top_row_above(tmp_path):
    plan = floorplan.load(written(tmp_path / "hall.map", ["..@.", "G.S.", "TOW."]))
    assert plan.name == "hall"
    assert plan.boundary.bounds == (0, 0, 4, 3)
    blocked = shapely.union_all([one.footprint for one in plan.obstacles])
    assert blocked.area == 4
    assert blocked.covers(shapely.box(2, 2, 3, 3))
    assert blocked.covers(shapely.box(0, 0, 3, 1))
    ring = floorplan.load(written(tmp_path / "ring.map", ["@@@@@", "@..@@", "@@@.@", "@@@@@"]))
    assert not any(one.footprint.interiors for one in ring.obstacles)
    assert ring.boundary.area - ring.free(0, 1).area == 17
    half = floorplan.load_movingai(tmp_path / "hall.map", 0.5)
    assert half.boundary.bounds == (0, 0, 2, 1.5)


@pytest.mark.parametrize("seed", range(6))
def test_obstacles_are_whole_cells(tmp_path, seed):
    """Cells that touch only at a corner are included."""
    free = np.random.default_rng(seed).random((9, 11)) < 0.62
    rows = ["".join(".@"[not cell] for cell in row) for row in free]
    plan = floorplan.load(written(tmp_path / "m.map", rows))
    cells = [shapely.box(c, 8 - r, c + 1, 9 - r) for r, c in zip(*np.nonzero(~free), strict=True)]
    taken = shapely.union_all([one.footprint for one in plan.obstacles])
    assert taken.symmetric_difference(shapely.union_all(cells)).area == 0


@pytest.mark.parametrize("seed", range(6))
def test_a_person_reaches_cells_connected_by_their_sides(tmp_path, seed):
    """Random maps in any number of areas have one-cell corridors. Corners do not connect cells."""
    free = np.random.default_rng(seed).random((9, 11)) < 0.62
    rows = ["".join(".@"[not cell] for cell in row) for row in free]
    space = CollisionWorld(floorplan.load(written(tmp_path / "m.map", rows))).free_space(0.2)
    area = {cell: k for k, cell in enumerate(zip(*np.nonzero(free), strict=True))}
    for _ in area:
        for row, column in area:
            for near in ((row + 1, column), (row, column + 1)):
                if near in area:
                    area[row, column] = area[near] = min(area[row, column], area[near])
    for one, other in itertools.combinations(area, 2):
        ends = [(column + 0.5, len(rows) - row - 0.5) for row, column in (one, other)]
        assert space.together(*ends) == (area[one] == area[other])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1: expected type octile, found ''"),
        ("type tile\nheight 1\nwidth 1\nmap\n.\n", "line 1: expected type octile"),
        ("type octile\nheight x\n", "line 2: expected height and a number, found 'height x'"),
        ("type octile\nheight 0\nwidth 3\nmap\n", "has no cells"),
        ("type octile\nheight 1\nwidth 3\nmap\n..\n", "line 5: has 2 cells; the width is 3"),
        ("type octile\nheight 1\nwidth 3\nmap\n.x.\n", "line 5: 'x' is no cell"),
        ("type octile\nheight 2\nwidth 3\nmap\n...\n", "has 1 rows of cells; its height is 2"),
        ("type octile\nheight 1\nwidth 3\nmap\n@@@\n", "no cell can be walked on"),
        ("type octile\nheight 99999\nwidth 99999\nmap\n", "of at most 16,000,000"),
    ],
)
def test_an_invalid_map_is_rejected(tmp_path, text, words):
    (tmp_path / "m.map").write_text(text)
    with pytest.raises(floorplan.FloorplanError, match=words):
        floorplan.load(tmp_path / "m.map")
    with pytest.raises(ValueError, match="a cell must be from"):
        floorplan.load_movingai(tmp_path / "m.map", float("nan"))
