"""Kinds of events are classes, and all facts about a kind follow from its declaration."""

import math
from dataclasses import replace
from typing import Annotated

import pytest
from run_events import record

import sim

TRIAL = """
floorplan: ariac2023
duration: 20
people:
  - {name: nina, start: {event: tank_filled}}
  - {name: otto, start: {time: 5.0}}
expect:
  timeline: [{eventually: {kind: tank_filled, from: station2, litres: "> 30", by: otto}}]
"""


@pytest.fixture
def own_kind():
    class TankFilled(sim.EventKind):
        """A machine has filled a tank."""

        from_: Annotated[str, "place"]
        litres: float
        by: Annotated[str, "person"] | None = None
        remark: str | None = None

    return TankFilled


def test_a_custom_kind_is_recorded_awaited_expected_and_read_back(own_kind, tmp_path):
    def refuelling(gantry):
        yield gantry.wait(2.0)
        gantry.record(own_kind(from_="station2", litres=40, by="otto"))

    trial = sim.Trial.parse(TRIAL)
    trial = replace(trial, gantry=sim.GantryEntry(refuelling))
    run = record(trial, tmp_path / "run")
    filled = {"t": 2.0, "kind": "tank_filled", "from": "station2", "litres": 40, "by": "otto"}
    assert filled in run.events
    assert run.unmet == []
    started = {e["person"]: e["t"] for e in run.events if e["kind"] == "human_started"}
    assert started == {"nina": 2.0, "otto": 5.0}
    assert sim.load_run(tmp_path / "run").events == run.events


@pytest.mark.parametrize(
    ("event", "fault"),
    [
        ("{kind: tank_filled, litre: 3}", "litres"),
        ("{kind: tank_filled, by: nobody}", "no person"),
        ("{kind: tank_fill}", "tank_filled"),
    ],
)
def test_expectations_of_a_custom_kind_are_checked(own_kind, event, fault):
    text = TRIAL.split("expect:")[0] + f"expect: {{timeline: [{{never: {event}}}]}}"
    with pytest.raises(sim.TrialError, match=fault):
        sim.Trial.parse(text)


def test_a_recording_with_another_form_in_a_field_is_damaged(own_kind, tmp_path):
    record(sim.Trial.parse("{floorplan: ariac2023, duration: 1}"), tmp_path / "run")
    with (tmp_path / "run" / "events.jsonl").open("a") as file:
        file.write('{"t": 1.0, "kind": "tank_filled", "from": "bin2", "litres": "many"}\n')
    with pytest.raises(sim.RecordingError, match="litres of tank_filled"):
        sim.load_run(tmp_path / "run")


def test_names_of_built_in_kinds_are_rejected(event_kinds):
    with pytest.raises(TypeError, match="violation"):
        type("Violation", (sim.EventKind,), {"__module__": __name__})
    assert event_kinds["violation"].__module__ == "sim.core.events"


@pytest.mark.parametrize("annotations", [{"kind": str}, {"t": float}, {"when": complex}])
def test_fields_that_no_recording_can_contain_are_rejected(annotations, event_kinds):
    with pytest.raises(TypeError, match=next(iter(annotations))):
        type("Odd", (sim.EventKind,), {"__module__": __name__, "__annotations__": annotations})
    assert "odd" not in event_kinds


OWN = """\
import sim


class {name}(sim.EventKind):
    kilos: float


def lift(gantry):
    yield gantry.wait(2.0)
    gantry.record({name}(kilos=120.0))
"""


def lifting(tmp_path, name, expected):
    """Return a trial file beside a controller that defines the kind of event `name`."""
    (tmp_path / "crane.py").write_text(OWN.format(name=name))
    path = tmp_path / "lifting.trial.yaml"
    path.write_text(f"floorplan: ariac2023\nduration: 10\nexpect: {{timeline: [{expected}]}}\n")
    with path.open("a") as file:
        file.write('gantry: {controller: "crane:lift"}\n')
        file.write("people: [{name: ada, start: {event: pallet_lifted}}]\n")
    return path


def test_a_file_expects_events_that_its_controller_defines(tmp_path, event_kinds):
    met = '{eventually: {kind: pallet_lifted, kilos: ">= 100"}, within: 3}'
    unmet = '{never: {kind: pallet_lifted, kilos: "< 130"}}'
    path = lifting(tmp_path, "PalletLifted", f"{met}, {unmet}")
    event_kinds.pop("pallet_lifted", None)
    trial = sim.Trial.load(path)
    assert "pallet_lifted" not in event_kinds  # no trial was run
    run = sim.run(trial)
    assert [verdict.met for verdict in run.verdicts] == [True, False]
    assert {e["person"]: e["t"] for e in run.events if e["kind"] == "human_started"} == {"ada": 2.0}


def test_fields_of_events_that_a_controller_defines_are_checked_as_the_run_begins(
    tmp_path, event_kinds
):
    path = lifting(tmp_path, "PalletLifted", "{never: {kind: pallet_lifted, kilo: 3}}")
    event_kinds.pop("pallet_lifted", None)
    trial = sim.Trial.load(path)
    with pytest.raises(sim.TrialError, match="kilos"):
        sim.run(trial)


def test_other_classes_beside_a_controller_are_no_event_kinds(tmp_path, event_kinds):
    path = lifting(tmp_path, "PalletStacked", "{never: pallet_lifted}")
    event_kinds.pop("pallet_lifted", None)
    trial = sim.Trial.load(path)
    with pytest.raises(sim.TrialError, match="pallet_stacked") as caught:
        sim.run(trial)
    assert [one.field for one in caught.value.problems] == [
        "expect.timeline[0]",
        "people[0].start.event",
    ]


@pytest.mark.parametrize("litres", ["many", math.nan, [1.0]])
def test_a_custom_event_that_contradicts_its_declaration_is_rejected_when_recorded(
    own_kind, litres
):
    def refuelling(gantry):
        yield gantry.wait(2.0)
        gantry.record(own_kind(from_="station2", litres=litres))

    trial = sim.Trial.parse("{floorplan: ariac2023, duration: 5}")
    with pytest.raises(sim.ControllerError, match="litres of tank_filled") as caught:
        sim.run(replace(trial, gantry=sim.GantryEntry(refuelling)))
    assert "t = 2 s" in str(caught.value)
