"""Kernels: the same bits compiled and not, and comparisons with their definitions."""

import ast
import heapq
import itertools
import math
import random
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, strategies as st

import navigation
from navigation import kernels, polynomials as quadrature
from navigation.freespace import walls
from navigation.kernels import COMPILED
from navigation.kernels.committed import CommittedMotions
from navigation.kernels.edges import Legs
from navigation.kernels.grid import CHUNK, WaysRound, block_discs, grid_path
from navigation.kernels.numbers import numbers
from navigation.walking import swath

AS_PYTHON = """
import importlib.machinery, importlib.util, pathlib, sys

class Sources:
    def find_spec(self, name, path=None, target=None):
        if ".kernels." in name:
            file = pathlib.Path(path[0]) / (name.rpartition(".")[2] + ".py")
            return importlib.util.spec_from_file_location(name, file)

sys.meta_path.insert(0, Sources())
"""
"""Code that imports kernels from their sources."""

RUN = """
import hashlib, pathlib, random, sys, tempfile
import floorplan, navigation, shapely, sim
from navigation.carried import carried
from navigation import kernels
from navigation.kernels import COMPILED
from navigation.kernels.areas import Polygons, poses_along, swept
from navigation.kernels.lookout import most_remote, nearest_on
from navigation.kernels.numbers import numbers
from navigation.machines import agv_stops, gantry_stops
from navigation.monitor import StoppingHorizon

print(COMPILED, file=sys.stderr)
digest = hashlib.sha256()
rng = random.Random(3)
place = lambda: (rng.uniform(-4, 4), rng.uniform(-4, 4))
laws = (
    navigation.SeparationLaw(t1=1.0, t2=1.5, intrusion=1.0),
    navigation.IntegralLaw(t1=0.5, t2=1.0, intrusion=0.3),
    navigation.Scaled(navigation.IntegralLaw(t1=0.5, t2=1.0), 1.5, cap=1.2),
    navigation.FixedDistance(1.0),
)
shapes = navigation.Shapes(
    machine=(navigation.Box(length=1.05, width=0.95, bottom=1.2, top=2.7),
             navigation.Cylinder(radius=1.2, bottom=1.9, top=2.7))
)
stops = gantry_stops(), agv_stops(floorplan.load("ariac2023").lane("agv1"))
for _ in range(40):
    person = navigation.walk([place() for _ in range(4)], rng.uniform(0, 3))
    digest.update(repr([*navigation.stop_walking(person, person.end / 2).table]).encode())
    machine = navigation.gantry_move((*place(), 0.0), (*place(), rng.uniform(-3, 3)), 1.0)
    pair = (person, machine)
    people = [c for _ in range(3) for c in (*place(), 1.5, rng.choice((-1.0, 2.0)))]
    away = nearest_on(machine.table, people, 2.0, 2.0, 9.0, 0.5, 5.0)
    digest.update(repr(away).encode())
    places = [c for _ in range(9) for c in place()]
    remote = most_remote(places, people, [0.0, 1.0, 2.0], 1.5, 1.0, 0.5, 3.0)
    digest.update(repr(remote).encode())
    for law in laws:
        for stop in stops if hasattr(law, "distance") else ():
            horizon = StoppingHorizon(law, 0.01)
            found = horizon.safe_until(machine.table, stop, people, 2.0, 0.2)
            digest.update(repr((found, [*stop.table(machine.table, 3.0)])).encode())
        for solids in (None, shapes):
            digest.update(repr((
                navigation.violations(*pair, law, 0.0, 20.0, shapes=solids),
                navigation.minimum_margin(*pair, law, 0.0, 20.0, shapes=solids),
                navigation.minimum_separation(*pair, 0.0, 20.0, shapes=solids),
            )).encode())
corners = [(-1.0, -0.5), (2.0, -0.8), (0.5, 0.0), (2.5, 0.6), (-1.0, 0.5)]
fields = navigation.ProtectiveFields(sets=(
    navigation.FieldSet(name="slow", protective=corners, linear=(-0.2, 0.4), theta=(-0.5, 0.5)),
    navigation.FieldSet(name="fast", protective=[(2 * x, y) for x, y in corners]),
))
for _ in range(40):
    person = navigation.walk([place() for _ in range(4)], rng.uniform(0, 3))
    twist = rng.uniform(-1, 1), rng.uniform(-1, 1)
    machine = navigation.vehicle_twist((*place(), rng.uniform(-3, 3)), twist, seconds=4.0)
    poses = poses_along(machine.table, 0.3, machine.end)
    corner = numbers([c for point in corners for c in point])
    areas = [swept(poses, corner, corner, turns) for turns in (True, False)]
    met = Polygons(areas[0]).meet(Polygons(swept(numbers((*place(), 1.0)), corner, corner, True)))
    digest.update(repr(([[[*one] for one in area] for area in areas], met)).encode())
    digest.update(repr((
        fields.applying(machine, 0.0, 9.0),
        [*carried(machine, *place()).table],
        navigation.intrusions(fields, machine, person, 0.3, 0.0, 9.0),
    )).encode())
for name in ("ariac2023", "people_aisle", "people_door"):
    with tempfile.TemporaryDirectory() as folder:
        recording = sim.Recording(pathlib.Path(folder))
        recording.finish(sim.run(sim.Trial.load(name), recording))
        for file in ("events.jsonl", "motions.jsonl", "trajectory.csv"):
            digest.update(pathlib.Path(folder, file).read_bytes())
world = navigation.CollisionWorld(floorplan.load("ariac2023"))
planner = navigation.PathPlanner(world, 0.3)
for _ in range(30):
    for lane in world.plan.lanes:
        world.move_agv(lane.name, rng.uniform(*lane.limits))
    ends = [(rng.uniform(-22, 2), rng.uniform(-12, 12)) for _ in range(2)]
    try:
        digest.update(planner.plan(*ends).points.tobytes())
    except navigation.PlanningError as why:
        digest.update(why.reason.encode())
for limits in (navigation.VehicleLimits(), navigation.VehicleLimits(side_speed=1.0)):
    vehicles = navigation.VehiclePlanner(world, shapely.Polygon(corners), limits=limits)
    world.place("disc", navigation.Disc((-6.0, 3.0), 0.4))
    for _ in range(20):
        ends = [(rng.uniform(-22, 2), rng.uniform(-12, 12), rng.uniform(-3, 3)) for _ in range(2)]
        room = vehicles.room
        digest.update(repr((
            room.fits(*ends[0]), room.between(ends[0], ends[1][:2], ends[1][2]),
            [*room.drive_box(*ends[0][:2], *ends[1])],
        )).encode())
print(digest.hexdigest())
"""


