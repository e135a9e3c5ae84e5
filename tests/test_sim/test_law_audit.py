"""Rule sets whose laws assume shorter stops than the machines on the floor may need."""

from dataclasses import replace
from pathlib import Path

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
EXAMPLES = Path(__file__).parents[2] / "examples"


def audited(**laws):
    """Return the machines in the summary's audit, with their figures, under these laws."""
    trial = sim.Trial(PLAN, duration=1.0, rules=replace(sim.RULE_SETS["ariac2023"], **laws))
    audit = sim.run(trial).summary["law_audit"]
    return {entry["machine"]: entry for entry in audit}


def test_the_summary_has_the_stop_of_the_law_and_of_the_machine():
    entries = audited()
    assert entries.keys() == {"gantry"}
    stop = navigation.SeparationLaw.for_machine(PLAN.gantry, t1=1.0)
    assert entries["gantry"] == {
        "machine": "gantry",
        "law": "gantry_law",
        "t2": 1.5,
        "needed_t2": pytest.approx(stop.t2),
        "stopping": 0.0,
        "needed_stopping": pytest.approx(stop.stopping),
    }
    assert audited(agv_law=sim.PAPER.agv_law).keys() == {"gantry", *(a.name for a in PLAN.lanes)}


def test_laws_with_the_stop_of_the_machine_pass():
    enough = navigation.SeparationLaw.for_machine(PLAN.gantry, t1=1.0, intrusion=1.0)
    slow = navigation.SeparationLaw.for_machine(PLAN.lanes[0], t1=1.0)
    evenly = navigation.IntegralLaw(t1=1.0, t2=enough.t2)
    for law in (enough, evenly):
        assert audited(gantry_law=law, agv_law=slow) == {}
    assert audited(gantry_law=replace(evenly, t2=2.0)).keys() == {"gantry"}
    assert audited(gantry_law=replace(enough, stopping=1.0)).keys() == {"gantry"}


def test_the_time_of_iso_13855_contains_the_stop():
    stop = navigation.SeparationLaw.for_machine(PLAN.gantry, t1=0.0)
    short = audited(gantry_law=navigation.ApproachLaw(time=0.3))
    assert short["gantry"]["t2"] == 0.3
    assert short["gantry"]["needed_t2"] == pytest.approx(stop.t2)
    assert short["gantry"]["stopping"] is None
    assert audited(gantry_law=navigation.ApproachLaw(time=stop.t2)) == {}


class Grows:
    """A law whose distance grows with the speed of the machine alone."""

    def __init__(self, factor):
        self.factor = factor

    def distance(self, human_speed, robot_speed):
        return self.factor * robot_speed


def test_a_distance_contains_the_stop_and_the_walk_of_a_person_meanwhile():
    stop = navigation.SeparationLaw.for_machine(PLAN.gantry, t1=0.0)
    needed = PLAN.human.max_speed * stop.t2 + stop.stopping
    top = audited(gantry_law=Grows(1.0))["gantry"]["distance"]
    for law in (navigation.FixedDistance, lambda metres: Grows(metres / top)):
        entry = audited(gantry_law=law(needed - 0.01))["gantry"]
        assert entry["needed_distance"] == pytest.approx(needed)
        assert entry["distance"] == pytest.approx(needed - 0.01)
        assert audited(gantry_law=law(needed + 1e-6)) == {}


@pytest.mark.parametrize(
    ("law", "place", "words"),
    [
        ("{iso_13855: {time: 0.3}}", "rules.agv_law", "cart 0.3 s (up to 2.61 s"),
        ("{fixed: 0.5}", "rules.agv_law", "cart 0.5 m (up to"),
        ("{iso_13855: {time: 2.7}}", "", ""),
        ("{fixed: 6}", "", ""),
        ("{grows:Grows: {factor: 0.1}}", "", ""),
    ],
)
def test_check_warns_of_laws_without_a_stop(tmp_path, floorwalker, law, place, words):
    path = tmp_path / "law.trial.yaml"
    (tmp_path / "grows.py").write_text("class Grows:\n    factor = distance = None\n")
    path.write_text(
        "floorplan: {boundary: [[0, 0], [20, 0], [20, 9], [0, 9]], stations: {a: [3, 3]}}\n"
        "duration: 5\n"
        f"rules: {{based_on: observe, agv_law: {law}}}\n"
        "machines: {cart: {kind: amr, at: [3, 3, 0]}}\n"
    )
    done = floorwalker("check", str(path))
    assert done.returncode == 0
    assert place in done.stderr and words in done.stderr
    assert bool(done.stderr) == bool(words)


def test_fields_stop_a_machine_without_rules(floorwalker):
    assert floorwalker("check", "vehicles_corridor").stderr == ""


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


def test_no_built_in_trial_and_no_example_has_too_short_a_law(floorwalker):
    examples = [str(path) for path in sorted(EXAMPLES.glob("**/*.trial.yaml"))]
    done = floorwalker("check", *sim.builtin_trials(), *examples)
    assert done.returncode == 0
    assert "stopping distance" not in done.stderr


@pytest.mark.parametrize(
    ("rules", "warned"),
    [("paper", ""), ("ariac2023", ""), ("protective_stop", "agv1, agv2")],
)
def test_the_scoring_laws_of_the_competition_are_no_protection(
    tmp_path, floorwalker, rules, warned
):
    path = tmp_path / "scored.trial.yaml"
    path.write_text(f"floorplan: ariac2023\nduration: 5\nrules: {rules}\n")
    assert warned in floorwalker("check", str(path)).stderr
    path.write_text(path.read_text() + "machines: {cart: {kind: amr, at: [-2.5, 0.5, 0]}}\n")
    assert "cart" in floorwalker("check", str(path)).stderr


def test_a_run_reports_the_audit_in_one_figure():
    run = sim.run(replace(sim.Trial.load("ariac2023"), duration=1.0))
    said = [value for _, value in figures_in_words(run.summary) if "vehicles" in value]
    assert said == ["gantry, 4 vehicles"]
