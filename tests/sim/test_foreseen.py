"""People wait for vehicles that drive, or will, or go round them, before they set out."""

import pytest

import sim
from navigation import Cylinder, Shapes, agv_box, minimum_separation
from sim.people import foreseen, walker

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
        machine=(agv_box(plan.lane("agv1")),),
    )
    apart = minimum_separation(run.motions["ada"], run.motions["agv1"], 0.0, 40.0, shapes=shapes)
    assert apart[1] >= foreseen.GAP - 1e-6
    # Those who set out at once stop on the way, and are there later.
    monkeypatch.setattr(walker, "among_vehicles", lambda *given: None)
    assert arrival(crossing(tmp_path, start, drives, other)) >= arrival(run) - 1e-9
