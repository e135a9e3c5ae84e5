import csv
import math

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import pytest
import shapely
from shapely.geometry import Point, box

import floorplan
from floorplan import Floorplan, Obstacle
from navigation import CollisionWorld
from navigation.benchmark import (
    SHORTFALL,
    ShortestPaths,
    benchmark,
    scenes,
    summary,
    write_csv,
    write_ompl_log,
)
from navigation.benchmark.measuring import ompl_clearance, ompl_smoothness


@pytest.fixture(scope="module")
def attempts():
    plans = [floorplan.load("ariac2023"), floorplan.load("machine_shop")]
    return benchmark(plans, ["Roadmap", "RRTConnect"], queries=6, seed=1)


def without_times(attempts):
    return [repr({**vars(a), "cpu_seconds": None}) for a in attempts]


def test_answers_are_measured(attempts):
    assert len(attempts) == 2 * 2 * 6
    for a in attempts:
        assert a.solved
        assert a.cpu_seconds > 0
        assert a.checks > 0
        assert a.clearance >= 0.25 - 1e-9
        assert a.ratio >= 1 - 1e-9
        assert (a.turning == 0) == (a.bends == 0)
        if a.planner == "Roadmap":
            assert a.ratio <= 1.01


def test_the_same_seed_measures_the_same(attempts):
    plans = [floorplan.load("ariac2023"), floorplan.load("machine_shop")]
    seen = []
    again = benchmark(
        plans,
        ["Roadmap", "RRTConnect"],
        queries=6,
        seed=1,
        progress=lambda floor, planner: seen.append((floor, planner)),
    )
    assert without_times(again) == without_times(attempts)
    assert len(seen) == len(again)
    other = benchmark(plans[:1], ["Roadmap"], queries=6, seed=2)
    assert without_times(other) != without_times(attempts[:6])


def test_questions_have_answers():
    plan = floorplan.load("ariac2023")
    for scene in scenes(plan, queries=25, seed=3, radius=0.3):
        assert len(scene.questions) in (10, 5)
        world = CollisionWorld(plan)
        for name, at in scene.agvs:
            world.move_agv(name, at)
        for (start, goal), best in zip(scene.questions, scene.shortest, strict=True):
            assert world.free(start, 0.3)
            assert world.free(goal, 0.3)
            assert math.dist(start, goal) - 1e-9 <= best < 100


def test_no_room_is_said():
    plan = Floorplan("cell", box(0, 0, 1, 1))
    with pytest.raises(ValueError, match=r"cell has no two places for a radius of 0\.6 m"):
        benchmark([plan], ["Roadmap"], queries=1, radius=0.6)


def test_lengths_of_shortest_ways():
    """Round a pillar and round a wall's end, where they are known in closed form."""
    room = box(0, 0, 10, 10).difference(box(4, -1, 6, 6))
    ways = ShortestPaths(room, 0.5)
    assert ways.length((1, 9), (9, 9)) == 8
    a, b = (1.0, 2.0), (9.0, 2.0)
    # Tangent, quarter of an arc at each corner, and straight over the wall.
    away = math.dist(a, (4, 6))
    tangent = math.sqrt(away**2 - 0.25)
    direction = math.atan2(4, 3) + math.asin(0.5 / away)
    arc = 0.5 * direction
    exact = 2 * (tangent + arc) + 2
    assert exact - 2 * arc * SHORTFALL - 1e-6 <= ways.length(a, b) <= exact
    assert ways.length(a, (1, 1)) == 1
    cut = ShortestPaths(box(0, 0, 10, 10).difference(box(4, -1, 6, 11)), 0.5)
    assert cut.length(a, b) == math.inf


def test_gaps_just_as_wide_as_the_disc_are_no_ways():
    room = box(0, 0, 10, 10).difference(shapely.union_all([box(4, 0, 6, 5), box(4, 5.6, 6, 9)]))
    assert ShortestPaths(room, 0.3).length((2, 5.3), (8, 5.3)) > 8
    assert ShortestPaths(room, 0.298).length((2, 5.3), (8, 5.3)) == pytest.approx(6)


def test_summary_has_a_row_for_each_floor_and_planner(attempts):
    rows = summary(attempts)
    names = [(row.floorplan, row.planner) for row in rows]
    assert names == [
        ("ariac2023", "Roadmap"),
        ("ariac2023", "RRTConnect"),
        ("machine_shop", "Roadmap"),
        ("machine_shop", "RRTConnect"),
    ]
    first = [a for a in attempts if (a.floorplan, a.planner) == names[0]]
    assert rows[0].queries == 6
    assert rows[0].solved == 1.0
    assert rows[0].cpu_median == pytest.approx(1000 * np.median([a.cpu_seconds for a in first]))
    assert rows[0].ratio_most == max(a.ratio for a in first)


