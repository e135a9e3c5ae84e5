"""Trial files of the ARIAC competition: their content, and the notices about mistakes."""

from pathlib import Path

import pytest

import floorplan
import sim

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "kitting.ariac.yaml"
TEXT = EXAMPLE.read_text()


def problems(text):
    with pytest.raises(sim.TrialError) as caught:
        sim.Trial.parse(text, file="t.yaml")
    return "\n".join(str(problem) for problem in caught.value.problems)


def notices(text):
    return "\n".join(str(notice) for notice in sim.Trial.parse(text, file="t.yaml").notices)


def test_all_keys_of_a_file_are_read():
    trial = sim.Trial.parse(TEXT, file="lunch.yaml")
    assert (trial.name, trial.duration, trial.until_submitted) == ("lunch", 400.0, True)
    assert (trial.floorplan, trial.rules) == (
        floorplan.load("ariac2023"),
        sim.RULE_SETS["ariac2023"],
    )
    assert (trial.gantry.controller, trial.notices) == ("pausing", ())
    work = trial.workload
    ((slot, item),) = work.bins["bin3"].items()
    assert (slot, str(item.part), item.flipped) == (9, "orange regulator", True)
    assert work.trays == {3: 2, 6: 5}
    (broken,) = work.malfunctions
    assert (broken.start, broken.seconds) == (sim.Start(None, order_submitted="KIT-A"), 10.0)
    kit, _, assembly = work.orders
    assert kit.kind == "kitting"
    assert (kit.task.agv, kit.task.tray, kit.task.destination) == ("agv4", 2, "warehouse")
    parts = {quadrant: str(part) for quadrant, part in kit.task.products.items()}
    assert parts == {1: "red battery", 4: "blue sensor"}
    assert (assembly.id, assembly.kind, assembly.priority) == ("ASSEMBLY", "assembly", True)
    assert assembly.announcement == sim.Start(None, order_submitted="KIT-B")
    assert [str(part) for part in assembly.task.products] == ["green pump", "orange regulator"]
    (operator,) = trial.people
    assert operator.start.part_placed == {"part": "red battery", "agv": "agv4"}


def test_mistakes_in_angles_are_reported_with_their_line():
    said = notices(TEXT.replace("rotation: pi/2", "rotation: p1/2").replace("-pi/2]", "-pl/2]", 1))
    assert "line 15, parts.bins.bin1[0].rotation: 'p1/2' is not an angle; 0 is used" in said
    assert "products[0].assembled_pose.rpy[2]: '-pl/2' is not an angle" in said


def test_parts_that_are_not_simulated_are_reported_once():
    more = """\
  - sensor_blackout: {duration: 5, sensors_to_disable: [proximity], time_condition: 3}
  - sensor_blackout: {duration: 5, sensors_to_disable: [break_beam], time_condition: 9}
  - sensor_blackout:
      duration: 5
      sensors_to_disable: [camera]
      part_place_condition: {type: battery, color: red, agv: 2}
  - faulty_part: {order_id: KIT-A, quadrant1: true}
  - dropped_part: {robot: floor_robot, type: pump, color: red, drop_after: 1, delay: 2}
  - robot_malfunction: {duration: 5, robots_to_disable: [floor_robot], time_condition: 3}

orders:
"""
    text = TEXT.replace("orders:\n", more, 1)
    said = notices(text).splitlines()
    words = ["do not detect people", "red battery put on agv2", "floor robot"]
    assert [word in line for word, line in zip(words, said, strict=True)] == [True] * 3
    assert "(2 places)" in said[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("type: pump", "type: motor"), "expected 'battery', 'pump', 'regulator' or 'sensor'"),
        (("slots: [2, 5]", "slots: [2, 10]"), "bin1[0].slots[1]: expected at most 9, found 10"),
        (("slots: [2, 5]", "slots: [2, 2]"), "bin1[0].slots[1]: there is a part in slot 2 already"),
        (("bin1:", "bin9:"), "no bin is called 'bin9'; did you mean"),
        (("slots: [3, 6]", "slots: [3, 7]"), "kitting_trays.slots[1]: expected at most 6"),
        (("slots: [3, 6]", "slots: [3]"), "2 tray_ids and 1 slots don't go together"),
        (("slots: [3, 6]", "slots: [3, 3]"), "there is a tray in slot 3 already"),
        (("agv_number: 4", "agv_number: 7"), "there is no AGV 7 (there are: 1, 2, 3, 4)"),
        (("agv_number: [1]", "agv_number: [3]"), "agv3 does not serve as1 (but as3, as4)"),
        (("destination: warehouse", "destination: as3x"), "agv4 can't go to 'as3x' (it goes to:"),
        (("station: as1", "station: as9"), "no AGV serves a station 'as9'; did you mean"),
        (("quadrant: 4", "quadrant: 5"), "products[1].quadrant: expected at most 4, found 5"),
        (("quadrant: 4", "quadrant: 1"), "the order has a part for quadrant 1 already"),
        (("id: KIT-B", "id: KIT-A"), "there is an order KIT-A already"),
        (("order_id: KIT-B", "order_id: KIT-C"), "no order is called 'KIT-C'; did you mean"),
        (("order_id: KIT-B", "order_id: ASSEMBLY"), "is never announced: ASSEMBLY after ASSEMBLY"),
        (("behavior: helpful", "behavior: grumpy"), "expected 'indifferent', 'antagonistic' or"),
        (("{time_condition: 20}", "{}"), "give one of time_condition, part_place_condition"),
        (("{time_condition: 20}", "{time_condition: -1}"), "expected at least 0, found -1"),
        (("time_limit: 400", "time_limit: 0"), "time_limit: expected -1 (no limit) or seconds"),
        (("type: assembly", "type: kitting"), "an order of the type kitting has a kitting_task"),
        (("duration: 10.0", "duration: 0"), "robot_malfunction.duration: expected more than 0"),
        (("bins:", "bin:"), "parts.bin: unknown key"),
        (("    bin1:", "\tbin1:"), "line 11: is not YAML: a tab"),
        (("orders:", "order:"), "orders: is missing"),
    ],
)
def test_invalid_values_are_reported_with_their_place(change, message):
    assert TEXT.replace(*change) != TEXT
    said = problems(TEXT.replace(change[0], change[1], 1))
    assert message in said
    assert said.startswith("line ") or "orders" in said


