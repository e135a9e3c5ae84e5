import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest
import typer

import floorplan
from navigation.benchmark import benchmark, summary
from sim.commands.plan import benchmark as command
from sim.views.benchmark_page import write_page

ROWS = ["........", "..@@@...", "..@.....", "....@@..", "........", "........"]
MAP = "\n".join(["type octile", "height 6", "width 8", "map", *ROWS])
SCENARIO = (
    "version 1\n0\thall.map\t8\t6\t0\t0\t5\t2\t6.24264069\n0\thall.map\t8\t6\t7\t5\t1\t1\t7.65\n"
)


@pytest.fixture
def hall(tmp_path):
    (tmp_path / "hall.map").write_text(MAP)
    (tmp_path / "hall.map.scen").write_text(SCENARIO)
    return tmp_path


def test_a_scenario_is_measured_and_all_files_are_written(hall, floorwalker):
    done = floorwalker(
        *("benchmark", "--questions", hall / "hall.map.scen", "--runs", 2, "--out", hall / "out"),
        *("--planner", "Roadmap", "--planner", "BITstar: {samples_per_batch: 50}"),
        *("--iterations", 300, "--longest", 1.5),
    )
    assert done.returncode == 0, done.stderr
    assert "BITstar:" in done.stdout
    assert "÷ listed" in done.stdout
    assert done.stderr.count("\n") == 1
    with (hall / "out" / "benchmark.csv").open() as file:
        answers = list(csv.DictReader(file))
    assert len(answers) == 2 * 2 * 2
    assert {answer["listed"] for answer in answers} == {"6.24264069", "7.65"}
    with (hall / "out" / "summary.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["planner"] for row in rows] == ["Roadmap", "BITstar: {samples_per_batch: 50}"]
    assert rows[0]["solved"] == "1.0"
    assert (hall / "out" / "hall.log").read_text().startswith("OMPL version")
    assert "<h2>hall</h2>" in (hall / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"planner": ["Dijkstra"]}, "no planner is called 'Dijkstra'"),
        ({"planner": ["RRTConnect: {rang: 1}"]}, "no parameter 'rang'; did you mean 'range'?"),
        ({"seconds": 0.0}, "--seconds: must be above 0 and finite, found 0"),
        ({"seconds": math.nan}, "--seconds: must be above 0 and finite, found nan"),
        ({"radius": math.nan}, "--radius: must be above 0 and finite, found nan"),
        ({"longest": 0.5}, "--longest: must be above 1 and finite, found 0.5"),
        ({"cell": 1.0}, "--cell 1 needs a MovingAI map"),
        ({"questions": Path("none.csv")}, "--questions none.csv needs --floorplan"),
        ({"questions": Path("none.scen")}, "none.scen: there is no such file"),
    ],
)
def test_invalid_options_are_named(options, why):
    with pytest.raises((ValueError, typer.BadParameter)) as caught:
        command(**options)
    hint = getattr(caught.value, "param_hint", None)
    assert why in (f"{hint}: {caught.value}" if hint else str(caught.value))


def test_invalid_options_cause_one_message(floorwalker):
    for words, code in ((["--planner", "Dijkstra"], 1), (["--runs", 0], 2)):
        done = floorwalker("benchmark", *words)
        assert done.returncode == code
        assert words[0].strip("-") in done.stderr
        assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_an_unsolved_query_has_no_length(hall, floorwalker):
    terms = ("--questions", hall / "hall.map.scen", "--planner", "PRM", "--iterations", 1)
    done = floorwalker("benchmark", *terms)
    assert done.returncode == 0, done.stderr
    assert "nan" not in done.stdout
    assert "–" in done.stdout


def test_other_planners_are_listed_only_after_an_unknown_planner(hall, floorwalker):
    for planner, named in (("Dijkstra", True), ("RRT: {rang: 1}", False), ("mine:Own", False)):
        done = floorwalker("benchmark", "--floorplan", hall / "hall.map", "--planner", planner)
        assert done.returncode == 1
        assert ("(peers: JuPedSim" in done.stderr) == named