@pytest.mark.slow
@pytest.mark.skipif(not COMPILED, reason="the kernels are not compiled here")
def test_results_are_the_same_compiled_and_not(tmp_path):
    runs = [
        subprocess.run(
            [sys.executable, "-c", before + RUN],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        for before in ("", AS_PYTHON)
    ]
    assert [run.stderr.split()[0] for run in runs] == ["True", "False"]
    assert runs[0].stdout == runs[1].stdout


def test_kernels_import_no_modules_above_them():
    for module in Path(kernels.__file__).parent.glob("*.py"):
        tree = ast.parse(module.read_text(encoding="utf-8"))
        imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        assert all(node.level < 2 for node in imports), module.name
        assert not any((node.module or "").startswith("navigation") for node in imports)


@pytest.mark.parametrize("n", [5, 8])
def test_quadratures_are_gauss_and_legendres(n):
    nodes, weights = np.polynomial.legendre.leggauss(n)
    assert getattr(quadrature, f"NODES_{n}") == pytest.approx(nodes, rel=1e-15, abs=1e-16)
    assert getattr(quadrature, f"WEIGHTS_{n}") == pytest.approx(weights, rel=1e-14)


HALL = shapely.box(-40.0, -40.0, 40.0, 40.0)
CELL, CLEARANCE = 0.3, 0.2
METRES = st.floats(-25.0, 25.0)


def least_cost(blocked: bytearray, columns: int, start: int, goal: int) -> int | None:
    """Return the cost of a shortest path, by Dijkstra's algorithm."""
    known = {start: 0}
    queue = [(0, start)]
    while queue:
        cost, cell = heapq.heappop(queue)
        if cell == goal:
            return cost
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            beside = (cell + dx, cell + dy * columns, cell + dx + dy * columns)
            dearer = cost + (7 if dx and dy else 5)
            if not any(blocked[one] for one in beside) and dearer < known.get(beside[2], 10**9):
                known[beside[2]] = dearer
                heapq.heappush(queue, (dearer, beside[2]))
    return None


def test_paths_are_the_shortest_and_avoid_blocked_cells():
    rng = random.Random(5)
    found = 0
    for _ in range(200):
        columns, rows = rng.randint(4, 24), rng.randint(4, 24)
        blocked = bytearray(b"\1" * (columns * rows))
        for row in range(1, rows - 1):
            for column in range(1, columns - 1):
                blocked[row * columns + column] = rng.random() < 0.3
        start, goal = (
            rng.randrange(1, rows - 1) * columns + rng.randrange(1, columns - 1) for _ in range(2)
        )
        blocked[start] = blocked[goal] = 0
        path = grid_path(blocked, columns, start, goal)
        least = least_cost(blocked, columns, start, goal)
        if least is None:
            assert path == []
            continue
        found += 1
        assert path[0] == start and path[-1] == goal
        cost = 0
        for a, b in itertools.pairwise(path):
            dx, dy = b % columns - a % columns, b // columns - a // columns
            assert max(abs(dx), abs(dy)) == 1
            assert not any(blocked[one] for one in (a + dx, a + dy * columns, b))
            cost += 7 if dx and dy else 5
        assert cost == least
    assert found > 50


def test_discs_block_the_cells_whose_centre_they_cover():
    columns, rows, width, low = 12, 9, 0.3, (-1.0, 2.0)
    blocked = bytearray(columns * rows)
    discs = numbers([0.2, 3.1, 0.62, -0.9, 2.1, 0.3])
    block_discs(blocked, columns, low, width, discs)
    for k, taken in enumerate(blocked):
        x = low[0] + (k % columns + 0.5) * width
        y = low[1] + (k // columns + 0.5) * width
        near = [(x - discs[i]) ** 2 + (y - discs[i + 1]) ** 2 < discs[i + 2] ** 2 for i in (0, 3)]
        assert bool(taken) == any(near)


def ways_round() -> tuple[WaysRound, Legs]:
    """Return the path search in the hall for a person with `CLEARANCE`."""
    room = HALL.buffer(-CLEARANCE)

    def chunk(i: int, j: int) -> bytes:
        along = (np.arange(CHUNK) + 0.5) * CELL
        x, y = np.meshgrid(i * CHUNK * CELL + along, j * CHUNK * CELL + along)
        return (~shapely.intersects_xy(room, x, y)).tobytes()

    legs = Legs(walls(HALL), CLEARANCE, lambda a, b: True)
    return WaysRound(CELL, 6.0, 60_000, chunk), legs


@given(st.lists(st.tuples(METRES, METRES), max_size=20), st.tuples(METRES, METRES))
def test_detours_avoid_all_discs(discs, end):
    ways, legs = ways_round()
    begin, away = (-30.0, -30.0), 0.7
    standing = numbers(number for x, y in discs for number in (x, y, away))
    path = ways.path(begin, end, standing, legs)
    if all(math.dist(end, disc) > 2 * away for disc in discs) and len(discs) < 2:
        assert path
    assume(path)
    assert path[0] == begin and path[-1] == end
    line = shapely.LineString(path)
    assert HALL.buffer(-CLEARANCE).covers(line)
    assert all(line.distance(shapely.Point(disc)) > away - 1e-9 for disc in discs)


def test_detours_are_the_same_on_every_side_of_the_origin():
    ways, legs = ways_round()
    lengths = set()
    for x, y in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        a, b, disc = (20.25 * x, 20.25 * y), (30.15 * x, 20.25 * y), (25.05 * x, 20.25 * y, 0.7)
        path = ways.path(a, b, numbers(disc), legs)
        lengths.add(round(sum(itertools.starmap(math.dist, itertools.pairwise(path))), 9))
    assert len(lengths) == 1 and 9.9 < lengths.pop() < 10.5


NOW, GAP, RADIUS = 3.0, 0.006, 0.3
NOWHERE = (False, math.inf, math.inf)


def committed(*motions: navigation.Motion) -> CommittedMotions:
    """Return discs without routes that are committed to these motions from `NOW` on."""
    made = CommittedMotions(GAP)
    for motion in motions:
        made.add(swath(motion, NOW), RADIUS)
    return made


def standing(*places: tuple[float, float]) -> CommittedMotions:
    return committed(*(navigation.standing(place) for place in places))


def test_headings_are_those_of_velocities_or_routes():
    east = navigation.walk([(0.0, 0.0), (9.0, 0.0)], NOW - 1.0)
    seen = committed(east, navigation.standing((5.0, 5.0)), navigation.standing((1.0, 1.0)))
    seen.send(0, True, 0.0, 9.0)
    seen.send(1, True, 8.0, 9.0)
    assert seen.between(0, 1, NOW) == 0.6
    assert seen.between(1, 0, NOW) == 0.6
    # At the end of a walk, the heading is that of the route.
    assert math.isclose(seen.between(0, 1, east.end), (0.8 - 0.6) / math.sqrt(2))
    assert seen.between(0, 2, NOW) == 0.0
    seen.send(1, *NOWHERE)
    assert seen.between(0, 1, NOW) == 0.0


def test_standing_people_nearby_are_returned_with_their_distance():
    later = navigation.walk([(1.0, 0.0), (1.0, 5.0)], NOW)
    seen = committed(navigation.standing((0.0, 0.0)), navigation.standing((2.0, 0.0)), later)
    near = numbers([0.0, 0.0, 0.0, 0.0])
    assert [*seen.standing(0, near, 3.0, NOW)] == [2.0, 0.0, RADIUS + RADIUS + GAP]
    assert [*seen.standing(0, near, 0.5, NOW)] == []
    assert [*seen.standing(1, near, 3.0, later.end)] == [
        *(0.0, 0.0, RADIUS + RADIUS + GAP),
        *(1.0, 5.0, RADIUS + RADIUS + GAP),
    ]


def test_a_ring_grows_through_gaps_that_are_too_narrow():
    # From (0, 0) by two people to the third. The fourth leaves a gap to them.
    seen = standing((9.0, 9.0), (0.2, 0.0), (1.3, 0.0), (2.4, 0.0), (4.0, 0.0))
    around = [k for k in range(1, 5) if seen.encloses(0, k, 0.0, 0.0, 6.0, NOW)]
    assert around == [1, 2, 3]


def test_segments_are_tested_against_walls_and_bodies():
    asked = []

    def ask(a: tuple[float, float], b: tuple[float, float]) -> bool:
        asked.append((a, b))
        return False

    legs = Legs(walls(shapely.box(0.0, 0.0, 9.0, 9.0)), RADIUS, ask)
    legs.bounds = numbers([4.0, 4.0, 5.0, 5.0])
    assert legs.free(1.0, 1.0, 8.0, 1.0) and not legs.free(1.0, 1.0, 8.8, 1.0)
    assert not asked
    assert not legs.free(1.0, 4.5, 8.0, 4.5)
    assert asked == [((1.0, 4.5), (8.0, 4.5))]
    assert legs.farthest(1.0, 1.0, [(1.0, 2.0), (1.0, 8.0), (8.0, 8.0)]) == 1
    assert legs.farthest(1.0, 1.0, [(9.0, 1.0)]) == -1
