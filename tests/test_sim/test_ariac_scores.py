"""Points for orders and places of parts, against the tables of the competition."""

import math

import pytest
from hypothesis import given, strategies as st

import floorplan
from sim.orders.inventory import TABLES, bin_slot, quadrant_on, tool_stand, tray_on, tray_slot
from sim.orders.schema import angle
from sim.orders.scoring import Inserted, assembly_score, best_score, kitting_score
from sim.orders.workload import AssemblyTask, CombinedTask, Item, KittingTask, Load, PartType

COLORS = ("blue", "green", "orange", "purple", "red")
TYPES = ("battery", "pump", "regulator", "sensor")

# (type, colour, flipped, faulty) to points, as in the rules. Other combinations score none.
QUADRANT = {
    (True, True, False, False): 3,
    (True, False, False, False): 2,
    (True, True, True, False): 2,
    (True, False, True, False): 1,
}
# (colour, pose) of an assembled part to points.
ASSEMBLY = {(True, True): 3, (True, False): 2, (False, True): 2, (False, False): 1}
COMBINED = {(True, True): 5, (True, False): 4, (False, True): 4, (False, False): 3}

parts = st.builds(PartType, st.sampled_from(COLORS), st.sampled_from(TYPES))
quadrants = st.integers(1, 4)
kits = st.dictionaries(quadrants, parts, min_size=1)
items = st.dictionaries(quadrants, st.builds(Item, parts, st.booleans()))
trays = st.none() | st.integers(0, 2)
faults = st.sets(quadrants)
products = st.lists(parts, min_size=1, max_size=4, unique_by=lambda part: part.type)


@given(kits, items, st.integers(0, 2), trays, st.booleans(), faults)
def test_kits(kit, lying, tray, tray_there, arrived, faulty):
    points = 3 if tray == tray_there else 0
    quadrant_points = 0
    for quadrant, part in kit.items():
        item = lying.get(quadrant)
        if item is not None:
            b, c = item.part.type == part.type, item.part.color == part.color
            quadrant_points += QUADRANT.get((b, c, item.flipped, quadrant in faulty), 0)
    points += quadrant_points
    if quadrant_points == 3 * len(kit):
        points += len(kit)
    if len(lying) > len(kit):
        points -= len(lying) - len(kit)
    expected = max(points, 0) * (1 if arrived else 0)
    task = KittingTask(agv="agv1", tray=tray, destination="warehouse", products=kit)
    load = Load(tray_there, lying)
    assert kitting_score(task, load, arrived=arrived, faulty=faulty) == expected


@given(products, products, st.data())
def test_inserts(requested, inserted, data):
    poses = {part.type: data.draw(st.booleans()) for part in inserted}
    there = {part.type: Inserted(part, poses[part.type]) for part in inserted}
    for task, table in (
        (AssemblyTask("as1", ("agv1",), tuple(requested)), ASSEMBLY),
        (CombinedTask("as1", tuple(requested)), COMBINED),
    ):
        points = 0
        for part in requested:
            for other in inserted:
                if other.type == part.type:
                    points += table[other.color == part.color, poses[part.type]]
        if points == max(table.values()) * len(requested):
            points += 4 * len(requested)
        assert assembly_score(task, there) == points


@given(kits, products)
def test_the_best_score_is_that_of_a_faultless_order(kit, requested):
    kitting = KittingTask(agv="agv1", tray=4, destination="as1", products=kit)
    load = Load(4, {quadrant: Item(part) for quadrant, part in kit.items()})
    assert best_score(kitting) == kitting_score(kitting, load, arrived=True)
    there = {part.type: Inserted(part) for part in requested}
    for task in (
        AssemblyTask("as1", ("agv1",), tuple(requested)),
        CombinedTask("as1", tuple(requested)),
    ):
        assert best_score(task) == assembly_score(task, there)


def test_positions_equal_those_of_the_competition():
    """The coordinates in the competition's world frame are computed by hand."""
    plan = floorplan.load("ariac2023")

    def world(obstacle, offset):
        middle = plan.obstacle(obstacle).footprint.centroid
        return pytest.approx((middle.x + offset[0], middle.y + offset[1]), abs=1e-9)

    assert world("bin1", bin_slot(1)) == (-2.08, 3.195)
    assert world("bin1", bin_slot(3)) == (-2.08, 3.555)
    assert world("bin1", bin_slot(7)) == (-1.72, 3.195)
    assert world(*tray_slot(1)) == (-0.87, -5.84)
    assert world(*tray_slot(6)) == (-0.87, 5.84)
    tables = TABLES
    assert world(tables[0], tool_stand(tables[0], "trays")) == (-1.5, -5.38)
    assert world(tables[1], tool_stand(tables[1], "parts")) == (-1.5, 5.38)
    lane = plan.lane("agv2")
    assert tray_on(lane) == pytest.approx((0.2, 0.0))
    assert quadrant_on(lane, 1) == pytest.approx((0.0725, -0.0925))
    assert quadrant_on(lane, 4) == pytest.approx((0.3275, 0.0925))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi", math.pi),
        ("-pi/2", -math.pi / 2),
        ("2*pi/3", 2 * math.pi / 3),
        ("2pi", 2 * math.pi),
        ("0.9", 0.9),
        (0.9, 0.9),
        ("p1/2", None),
        ("pi/0", None),
        ("", None),
    ],
)
def test_angles(text, value):
    parsed = angle(text)
    if value is None:
        assert parsed is None or math.isnan(parsed)
    else:
        assert parsed == pytest.approx(value)