def test_the_report_shows_every_planner_and_can_be_read(tmp_path, open_address):
    """Include a planner without paths, light and dark colours, and wide and narrow windows."""
    plan = floorplan.load("machine_shop")
    planners = ["Roadmap", "RRTConnect", "RRTstar: {iterations: 2}"]
    attempts = benchmark([plan], planners, queries=7, seed=2)
    assert {a.solved for a in attempts} == {True, False}
    assert all(math.isnan(a.length) for a in attempts if not a.solved)
    page = tmp_path / "report.html"
    nothing = [a for a in attempts if not a.solved]
    write_page(nothing, [plan], page, terms={}, on_the_clock=False)
    assert "0 %<small>0 …" in page.read_text()
    write_page(attempts, [plan], page, terms={"seed": "2"}, on_the_clock=True)
    viewer = open_address(page.as_uri())
    shown = viewer.page.inner_text("body")
    assert all(name in shown for name in planners)
    assert "depends on this machine" in shown
    assert viewer.page.locator("polyline.path").count() == 2
    viewer.page.get_by_role("checkbox").first.uncheck()
    assert viewer.page.locator("polyline.path:visible").count() == 1
    viewer.page.set_viewport_size({"width": 420, "height": 900})
    assert viewer.page.evaluate("document.documentElement.scrollWidth") <= 420


def test_a_report_is_written_without_known_shortest_paths(tmp_path, floorwalker):
    """The map has too many corners, for either order of a straight query and one around corners."""
    pegs = ["".join("@" if x % 3 == y % 3 == 1 else "." for x in range(55)) for y in range(55)]
    text = "\n".join(["type octile", "height 55", "width 55", "map", *pegs])
    (tmp_path / "pegs.map").write_text(text)
    straight, around = (
        "0\tpegs.map\t55\t55\t0\t0\t5\t0\t5\n",
        "0\tpegs.map\t55\t55\t0\t0\t7\t5\t10\n",
    )
    for number, lines in enumerate((straight + around, around + straight)):
        (tmp_path / "pegs.map.scen").write_text("version 1\n" + lines)
        out = tmp_path / f"out{number}"
        done = floorwalker(
            *("benchmark", "--questions", tmp_path / "pegs.map.scen", "--radius", 0.3),
            *("--planner", "Roadmap", "--longest", 2, "--out", out),
        )
        assert done.returncode == 0, done.stderr
        assert "pegs: the shortest length of 1 of 2 queries is unknown" in done.stderr
        assert "--longest" in done.stderr
        assert "1.0000" not in done.stdout
        with (out / "summary.csv").open() as file:
            (row,) = csv.DictReader(file)
        assert row["solved"] == "1.0"
        assert row["ratio"] == row["ratio_most"] == "nan"
        page = (out / "report.html").read_text()
        assert page.count("shortest lengths are not known") == 2


@pytest.fixture(scope="module")
def few_solved():
    """A floor and attempts of which few have a path."""
    plan = floorplan.load("machine_shop")
    return plan, benchmark([plan], ["RRTstar: {iterations: 10}"], queries=7, seed=2)


@pytest.mark.parametrize("times", [1.0, 0.0])
def test_a_report_is_written_if_few_queries_have_a_path(few_solved, tmp_path, times):
    """No median of costs is finite. Also cover a clock that is too coarse for any time."""
    plan, measured = few_solved
    attempts = [
        replace(
            attempt,
            cpu_seconds=times * attempt.cpu_seconds,
            planning_seconds=times * attempt.planning_seconds,
            progress=tuple(
                replace(one, cpu_seconds=times * one.cpu_seconds) for one in attempt.progress
            ),
        )
        for attempt in measured
    ]
    assert 0 < summary(attempts)[0].solved.value < 0.5
    page = tmp_path / "report.html"
    write_page(attempts, [plan], page, terms={}, on_the_clock=False)
    assert "fewer than half of the queries have a path" in page.read_text()
    assert ("no time could be measured" in page.read_text()) == (times == 0.0)
