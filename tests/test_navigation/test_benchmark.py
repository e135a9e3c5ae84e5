import csv
import math
import sqlite3
from collections import Counter
from contextlib import closing
from dataclasses import replace

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
    PEERS,
    SHORTFALL,
    Answer,
    Asked,
    ShortestPaths,
    benchmark,
    drawn_questions,
    evaluate,
    summary,
    write_csv,
    write_ompl_log,
)


@pytest.fixture(scope="module")
def attempts():
    plans = [floorplan.load("ariac2023"), floorplan.load("machine_shop")]
    return benchmark(plans, ["Roadmap", "RRTConnect"], queries=6, seed=1)


def without_times(attempts):
    """Return everything that is reproducible: all results except times and memory."""
    return [
        (
            *(a.asked, a.reason, a.wrong, a.length, a.clearance, a.turning),
            a.points.tolist(),
            [(one.iterations, one.length) for one in a.progress],
        )
        for a in attempts
    ]


def test_answers_are_measured(attempts):
    assert len(attempts) == 2 * 2 * 6
    for a in attempts:
        assert a.solved
        assert a.cpu_seconds > 0
        assert a.clearance >= 0.25 - 1e-9
        assert a.ratio >= 1 - 1e-9
        assert (a.turning == 0) == (a.bends == 0)
        assert a.right
        assert [one.length for one in a.progress] == sorted(
            {one.length for one in a.progress}, reverse=True
        )
        assert a.progress[-1].length == pytest.approx(a.length)
        if a.asked.planner == "Roadmap":
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
    assert str(without_times(again)) == str(without_times(attempts))
    assert len(seen) == len(again)
    other = benchmark(plans[:1], ["Roadmap"], queries=6, seed=2)
    assert str(without_times(other)) != str(without_times(attempts[:6]))


def test_questions_have_answers():
    plan = floorplan.load("ariac2023")
    questions = list(drawn_questions(plan, queries=25, seed=3, radius=0.3))
    assert [*Counter(one.agvs for one in questions).values()] == [10, 10, 5]
    world = CollisionWorld(plan)
    for one in questions:
        for name, at in one.agvs:
            world.move_agv(name, at)
        assert world.free(one.start, 0.3)
        assert world.free(one.goal, 0.3)
        assert math.dist(one.start, one.goal) - 1e-9 <= one.shortest < 100


def test_a_floor_without_room_is_reported():
    plan = Floorplan(name="cell", boundary=box(0, 0, 1, 1))
    with pytest.raises(ValueError, match=r"cell has no two places for a radius of 0\.6 m"):
        benchmark([plan], ["Roadmap"], queries=1, radius=0.6)


def test_shortest_lengths_equal_closed_forms():
    """Around a pillar and around the end of a wall, in closed form."""
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


def test_gaps_just_as_wide_as_the_disc_are_closed():
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
    first = [a for a in attempts if (a.asked.floorplan, a.asked.planner) == names[0]]
    assert rows[0].queries == 6
    assert rows[0].solved.value == 1.0
    assert rows[0].cpu.value == pytest.approx(1000 * np.median([a.cpu_seconds for a in first]))
    assert rows[0].ratio_most == max(a.ratio for a in first)


