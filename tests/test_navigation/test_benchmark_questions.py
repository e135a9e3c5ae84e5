"""Files of questions, and statistics of answers over time."""

import heapq
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import floorplan
from navigation.benchmark import (
    Asked,
    Attempt,
    Progress,
    QuestionsError,
    benchmark,
    cost_over_time,
    map_of,
    median,
    read_questions,
    share,
    success_over_time,
    summary,
)

EXAMPLES = Path(__file__).parents[2] / "examples"
MAP = """type octile
height 4
width 6
map
......
.@@@..
..T...
......
"""


@pytest.fixture
def hall(tmp_path):
    (tmp_path / "hall.map").write_text(MAP)
    return tmp_path


def ask(path, plan, text, **options):
    path.write_text(text)
    return read_questions(path, plan, radius=0.3, **options)


def test_a_table_places_the_agvs_of_each_question(tmp_path):
    plan = floorplan.load("ariac2023")
    text = "x0, y0, x1, y1, agv1\n-15,-10,-5,3.75,as1\n\n-15,-10,-5,3.75,\n-14,-9,-5,3.75,\n"
    first, second, third = ask(tmp_path / "q.csv", plan, text)
    assert dict(first.agvs)["agv1"] == plan.lane("agv1").lane_position("as1")
    assert dict(second.agvs)["agv1"] == plan.lane("agv1").lane_position(plan.lane("agv1").start)
    assert (first.start, first.goal) == ((-15.0, -10.0), (-5.0, 3.75))
    assert (third.start, third.agvs) == ((-14.0, -9.0), second.agvs)
    some = ask(tmp_path / "q.csv", plan, text.replace("as1", ""), queries=2, seed=1)
    assert len(some) == 2


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1: has no column x0"),
        ("x0,y0,x1,y1\n", "asks no question"),
        ("x0,y0,x1\n1,2,3\n", "line 1: has no column y1"),
        ("x0,y0,x1,y1,agv9\n", r"line 1: 'agv9' is no column.*did you mean 'agv[1-4]'"),
        ("x0,y0,x1,y1\n-15,-10,nan,3\n", "line 2, x1: must be a finite number, found 'nan'"),
        ("x0,y0,x1,y1\n-15,-10,,3\n", "line 2, x1: must be a finite number, found ''"),
        ("x0,y0,x1,y1\n-15,-10,3\n", "line 2: has 3 fields; the first line names 4"),
        ("x0,y0,x1,y1,agv1\n-15,-10,-5,3.75,mars\n", "line 2, agv1: agv1 has no location 'mars'"),
        ("x0,y0,x1,y1\n-15,-10,99,0\n", r"line 2: the goal \(99, 0\) is outside the boundary"),
    ],
)
def test_faults_of_a_table_are_reported(tmp_path, text, words):
    with pytest.raises(QuestionsError, match=words):
        ask(tmp_path / "q.csv", floorplan.load("ariac2023"), text)


def test_questions_without_a_path_are_valid(hall):
    walls = MAP.replace("..T...", "@@@@@@")
    (hall / "hall.map").write_text(walls)
    plan = floorplan.load(hall / "hall.map")
    (question,) = ask(hall / "q.csv", plan, "x0,y0,x1,y1\n0.5,0.5,0.5,3.5\n")
    assert question.shortest == math.inf
    (hall / "q.csv").write_text("x0,y0,x1,y1\n0.5,0.5,0.5,3.5\n")
    (one,) = attempts = benchmark([plan], ["Roadmap"], questions=hall / "q.csv")
    assert summary(attempts)[0].solved.value == 1.0
    assert success_over_time(attempts).value.tolist() == [1.0]
    assert (one.solved, one.reason, one.wrong, one.right) == (False, "unreachable", "", True)