def test_all_problems_are_reported_together():
    """Some problems only appear after the rest of the file is parsed."""
    text = TEXT.replace("type: pump", "type: motor", 1).replace("agv_number: 4", "agv_number: 7")
    text = text.replace("slots: [1, 4, 7]", "slots: [1, 4, 4]").replace("id: KIT-B", "id: KIT-A", 1)
    text = text.replace("station: as1", "station: as9").replace("duration: 10.0", "duration: -1")
    said = problems(text)
    assert len(said.splitlines()) == 7
    for word in ("motor", "AGV 7", "slot 4", "order KIT-A already", "'as9'", "duration", "'KIT-B'"):
        assert word in said


def test_anchors_are_read():
    text = TEXT.replace("{type: pump, color: green, quadrant: 2}", "{<<: *pump, quadrant: 2}")
    text = text.replace(
        "- {type: battery, color: red, quadrant: 1}",
        "- &pump {type: pump, color: green, quadrant: 1}",
    )
    assert str(sim.Trial.parse(text).workload.orders[1].task.products[2]) == "green pump"


def test_orders_on_an_unsuitable_floor_are_reported(tmp_path):
    (tmp_path / "work.yaml").write_text(TEXT)
    text = "floorplan: warehouse\nariac: work.yaml\n"
    with pytest.raises(sim.TrialError) as caught:
        sim.Trial.parse(text, folder=tmp_path)
    message = str(caught.value)
    assert "the floorplan warehouse has no gantry to work on orders" in message
    assert "no AGV" in message
    with pytest.raises(sim.TrialError, match=r"line 2, ariac: no such file: 'play.yaml'"):
        sim.Trial.parse("floorplan: ariac2023\nariac: play.yaml\n", folder=tmp_path)


def test_unreachable_places_of_the_gantry_are_reported(tmp_path):
    floor = (Path(floorplan.__file__).parent / "data" / "ariac2023.yaml").read_text()
    assert "range: [-7.0, 7.0]" in floor
    (tmp_path / "narrow.yaml").write_text(floor.replace("range: [-7.0, 7.0]", "range: [-4, 5.8]"))
    (tmp_path / "work.yaml").write_text(TEXT)
    with pytest.raises(sim.TrialError) as caught:
        sim.Trial.parse("floorplan: narrow.yaml\nariac: work.yaml\n", folder=tmp_path)
    assert "the gantry can't get to 'kit_tray_table1': y = -5.84 is outside" in str(caught.value)
    assert {problem.message.split("'")[2] for problem in caught.value.problems} == {
        "kit_tray_table1",
        "disposal_bin2",
        "kit_tray_table2",
    }


def test_a_custom_trial_states_its_end(tmp_path):
    (tmp_path / "work.yaml").write_text(TEXT)

    def trial(more):
        text = f"floorplan: ariac2023\nariac: work.yaml\n{more}\n"
        return sim.Trial.parse(text, folder=tmp_path)

    assert (trial("").duration, trial("").until_submitted) == (400.0, True)
    assert [person.name for person in trial("").people] == ["operator"]
    fixed = trial("duration: 50\npeople: []")
    assert (fixed.duration, fixed.until_submitted, fixed.people) == (50.0, False, ())
