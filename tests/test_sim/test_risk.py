"""Risk over a floor and exposure in zones, compared with sums over the same run."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from small_floors import GANTRY, on_floor

import floorplan
import sim

plots = pytest.importorskip("sim.views.plots")

TRIAL = on_floor(
    """\
boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
stations: {west: [2, 5], east: [18, 6]}
safe_zone: {at: [2, 5]}
zones:
  middle: {x: [8, 12], y: [2, 9], max_speed: 0.8}
  corner: {x: [0, 1], y: [11, 12], max_speed: 0.5}
"""
    + GANTRY,
    """\
rules: {gantry_law: {fixed: 3.0}, machine: none, person: none}
duration: 50
people: [{name: eve}, {name: max, at: [17, 8]}]
expect: {zones.corner.entries: 0, zones.middle.entries: ">= 2"}
""",
)


def test_exposure_in_zones_is_the_time_in_them(run):
    assert run.unmet == []
    area = run.floorplan.zones["middle"].area
    times = np.arange(0.0, 50.0, 0.005) + 0.0025
    occupied = close = entries = 0.0
    for name in ("eve", "max"):
        inside = shapely.contains_xy(area, *run.motions[name].position(times).T)
        near = run.distance(name, "gantry", times) < 3.0
        occupied += 0.005 * inside.sum()
        close += 0.005 * (inside & near).sum()
        entries += (inside[1:] & ~inside[:-1]).sum()
    exposure = run.summary["zones"]["middle"]
    assert exposure["time_occupied"] == pytest.approx(occupied, abs=0.1) and occupied > 5
    assert exposure["time_too_close"] == pytest.approx(close, abs=0.1) and close > 1
    assert exposure["entries"] == entries
    assert run.summary["zones"]["corner"] == {
        "time_occupied": 0.0,
        "time_too_close": 0.0,
        "entries": 0,
    }


def test_an_empty_risk_map_explains_why(run):
    away = "{floorplan: ariac2023, duration: 5, people: [{name: a, at: [-19, 0]}]}"
    far = sim.run(sim.Trial.parse(away))
    for of in ("time", "severity"):
        assert "Nobody was nearer than required" in plots.risk_map(far, of=of).get_supxlabel()
        assert plots.risk_map(run, of=of).get_supxlabel() == ""
    assert plots.risk_map(far).get_supxlabel() == ""


def test_risk_maps_show_the_least_margin_and_the_time_without_it(run):
    image = plots.risk_map(run).axes[0].images[0].get_array()
    apart = [run.summary["people"][name]["minimum_separation"] for name in ("eve", "max")]
    least = min(one["distance"] - one["required"] for one in apart)
    assert image.min() == pytest.approx(least, abs=0.02) and least < 0 < image.max()
    x, y = run.motions["eve"].position(apart[0]["time"])
    margin = apart[0]["distance"] - apart[0]["required"]
    assert image[int(y / 0.1), int(x / 0.1)] == pytest.approx(margin, abs=0.02)
    assert np.ma.is_masked(image[-1, 0])
    seconds = plots.risk_map([run, run], of="time").axes[0].images[0].get_array()
    total = sum(end - begin for spans in run.violations.values() for begin, end in spans)
    cells = sum(np.hypot(i, j) * 0.1 < 0.3 + 1e-9 for i in range(-3, 4) for j in range(-3, 4))
    assert seconds.sum() == pytest.approx(2 * total * cells, rel=0.02)
    with pytest.raises(ValueError, match="margin, time or severity"):
        plots.risk_map(run, of="both")
    alone = sim.run(sim.Trial.parse("{floorplan: warehouse, duration: 1, people: [{name: a}]}"))
    alone = replace(alone, scene=replace(alone.scene, machines=()))
    with pytest.raises(ValueError, match="needs a person and a machine"):
        plots.risk_map(alone)


def test_the_minimum_margin_includes_a_violation_of_zero_duration():
    """A person beside an AGV that starts is put home at the same time."""
    trial = sim.Trial.parse(
        "{floorplan: ariac2023, duration: 3, rules: {based_on: paper, agv_law: {fixed: 3.0}},"
        " people: [{name: eve, at: [-4.0, 3.5], personality: external}],"
        " agvs: {agv1: [{time: 1, to: assembly_front}]}}"
    )
    run = sim.run(trial)
    margins = [e["distance"] - e["required"] for e in run.events if e["kind"] == "violation"]
    assert min(margins) < -0.1
    image = plots.risk_map(run).axes[0].images[0].get_array()
    assert image.min() == pytest.approx(min(margins), abs=0.001)


def test_margins_are_where_people_were_before_a_teleport():
    trial = "{floorplan: ariac2023, duration: 60, rules: paper, people: [{name: eve, count: 4}]}"
    run = sim.run(sim.Trial.parse(trial))
    assert sum(len(spans) for spans in run.violations.values()) > 4
    image = plots.risk_map(run).axes[0].images[0].get_array()
    west, south, *_ = run.floorplan.boundary.bounds
    row, column = np.nonzero(image.filled(np.inf) < 0.5)
    places = np.column_stack([west + 0.1 * (column + 0.5), south + 0.1 * (row + 0.5)])
    nearest = np.hypot(*(places - run.motions["gantry"].state(0.0).at).T)
    assert len(places) and nearest.max() < 3.5 + 0.5 + 0.5


def test_zones_and_doors_are_drawn(run):
    plan = run.floorplan
    door = floorplan.Door(name="gate", ends=((5.0, 0.0), (5.0, 2.0)), is_open=False)
    without, with_both = (
        (len(axes.lines), len(axes.patches))
        for one in (replace(plan, zones=()), replace(plan, doors=[door]))
        for axes in plots.floorplan(one).axes[:1]
    )
    assert with_both == (without[0] + 1, without[1] + 2)


def test_a_floor_without_zones_has_no_such_figures():
    run = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 1}"))
    assert "zones" not in run.summary