def test_cells_of_a_scenario_count_from_the_top(hall):
    plan = floorplan.load(hall / "hall.map")
    line = "0\tmaps/hall.map\t6\t4\t0\t0\t3\t3\t5.41421356\n"
    (question,) = ask(hall / "hall.map.scen", plan, f"version 1\n{line}")
    assert map_of(hall / "hall.map.scen") == hall / "hall.map"
    assert (question.start, question.goal) == ((0.5, 3.5), (3.5, 0.5))
    assert question.listed == 5.41421356
    assert question.shortest < 5.41421356
    half = floorplan.load_movingai(hall / "hall.map", 0.5)
    (question,) = read_questions(hall / "hall.map.scen", half, radius=0.1)
    assert (question.start, question.goal) == ((0.25, 1.75), (1.75, 0.25))
    assert question.listed == pytest.approx(2.70710678)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0 other.map 6 4 0 0 3 3 5", "line 2: is about the map other.map, not about the floor"),
        ("0 hall.map 6 5 0 0 3 3 5", "line 2: is about a map of 6 × 5 cells, which hall is not"),
        ("0 hall.map 6 4 0 0 3 3", "line 2: has 8 columns"),
        ("0 hall.map 6 4 0 0 6 3 5", "line 2: a cell is outside the map of 6 × 4"),
        ("0 hall.map 6 4 0 0 nan 3 5", "line 2: must be a finite number, found 'nan'"),
        ("0 hall.map 6 4 0 0 1 1 5", r"line 2: the goal \(1\.5, 2\.5\) is inside obstacle1"),
    ],
)
def test_faults_of_a_scenario_are_reported(hall, line, words):
    plan = floorplan.load(hall / "hall.map")
    with pytest.raises(QuestionsError, match=words):
        ask(hall / "hall.map.scen", plan, f"version 1\n{line}\n")


@pytest.mark.parametrize("name", ["attic", "a" * 300])
def test_a_scenario_without_its_map_is_reported(hall, name):
    (hall / "a.scen").write_text(f"version 1\n0 {name}.map 6 4 0 0 3 3 5\n")
    message = rf"line 2: is about {name}\.map, but there is no file"
    with pytest.raises(QuestionsError, match=message):
        map_of(hall / "a.scen")


def over_cells(rows, start, goal):
    """Return the length of the shortest path over cells without cut corners (Dijkstra)."""
    free = {(x, y) for y, row in enumerate(rows) for x, cell in enumerate(row) if cell in ".GS"}
    best, queue = {start: 0.0}, [(0.0, start)]
    while queue:
        far, (x, y) = heapq.heappop(queue)
        if (x, y) == goal:
            return far
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                there, step = (x + dx, y + dy), math.hypot(dx, dy)
                open_ = {there, (x + dx, y), (x, y + dy)} <= free
                if open_ and far + step < best.get(there, math.inf):
                    best[there] = far + step
                    heapq.heappush(queue, (far + step, there))
    return math.inf


def test_listed_lengths_are_those_over_cells_and_exceed_shortest_paths():
    if not EXAMPLES.is_dir():
        pytest.skip("the examples are not there")
    scenario = EXAMPLES / "rooms.map.scen"
    rows = (EXAMPLES / "rooms.map").read_text().splitlines()[4:]
    attempts = benchmark([floorplan.load(map_of(scenario))], ["Roadmap"], questions=scenario)
    assert len(attempts) == 24
    for attempt in attempts:
        cells = [
            (int(x), len(rows) - 1 - int(y)) for x, y in (attempt.asked.start, attempt.asked.goal)
        ]
        assert attempt.asked.listed == pytest.approx(over_cells(rows, *cells), abs=1e-6)
        assert attempt.right
        assert attempt.ratio <= 1.006
        # In the open at most 1 - cos(22.5°) shorter. Cells also pass corners at a larger distance.
        assert 0.85 < attempt.listed_ratio <= 1.001