def test_csv_has_every_answer(attempts, tmp_path):
    write_csv(attempts, tmp_path / "b.csv")
    with (tmp_path / "b.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(attempts)
    assert float(lines[3]["length"]) == attempts[3].length
    assert lines[3]["planner"] == attempts[3].asked.planner
    assert float(lines[3]["x1"]) == attempts[3].asked.goal[0]


def test_the_log_converts_to_a_database_of_ompl(attempts, tmp_path):
    """OMPL's script creates the database for Planner Arena."""
    statistics = pytest.importorskip("ompl.tools")
    there = [a for a in attempts if a.asked.floorplan == "ariac2023"]
    write_ompl_log(there, tmp_path / "b.log", seed=1)
    database = tmp_path / "b.db"
    statistics.readBenchmarkLog(str(database), [str(tmp_path / "b.log")], False)
    statistics.computeViews(str(database), False)
    with closing(sqlite3.connect(database)) as found:
        found.row_factory = sqlite3.Row
        (experiment,) = found.execute("SELECT * FROM experiments")
        assert (experiment["name"], experiment["seed"], experiment["runcount"]) == (
            "ariac2023",
            "1",
            6,
        )
        planners = [row["name"] for row in found.execute("SELECT name FROM plannerConfigs")]
        assert planners == ["geometric_Roadmap", "geometric_RRTConnect"]
        runs = found.execute("SELECT * FROM runs ORDER BY id").fetchall()
        for run, attempt in zip(runs, there, strict=True):
            assert run["time"] == attempt.planning_seconds
            assert run["simplification_time"] == attempt.simplification_seconds
            assert run["solution_length"] == attempt.length
            assert run["solution_smoothness"] == attempt.ompl_smoothness
            assert run["solution_clearance"] == attempt.ompl_clearance
            assert run["least_clearance"] == attempt.clearance
            curve = "SELECT time, best_cost FROM progress WHERE runid = ? ORDER BY time"
            assert [tuple(row) for row in found.execute(curve, [run["id"]])] == [
                (one.cpu_seconds, one.length) for one in attempt.progress
            ]


def question():
    """Return a question from one side of a wall to the other."""
    return Asked(
        floorplan="barred",
        planner="somebody",
        query=0,
        run=0,
        seed=0,
        start=(1, 2),
        goal=(9, 2),
        shortest=14.0,
        longest=1.5,
    )


def by_ompl(points, clear):
    """Return clearance and smoothness of a polyline by OMPL."""
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


def test_smoothness_and_clearance_equal_those_of_ompl():
    world = CollisionWorld(floorplan.load("ariac2023"))
    asked = question()
    rng = np.random.default_rng(0)
    back_and_forth = [(0, 0), (1, 0), (2, 0), (1, 0), (1, 1)]
    paths = [back_and_forth, *(rng.uniform(-12, 8, (n, 2)) for n in (2, 3, 20))]
    for points in [np.array(path, dtype=float) for path in paths]:
        clear, smooth = by_ompl(points, lambda at: world.distance(at) - 0.3)
        found = evaluate(asked, Answer(points=points), world, 0.3)
        assert found.ompl_clearance == pytest.approx(clear)
        assert found.ompl_smoothness == pytest.approx(smooth, rel=1e-6)


def test_shortest_paths_do_not_cut_corners():
    """Every path is at least as long as one around corners of radius 0."""
    rng = np.random.default_rng(0)
    room = box(0, 0, 10, 10).difference(shapely.union_all([box(2, 2, 4, 8), box(6, 0, 7, 7)]))
    narrow, wide = ShortestPaths(room, 1e-3), ShortestPaths(room, 0.4)
    for _ in range(30):
        a, b = rng.uniform(0.5, 9.5, (2, 2))
        if wide.room.contains(Point(a)) and wide.room.contains(Point(b)):
            length = wide.length(tuple(a), tuple(b))
            assert length >= narrow.length(tuple(a), tuple(b)) - 1e-6


def test_the_shortest_path_on_an_empty_floor_is_straight():
    plan = Floorplan(
        name="hall",
        boundary=box(0, 0, 5, 5),
        obstacles=(Obstacle(name="lamp", footprint=box(1, 1, 2, 2), bottom=2.0, top=3.0),),
    )
    (one,) = benchmark([plan], ["Roadmap"], queries=1)
    assert one.ratio == 1.0
    assert one.turning == 0.0


BARRED = Floorplan(
    name="barred",
    boundary=box(0, 0, 10, 10),
    obstacles=(Obstacle(name="wall", footprint=box(4, -1, 6, 6), bottom=0.0, top=3.0),),
)


def test_budgets_and_parameters_reach_the_planner():
    """RRT* finds shorter paths with a larger budget, and each run has its own seed."""
    few, many = (
        benchmark([BARRED], ["RRTstar: {simplify: false}"], queries=3, runs=2, iterations=count)
        for count in (200, 1000)
    )
    assert [a.asked.run for a in few] == [0, 1, 0, 1, 0, 1]
    assert len({a.asked.seed for a in few}) == 6
    assert sum(a.length for a in many) < sum(a.length for a in few)
    assert max(one.iterations for a in many for one in a.progress) <= 1001
    assert all(a.simplification_seconds < a.planning_seconds for a in many)
    (timed,) = benchmark([BARRED], ["RRTstar: {simplify: false}"], queries=1, seconds=0.02)
    assert timed.progress


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"planners": ["RRTConect"]}, "did you mean 'RRTConnect'"),
        ({"planners": ["BITstar: {samples_per_bath: 50}"]}, "no parameter 'samples_per_bath'"),
        ({"iterations": 0}, "iterations must be 1 or more, found 0"),
        ({"seconds": 0.0}, "seconds must be above 0 and finite, found 0"),
        ({"seconds": math.nan}, "seconds must be above 0 and finite, found nan"),
        ({"radius": math.nan}, "radius must be above 0 and finite, found nan"),
        ({"longest": 0.5}, "longest must be above 1 and finite, found 0.5"),
        ({"runs": 0}, "runs must be 1 or more"),
        ({"plans": [BARRED, BARRED]}, "two floors are called 'barred'"),
    ],
)
def test_invalid_parameters_are_rejected(options, words):
    terms = {"plans": [BARRED], "planners": ["Roadmap"], "queries": 1, **options}
    with pytest.raises(ValueError, match=words):
        benchmark(**terms)


