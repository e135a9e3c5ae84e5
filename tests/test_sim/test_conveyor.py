"""Parts on the conveyor: picked at their current position, or missed."""

import math
from dataclasses import replace

import pytest

import sim

TRIAL = """\
time_limit: 300
kitting_trays: {tray_ids: [3], slots: [5]}
parts:
  conveyor_belt:
    active: true
    spawn_rate: 15.0
    order: sequential
    parts_to_spawn:
      - {type: battery, color: red, number: 3, offset: 0.5}
      - {type: sensor, color: green, number: 2, offset: -0.25, flipped: true, rotation: pi}
orders:
  - id: A
    type: kitting
    announcement: {time_condition: 0}
    kitting_task:
      agv_number: 2
      tray_id: 3
      destination: warehouse
      products:
        - {type: battery, color: red, quadrant: 1}
        - {type: sensor, color: green, quadrant: 3}
"""


def run(text=TRIAL, controller="oblivious", **changes):
    trial = sim.Trial.parse(text)
    assert trial.notices == ()
    gantry = replace(trial.gantry, controller=controller)
    return sim.run(replace(trial, gantry=gantry, **changes))


def of(run, kind):
    return [event for event in run.events if event["kind"] == f"part_{kind}"]


@pytest.mark.parametrize("controller", ["oblivious", "pausing", "avoiding"])
def test_the_gantry_picks_a_part_below_it(controller):
    done = run(controller=controller)
    came = of(done, "came")
    assert [event["t"] for event in came] == [15.0, 30.0, 45.0, 60.0, 75.0][: len(came)]
    assert came[0]["at"] == pytest.approx((-0.6 + 0.07, 4.0), abs=1e-9)
    taken = of(done, "taken")
    assert [event["part"] for event in taken] == ["red battery", "green sensor"]
    for event in taken:
        (start,) = (one for one in came if one["number"] == event["number"])
        y = start["at"][1] - 0.2 * (event["t"] - start["t"])
        assert event["at"] == pytest.approx((start["at"][0], y), abs=1e-6)
        assert math.dist(done.motions["gantry"].position(event["t"])[:2], event["at"]) < 1e-3
        assert done.motions["gantry"].velocity(event["t"])[:2] == pytest.approx((0, 0), abs=1e-6)
    order = done.summary["orders"]["A"]
    assert (order["score"], order["missing"]) == (order["best"], [])


def test_parts_left_on_the_belt_fall_off_and_the_next_replaces_them():
    # The first parts pass before the tray arrives. Each part takes 42.55 s along the belt.
    soon = TRIAL.replace("spawn_rate: 15.0", "spawn_rate: 2.0")
    missed = run(soon, until_submitted=False, duration=60.0)
    fallen = of(missed, "missed")
    assert missed.summary["parts_missed"] == len(fallen) == 5
    assert [event["t"] for event in fallen] == pytest.approx([2 * k + 42.55 for k in range(1, 6)])
    assert missed.summary["orders"]["A"]["missing"] == ["red battery", "green sensor"]
    later = run(TRIAL.replace("spawn_rate: 15.0", "spawn_rate: 6.0"))
    assert of(later, "taken")[0]["number"] > 0
    assert "red battery" not in later.summary["orders"]["A"]["missing"]


def test_a_delayed_gantry_misses_the_part_and_picks_the_next():
    malfunction = """\
challenges:
  - robot_malfunction: {duration: 6.0, robots_to_disable: [ceiling_robot], time_condition: 46.0}
orders:
"""
    at = [of(run(text), "taken")[0] for text in (TRIAL, TRIAL.replace("orders:\n", malfunction))]
    assert [event["number"] for event in at] == [0, 1]
    assert 46 < at[0]["t"] < 49 and at[1]["t"] > 52


def test_the_order_in_which_parts_come_may_be_drawn_from_the_seed():
    text = TRIAL.replace("sequential", "random").replace("number: 3", "number: 20")

    def drawn(seed):
        trial = sim.Trial.parse(text)
        return [str(item.part) for _, item, _ in trial.workload.conveyor.coming(seed)]

    assert drawn(1) == drawn(1) != drawn(2)
    assert sorted(drawn(1)) == sorted(drawn(2))


def test_a_floor_without_the_conveyor_is_rejected(tmp_path):
    (tmp_path / "belt.ariac.yaml").write_text(TRIAL)
    text = "floorplan: {base: ariac2023, remove: [conveyor]}\nariac: belt.ariac.yaml\n"
    with pytest.raises(sim.TrialError, match="has no conveyor to work on orders with"):
        sim.Trial.parse(text, folder=tmp_path)