@pytest.mark.parametrize("n", [1, 4, 10, 50, 200])
def test_shares_have_wilson_s_interval(n):
    """Its ends are the shares at which the normal test just rejects the observed share."""
    for successes in {0, 1, n // 2, n}:
        p = successes / n
        found = share([1.0] * successes + [0.0] * (n - successes))
        assert found.value == pytest.approx(p)
        for end in (found.low, found.high):
            if 1e-12 < end < 1 - 1e-12:
                deviations = abs(p - end) / math.sqrt(end * (1 - end) / n)
                assert deviations == pytest.approx(1.959963984540054)
        assert 0 <= found.low <= p <= found.high <= 1
        assert found.low > 0 or successes == 0
        assert found.high < 1 or successes == n


@pytest.mark.parametrize("n", [6, 7, 20, 53, 200])
def test_medians_have_the_narrowest_interval_of_the_confidence(n):
    """The median is between two ranks with the probability of a binomial distribution."""
    found = median(list(range(n, 0, -1)))
    low, high = int(found.low), int(found.high)
    assert low + high == n + 1
    assert found.value == pytest.approx((n + 1) / 2)

    def held(low, high):
        return sum(Fraction(math.comb(n, k), 2**n) for k in range(low, high))

    assert held(low, high) >= Fraction(95, 100)
    assert held(low + 1, high - 1) < Fraction(95, 100)


def test_few_values_give_an_unbounded_interval():
    found = median([3.0, 1.0, 2.0])
    assert (found.value, found.low, found.high) == (2.0, -math.inf, math.inf)
    assert math.isnan(median([]).value)


def attempt(query, run, progress, shortest=10.0, longest=math.inf):
    """Return an answer with shorter and shorter paths, or none."""
    asked = Asked(
        floorplan="f",
        planner="p",
        query=query,
        run=run,
        seed=0,
        start=(0, 0),
        goal=(1, 1),
        shortest=shortest,
        longest=longest,
    )
    times = {"planning_seconds": 9.0, "simplification_seconds": 0.0, "scene_seconds": 0.0}
    figures = dict.fromkeys(
        ("memory", "length", "clearance", "turning", "ompl_clearance", "ompl_smoothness"), 0.0
    )
    return Attempt(
        asked=asked,
        solved=bool(progress),
        reason="" if progress else "not_found",
        wrong="",
        cpu_seconds=9.0,
        bends=0,
        points=None,
        progress=tuple(Progress(0, t, length) for t, length in progress),
        **times,
        **figures,
    )


ANSWERS = [
    attempt(0, 0, [(1.0, 20.0), (4.0, 10.0)]),
    attempt(0, 1, []),
    attempt(1, 0, [(2.0, 30.0)]),
    attempt(1, 1, [(3.0, 20.0)]),
]


def test_success_over_time_counts_each_question_once():
    curve = success_over_time(ANSWERS)
    assert curve.seconds.tolist() == [1.0, 2.0, 3.0]
    assert curve.value.tolist() == [0.25, 0.5, 0.75]
    assert (curve.low <= curve.value).all()
    assert (curve.value <= curve.high).all()


def test_a_path_beyond_the_limit_is_no_success_yet():
    found = [(1.0, 20.0), (4.0, 15.0), (5.0, 10.0)]
    curve = success_over_time([attempt(0, 0, found, longest=1.5)])
    assert (curve.seconds.tolist(), curve.value.tolist()) == ([4.0], [1.0])


def test_a_question_without_a_path_so_far_is_infinitely_long():
    curve = cost_over_time([a for a in ANSWERS if a.asked.run == 0] + [attempt(2, 0, [])])
    assert curve.seconds.tolist() == [1.0, 2.0, 4.0]
    assert np.array_equal(curve.value, [math.inf, 3.0, 3.0])
    assert len(cost_over_time([attempt(0, 0, [])]).seconds) == 0


def test_a_question_without_any_path_has_no_cost():
    without = [attempt(k, 0, [], shortest=math.inf) for k in (2, 3)]
    curve = cost_over_time([attempt(0, 0, [(1.0, 20.0)]), *without])
    assert (curve.seconds.tolist(), curve.value.tolist()) == ([1.0], [2.0])