def test_wrong_answers_are_classified():
    asked = question()
    world = CollisionWorld(BARRED)

    def fault(points, reason="", **other):
        line = None if points is None else np.array(points, dtype=float)
        answer = Answer(points=line, reason=reason)
        return evaluate(replace(asked, **other), answer, world, 0.3).wrong

    over = [(1, 2), (3.7, 6.3), (6.3, 6.3), (9, 2)]
    assert fault(over) == ""
    assert fault([(1, 2), (3.8, 6.2), (6.2, 6.2), (9, 2)]) == "touches"
    assert fault([(1, 2), (9, 2)]) == "touches"
    assert fault(over[1:]) == "elsewhere"
    assert fault([*over[:2], (1, 9), (9, 9), over[3]]) == "too long"
    assert fault(None, "unreachable") == "none"
    assert fault(None, "unreachable", shortest=math.inf) == ""
    assert fault(None, "not_found") == ""
    assert not evaluate(asked, Answer(points=np.full((3, 2), math.nan)), world, 0.3).solved
    there = replace(asked, goal=asked.start, shortest=0.0)
    assert math.isnan(evaluate(there, Answer(reason="not_found"), world, 0.3).ratio)
    stays = evaluate(there, Answer(points=np.array([asked.start])), world, 0.3)
    assert (stays.right, stays.ratio, stays.length) == (True, 1.0, 0.0)


@pytest.mark.parametrize(
    "name",
    [
        "machine_shop",
        pytest.param("ariac2023", marks=pytest.mark.slow),
        pytest.param("warehouse", marks=pytest.mark.slow),
    ],
)
def test_ompls_own_roadmap_planner_finds_paths_as_long_as_the_default(name):
    """Its samples are the corner points, FCL tests every link, and OMPL searches."""
    plan = floorplan.load(name)
    ours, prms = (
        benchmark([plan], [planner], queries=6, seed=5) for planner in ("Roadmap", "PRM-of-corners")
    )
    assert all(one.right for one in ours)
    for one, other in zip(ours, prms, strict=True):
        assert other.length == pytest.approx(one.length, abs=1e-6)


def test_ompls_own_roadmap_planner_finds_nothing_without_a_path(
    tmp_path,
):
    parted = tmp_path / "parted.yaml"
    parted.write_text(
        "boundary: [[0, 0], [10, 0], [10, 6], [0, 6]]\n"
        "obstacles: {wall: {x: [4, 5], y: [0, 6], z: [0, 3]}}\n"
    )
    world = CollisionWorld(floorplan.load(parted))
    search = PEERS["PRM-of-corners"].prepare(world, 0.3)
    assert search((2.0, 3.0), (8.0, 3.0)) is None
    assert search((2.0, 3.0), (3.0, 1.0)) == [(2.0, 3.0), (3.0, 1.0)]


@pytest.mark.parametrize("name", PEERS)
def test_peers_answer_the_same_questions(name):
    """Each keeps the radius and goes around the wall."""
    if not PEERS[name].installed:
        with pytest.raises(ValueError, match=f"{name} is not installed: pip install"):
            benchmark([BARRED], [name], queries=1)
        pytest.skip(f"{name} is not installed")
    ours, theirs = (
        benchmark([BARRED], [planner], queries=8, seed=4) for planner in ("Roadmap", name)
    )
    for one, other in zip(ours, theirs, strict=True):
        assert (one.asked.start, one.asked.goal) == (other.asked.start, other.asked.goal)
        assert other.right, other.reason
        assert 1 - 2 * SHORTFALL <= other.ratio < 1.5
        assert other.clearance > 0.3 - 0.002
