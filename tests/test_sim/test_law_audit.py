"""Rule sets whose laws count on shorter stops than the machines on the floor may take."""

from dataclasses import replace

import pytest
from run_events import figures_in_words

import floorplan
import navigation
import sim

TRIAL = """\
floorplan: ariac2023
duration: 5.0
people: [{name: operator}]
rules:
  based_on: ariac2023
  gantry_law: {iso_ts_15066: {t1: 1.0, t2: 2.5, stopping: 1.9}}
"""

PLAN = floorplan.load("ariac2023")


def audited(**laws):
    """The machines in the summary's audit, with their figures, under these laws."""
    trial = sim.Trial(PLAN, duration=1.0, rules=replace(sim.RULE_SETS["ariac2023"], **laws))
    audit = sim.run(trial).summary["law_audit"]
    return {found["machine"]: found for found in audit}


def test_the_summary_has_what_the_law_states_and_what_the_machine_needs():
    found = audited()
    assert found.keys() == {"gantry"}
    stop = navigation.SeparationLaw.for_machine(PLAN.gantry, t1=1.0)
    assert found["gantry"] == {
        "machine": "gantry",
        "law": "gantry_law",
        "t2": 1.5,
        "needed_t2": pytest.approx(stop.t2),
        "stopping": 0.0,
        "needed_stopping": pytest.approx(stop.stopping),
    }
    assert audited(agv_law=sim.PAPER.agv_law).keys() == {"gantry", *(a.name for a in PLAN.lanes)}


def test_only_laws_that_state_a_stop_are_judged_and_those_of_the_machine_pass():
    enough = navigation.SeparationLaw.for_machine(PLAN.gantry, t1=1.0, intrusion=1.0)
    slow = navigation.SeparationLaw.for_machine(PLAN.lanes[0], t1=1.0)
    evenly = navigation.IntegralLaw(t1=1.0, t2=enough.t2)
    for law in (enough, evenly, navigation.FixedDistance(0.1), navigation.ApproachLaw(time=0.1)):
        assert audited(gantry_law=law, agv_law=slow) == {}
    assert audited(gantry_law=replace(evenly, t2=2.0)).keys() == {"gantry"}
    assert audited(gantry_law=replace(enough, stopping=1.0)).keys() == {"gantry"}


def test_check_warns_in_one_line_at_the_law(tmp_path, floorwalker):
    path = tmp_path / "short.trial.yaml"
    path.write_text(TRIAL)
    done = floorwalker("check", str(path))
    assert done.returncode == 0
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"{path}: line 6, rules.gantry_law: ")
    assert "2.5 s and 1.9 m" in line and "1.94 m" in line
    path.write_text(TRIAL.replace("1.9}", "1.94}"))
    assert floorwalker("check", str(path)).stderr == ""
    built_in = floorwalker("check", "ariac2023")
    assert built_in.returncode == 0
    assert built_in.stderr.count("\n") == 1


def test_a_run_says_it_in_one_figure():
    run = sim.run(replace(sim.Trial.load("ariac2023"), duration=1.0))
    said = [value for _, value in figures_in_words(run.summary) if "vehicles" in value]
    assert said == ["gantry, 4 vehicles"]
