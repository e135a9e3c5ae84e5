"""Blackouts: machines that do not see people for a while."""

from pathlib import Path

import pytest
from small_floors import LANE, on_floor

import sim

FLOOR = on_floor(
    "boundary: [[0, 0], [20, 0], [20, 6], [0, 6]]\nsafe_zone: {at: [1, 5]}\n"
    + LANE.replace("2.75", "1"),
    """\
rules: {agv_law: {fixed: 1.5}, person: none}
people: [{name: eve, personality: external, at: [12, 1.5]}]
agvs: {cart: {yield: true, moves: [{time: 1, to: east}]}}
duration: 40
""",
)


def kinds(run, *wanted):
    return [(round(e["t"], 3), e["kind"]) for e in run.events if e["kind"] in wanted]


def test_an_agv_continues_during_a_blackout_and_stops_after_it():
    seeing = sim.run(sim.Trial.parse(FLOOR))
    assert not kinds(seeing, "violation") and kinds(seeing, "agv_yielded")
    stands = seeing.motions["cart"].position(40.0)[0]
    blind = sim.run(
        sim.Trial.parse(FLOOR + "blackouts: [{machine: cart, start: {time: 20}, seconds: 3}]\n")
    )
    x = blind.motions["cart"].position([20.0, 23.0, 40.0])[:, 0]
    assert x[0] == pytest.approx(stands) and x[0] + 1.0 < x[1] < 12.0
    assert x[2] - x[1] <= 1.0 + 1e-6  # the AGV brakes as soon as it sees again, within v² / 2a
    assert len(kinds(blind, "violation")) == 1


def test_the_controller_of_a_gantry_sees_no_people_during_a_blackout():
    seen = []

    def watching(gantry):
        while True:
            people = yield gantry.look()
            seen.append((gantry.now, len(people)))
            yield gantry.wait(0.5)

    trial = sim.Trial(
        sim.Trial.load("ariac2023").floorplan,
        duration=10.0,
        people=(sim.PersonEntry("eve"),),
        gantry=sim.GantryEntry(watching),
        blackouts=(
            sim.Blackout("gantry", sim.Start(time=2.0), 3.0),
            sim.Blackout("gantry", sim.Start(time=4.0), 2.0),
        ),
    )
    run = sim.run(trial)
    assert kinds(run, "blackout_began", "blackout_ended") == [
        (2.0, "blackout_began"),
        (6.0, "blackout_ended"),
    ]
    assert {count for t, count in seen if 2.0 < t < 6.0} == {0}
    assert {count for t, count in seen if t < 2.0 or t > 6.0} == {1}


def test_sensor_blackouts_of_an_ariac_file_begin_when_their_conditions_are_met():
    text = Path(__file__).parents[2].joinpath("examples", "kitting.ariac.yaml").read_text()
    more = """\
  - sensor_blackout: {duration: 4, sensors_to_disable: [lidar, break_beam], time_condition: 3}
  - sensor_blackout:
      duration: 1.5
      sensors_to_disable: [camera]
      part_place_condition: {type: battery, color: red, agv: 4}
  - sensor_blackout:
      duration: 2
      sensors_to_disable: [logical_camera]
      submission_condition: {order_id: KIT-A}

orders:
"""
    run = sim.run(sim.Trial.parse(text.replace("orders:\n", more, 1)))
    (placed,) = [
        e["t"] for e in run.events if e["kind"] == "job_done" and e.get("part") == "red battery"
    ][:1]
    submitted = next(e["t"] for e in run.events if e["kind"] == "order_submitted")
    began, ended = ([t for t, _ in kinds(run, f"blackout_{what}")] for what in ("began", "ended"))
    assert began == pytest.approx([3.0, placed, submitted], abs=1e-3)
    assert ended == pytest.approx([7.0, placed + 1.5, submitted + 2.0], abs=1e-3)