def test_csv_has_every_answer(attempts, tmp_path):
    write_csv(attempts, tmp_path / "b.csv")
    with (tmp_path / "b.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(attempts)
    assert float(lines[3]["length"]) == attempts[3].length
    assert lines[3]["planner"] == attempts[3].planner


def test_ompl_log_reads_as_its_tools_read_it(attempts, tmp_path):
    """The lines, one after the other, that ompl_benchmark_statistics.py asks for."""
    there = [a for a in attempts if a.floorplan == "ariac2023"]
    write_ompl_log(there, tmp_path / "b.log", seed=1)
    lines = iter((tmp_path / "b.log").read_text().splitlines())
    assert next(lines).split()[:2] == ["OMPL", "version"]
    assert next(lines) == "Experiment ariac2023"
    assert next(lines) == "0 experiment properties"
    assert next(lines).startswith("Running on ")
    assert next(lines).startswith("Starting at 2")
    for _ in range(2):
        assert next(lines) == "<<<|"
        while next(lines) != "|>>>":
            pass
    assert next(lines) == "1 is the random seed"
    assert next(lines).endswith(" seconds per run")
    assert next(lines).endswith(" MB per run")
    assert next(lines) == "6 runs per planner"
    assert next(lines).endswith(" seconds spent to collect the data")
    assert next(lines) == "0 enum types"
    assert next(lines) == "2 planners"
    for name in ("Roadmap", "RRTConnect"):
        assert next(lines) == f"geometric_{name}"
        assert next(lines) == "0 common properties"
        count = int(next(lines).removesuffix(" properties for each run"))
        names = [next(lines) for _ in range(count)]
        assert {one.split()[-1] for one in names} <= {"REAL", "INTEGER", "BOOLEAN"}
        runs = [a for a in there if a.planner == name]
        assert next(lines) == f"{len(runs)} runs"
        for run in runs:
            values = next(lines).split("; ")
            assert values.pop() == ""
            logged = dict(zip(names, map(float, values), strict=True))
            assert logged["time REAL"] == run.cpu_seconds
            assert logged["solution length REAL"] == run.length
            assert logged["solution smoothness REAL"] == run.ompl_smoothness
            assert logged["solution clearance REAL"] == run.ompl_clearance
            assert logged["least clearance REAL"] == run.clearance
            assert run.clearance - 0.3 <= run.ompl_clearance + 1e-9
        assert next(lines) == "."
    assert next(lines, None) is None


def by_ompl(points, clear):
    """Clearance and smoothness of a polyline, asked of OMPL itself."""
    space = ob.RealVectorStateSpace(2)
    bounds = ob.RealVectorBounds(2)
    bounds.setLow(-50.0)
    bounds.setHigh(50.0)
    space.setBounds(bounds)
    information = ob.SpaceInformation(space)

    class Checker(ob.StateValidityChecker):
        def isValid(self, state):
            return True

        def clearance(self, state):
            return clear((state[0], state[1]))

    checker = Checker(information)
    information.setStateValidityChecker(checker)
    information.setup()
    path = og.PathGeometric(information)
    for point in points:
        state = information.allocState()
        state[0], state[1] = point
        path.append(state)
    return path.clearance(), path.smoothness()


def test_smoothness_and_clearance_are_as_ompl_has_them():
    world = CollisionWorld(floorplan.load("ariac2023"))
    rng = np.random.default_rng(0)
    back_and_forth = [(0, 0), (1, 0), (2, 0), (1, 0), (1, 1)]
    paths = [back_and_forth, *(rng.uniform(-12, 8, (n, 2)) for n in (2, 3, 20))]
    for points in [np.array(path, dtype=float) for path in paths]:
        clear, smooth = by_ompl(points, lambda at: world.distance(at) - 0.3)
        assert ompl_clearance(points, world.distance, 0.3) == pytest.approx(clear)
        assert ompl_smoothness(points) == pytest.approx(smooth, rel=1e-6)


def test_shortest_ways_do_not_cut_corners():
    """Every way is at least as long as one for which corners are points."""
    rng = np.random.default_rng(0)
    room = box(0, 0, 10, 10).difference(shapely.union_all([box(2, 2, 4, 8), box(6, 0, 7, 7)]))
    narrow, wide = ShortestPaths(room, 1e-3), ShortestPaths(room, 0.4)
    for _ in range(30):
        a, b = rng.uniform(0.5, 9.5, (2, 2))
        if wide.room.contains(Point(a)) and wide.room.contains(Point(b)):
            length = wide.length(tuple(a), tuple(b))
            assert length >= narrow.length(tuple(a), tuple(b)) - 1e-6


def test_a_floor_without_obstacles():
    plan = Floorplan("hall", box(0, 0, 5, 5), (Obstacle("lamp", box(1, 1, 2, 2), 2.0, 3.0),))
    (one,) = benchmark([plan], ["Roadmap"], queries=1)
    assert one.ratio == 1.0
    assert one.turning == 0.0
