"""Parts that the gripper drops, and parts that the quality check finds faulty."""

from dataclasses import replace

import pytest
from run_events import events
from sample_files import files

import sim

JOBS = """
floorplan: ariac2023
duration: 120
people: []
gantry:
  controller: {controller}
  jobs: [{{pick: bin2, place: agv1, part: pump}}, {{pick: bin3, place: agv1, part: pump}}]
  drops: [{{part: pump, after: {after}, delay: {delay}}}]
expect: {{parts_dropped: {dropped}}}
"""


@pytest.mark.parametrize("controller", ["oblivious", "pausing", "avoiding"])
@pytest.mark.parametrize("delay", [0.0, 1.5, 3.0])
def test_a_job_with_a_dropped_part_is_repeated(controller, delay):
    text = JOBS.format(controller=controller, after=1, delay=delay, dropped=1)
    trial = sim.Trial.parse(text)
    assert sim.Trial.parse(trial.to_yaml()) == trial
    run = sim.run(trial)
    (dropped,) = events(run, "part_dropped")
    first, second = events(run, "job_done")
    assert run.unmet == [] and run.summary["jobs_done"] == 2
    assert first["t"] < dropped["t"] < second["t"] and dropped["part"] == "pump"
    # The gantry fetched another part, at least from the place of the drop and with all handling.
    sure = sim.run(replace(trial, gantry=replace(trial.gantry, drops=()), expect={}))
    late = second["t"] - events(sure, "job_done")[1]["t"]
    assert late >= 2.0 + delay - 1e-6
    assert "parts_dropped" not in sure.summary


def test_a_part_that_is_placed_in_time_does_not_drop(tmp_path):
    run = sim.run(sim.Trial.parse(JOBS.format(controller="pausing", after=0, delay=90, dropped=0)))
    assert not events(run, "part_dropped") and run.unmet == []


def test_a_controller_is_interrupted_by_a_drop(tmp_path):
    (tmp_path / "alert.py").write_text(
        "import simpy\n"
        "def alert(gantry):\n"
        "    gantry.interrupt_on('part_dropped')\n"
        "    while (task := (yield gantry.next_task())) is not None:\n"
        "        try:\n"
        "            yield gantry.do(task)\n"
        "        except simpy.Interrupt as why:\n"
        "            assert why.cause == 'part_dropped'\n"
    )
    text = JOBS.format(controller="alert:alert", after=0, delay=2.5, dropped=1)
    alert = sim.run(sim.Trial.parse(text, folder=tmp_path))
    plain = sim.run(sim.Trial.parse(text.replace("alert:alert", "oblivious")))
    assert alert.unmet == [] and alert.summary["jobs_done"] == 2
    # The gantry turns back at once, and does not drive to the AGV first.
    ends = [events(run, "job_done")[0]["t"] for run in (alert, plain)]
    assert ends[0] < ends[1]


KIT = """
time_limit: -1
kitting_trays: {tray_ids: [3], slots: [1]}
parts:
  bins:
    bin2: [{type: pump, color: red, slots: %s, faulty: %s}]
    bin6: [{type: sensor, color: green, slots: [1, 2]}]
challenges: %s
orders:
  - id: KIT
    type: %s
    announcement: {time_condition: 0}
    priority: false
    %s
"""
KITTING = """kitting_task:
      agv_number: 1
      tray_id: 3
      destination: warehouse
      products: [{type: pump, color: red, quadrant: 1}, {type: sensor, color: green, quadrant: 2}]
"""
COMBINED = """combined_task:
      station: as1
      products: [{type: pump, color: red}, {type: sensor, color: green}]
"""
DROP = "[{dropped_part: {robot: ceiling_robot, type: pump, color: red, drop_after: %d, delay: %s}}]"
FAULTY = "[{faulty_part: {order_id: KIT, quadrant1: true}}]"


def made(slots, challenges="[]", faulty="[]", kind="kitting"):
    task = {"kitting": KITTING, "combined": COMBINED}[kind]
    trial = sim.Trial.parse(KIT % (slots, faulty, challenges, kind, task), file="made.yaml")
    run = sim.run(replace(trial, people=(), gantry=sim.GantryEntry("oblivious")))
    return run, run.summary["orders"]["KIT"]


@pytest.mark.parametrize("kind", ["kitting", "combined"])
@pytest.mark.parametrize("delay", [0.5, 3.0])
def test_an_order_gets_another_part_for_a_dropped_part(kind, delay):
    run, order = made([1, 2], DROP % (0, delay), kind=kind)
    assert run.summary["parts_dropped"] == 1
    assert order["score"] == order["best"] and order["missing"] == []
    run, order = made([1], DROP % (0, delay), kind=kind)
    assert run.summary["parts_dropped"] == 1 and order["submitted"] is not None
    assert order["missing"] == ["red pump"] and order["score"] < order["best"]
    done = [e.get("part") for e in events(run, "job_done")]
    assert "red pump" not in done and "green sensor" in done


@pytest.mark.parametrize(("challenges", "faulty"), [(FAULTY, "[]"), ("[]", "[1]")])
def test_a_faulty_part_of_a_kit_is_thrown_away_for_another(challenges, faulty):
    good, _ = made([1, 2])
    run, order = made([1, 2], challenges, faulty)
    (fault,) = events(run, "part_faulty")
    assert (fault["part"], fault["agv"], fault["quadrant"]) == ("red pump", "agv1", 1)
    assert run.summary["parts_faulty"] == 1 and order["score"] == order["best"]
    # Picking, disposing, picking and placing take 8 s more, plus the drives.
    assert order["submitted"] > good.summary["orders"]["KIT"]["submitted"] + 8.0
    run, order = made([1], challenges, faulty)
    assert order["missing"] == ["red pump"] and order["score"] == 3 + 3  # tray and sensor
    assert "red pump" not in [e.get("part") for e in events(run, "job_done")]
    assert "parts_faulty" not in good.summary


SHIFT = ({"FIRST-KIT": {1}}, ("red regulator", 1, 1.5), "bin2", {4}, "blue sensor")
SAMPLE = (
    {"MMB30H56": {1, 2}, "MMB30H00": {1}},
    *(("green battery", 1, 2.0), "bin6", {3, 7}, "blue battery"),
)


@pytest.mark.parametrize(
    "path",
    files("shift.ariac.yaml", real="ariac2023/trials/sample.yaml"),
    ids=lambda path: path.stem,
)
def test_a_competition_file_has_faulty_and_dropped_parts(path):
    trial = sim.Trial.load(path)
    work = trial.workload
    faulty, drop, name, slots, part = SAMPLE if path.stem == "sample" else SHIFT
    assert work.faulty == faulty
    assert [(drop.part, drop.after, drop.delay) for drop in work.drops] == [drop]
    bad = {slot: item for slot, item in work.bins[name].items() if item.faulty}
    assert bad.keys() == slots
    assert {(str(item.part), item.flipped) for item in bad.values()} == {(part, False)}
    run = sim.run(replace(trial, people=(), gantry=sim.GantryEntry("oblivious")))
    assert run.summary["parts_faulty"] == len(events(run, "part_faulty")) > 0


def test_orders_that_no_gantry_can_work_on_have_no_figures():
    trial = sim.Trial.parse(KIT % ([1], "[]", FAULTY, "kitting", KITTING), file="made.yaml")
    floor = replace(trial.floorplan, gantry=None)
    left = replace(trial, floorplan=floor, people=(), gantry=sim.GantryEntry(), duration=1.0)
    assert not {"orders", "score", "parts_faulty"} & {*sim.run(left).summary}
