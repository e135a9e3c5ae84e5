"""People wait for vehicles that drive, or will, or go round them, alone and among others."""

import pytest

import sim
from navigation import Box, Cylinder, Shapes, minimum_separation
from sim.people import walker
from sim.people.steering import vehicle_conflicts as foreseen

TRIAL = """
floorplan: ariac2023
duration: 40.0
rules: observe
people:
- {name: ada, personality: cross.asl, at: [-11.3, 6.0], start: {time: %s}}
%s
agvs: {agv1: [{time: %s, to: 12.0}]}
"""
OTHER = "- {name: bob, personality: rest.asl, at: [-14.0, 9.0], start: {time: 0.0}}"


def crossing(folder, start, drives=0.0, other=""):
    (folder / "cross.asl").write_text("+human_start <- move(-11.3, 3.5, 0).\n")
    (folder / "rest.asl").write_text("+human_start <- true.\n")
    return sim.run(sim.Trial.parse(TRIAL % (start, other, drives), folder=folder))


def arrival(run):
    (arrived,) = [event["t"] for event in run.events if event["kind"] == "arrived"]
    return arrived


@pytest.mark.parametrize("other", ["", OTHER])
@pytest.mark.parametrize(("start", "drives"), [(3.0, 0.0), (4.0, 0.0), (1.5, 2.0), (4.0, 4.2)])
def test_nobody_sets_out_into_a_lane_that_an_agv_is_about_to_cross(
    start, drives, other, tmp_path, monkeypatch
):
    run = crossing(tmp_path, start, drives, other)
    assert "path_blocked" not in {event["kind"] for event in run.events}
    plan = run.trial.floorplan
    shapes = Shapes(
        person=Cylinder(radius=plan.human.radius, top=plan.human.height),
        machine=(Box.of_agv(plan.lane("agv1")),),
    )
    apart = minimum_separation(run.motions["ada"], run.motions["agv1"], 0.0, 40.0, shapes=shapes)
    assert apart[1] >= foreseen.GAP - 1e-6
    # Those who set out at once stop on the way, and are there later.
    monkeypatch.setattr(walker, "among_vehicles", lambda *given: None)
    assert arrival(crossing(tmp_path, start, drives, other)) >= arrival(run) - 1e-9


HEAD_ON = """
floorplan:
  boundary: [[0, -2], [26, -2], [26, 2], [0, 2]]
  stations: {west: [1.0, 0.0]}
duration: 30
rules: observe
people: [{name: ada, personality: west.asl, at: [%s, %s]}]
machines:
  bot: {kind: agv, origin: [6.0, 0.0], limits: [0, 18], size: [1.2, 0.7], height: 0.4,
        max_speed: 1.0, max_acceleration: 0.6, locations: {a: 0}, start: a, %s}
"""
MOVES = "moves: [{time: 0, to: 18.0}]"
LATER = "moves: [{time: 1.5, to: 18.0}]"
HELD = MOVES + "}\ncommands: [{time: 0.0, hold: bot}, {time: 3.0, release: bot}]\nobstacles: {"


@pytest.mark.parametrize("goes", [MOVES, LATER, HELD])
@pytest.mark.parametrize(
    "at", [(18.0, 0.0), (13.3, 0.1), (16.5, -0.4), (12.3, 0.57), (22.7, 0.56), (18.0, -0.2)]
)
def test_nobody_alone_walks_into_an_oncoming_vehicle(at, goes, tmp_path):
    """Whoever is alone goes round it, whether it is known to come or sets out as they walk."""
    (tmp_path / "west.asl").write_text("+human_start <- move(1, 0, 0).\n")
    run = sim.run(sim.Trial.parse(HEAD_ON % (*at, goes), folder=tmp_path))
    assert run.motions["bot"].state(30.0).at[0] > 23.9
    shapes = Shapes(person=Cylinder(radius=0.3, top=1.8), machine=(run.scene.machine("bot").box,))
    pair = (run.motions["ada"], run.motions["bot"])
    assert minimum_separation(*pair, 0.0, 30.0, shapes=shapes)[1] >= foreseen.GAP - 1e-6
    assert arrival(run) < 24.5
