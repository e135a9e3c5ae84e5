"""Rule sets in files: their keys, custom laws, and errors."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from run_events import events, first, record

import sim
from floorplan import InputError, UserError
from navigation import ApproachLaw, FixedDistance, IntegralLaw, Scaled, SeparationLaw
from navigation.separation import required_at_speeds
from sim.safety.laws import OwnLaw

TRIAL = """\
floorplan: ariac2023
duration: 60
people: [{name: operator}]
gantry: {at: [-10.8, 3.0, 0.0]}
rules:
"""

BRAKING = """\
from dataclasses import dataclass


@dataclass(frozen=True)
class BrakingLaw:
    deceleration: float
    least: float = 0.5

    def distance(self, human_speed, robot_speed):
        if self.deceleration < 0:
            raise ValueError("deceleration is negative")
        return self.least + human_speed + robot_speed**2 / (2 * self.deceleration)


class WayAhead:
    def required(self, encounter, begin, end):
        return encounter.human.ahead(begin, end, 2.0) + 1.0


class Timid:
    def distance(self, human_speed, robot_speed):
        return 2.0 - human_speed


class Silent:
    pass


class Vague:
    def distance(self, human_speed, robot_speed):
        return "far"


class Off:
    def required(self, encounter, begin, end):
        return 3.0


class Fails:
    def distance(self, human_speed, robot_speed):
        return 1.0 if robot_speed == human_speed == 0.0 else 1 / 0
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "braking.py").write_text(BRAKING)
    return tmp_path


def trial(rules, folder="."):
    indented = "".join(f"  {line}\n" for line in rules.strip().splitlines())
    return sim.Trial.parse(TRIAL + indented, file="t.yaml", folder=folder)


def problems(rules, folder="."):
    with pytest.raises(sim.TrialError) as caught:
        trial(rules, folder)
    return "\n".join(str(problem) for problem in caught.value.problems)


def test_a_custom_rule_set_changes_only_the_keys_it_names():
    rules = trial(
        """
based_on: ariac2023
name: ours
gantry_law: {iso_ts_15066: {t1: 0.5, t2: 1.0, intrusion: 0.8}}
agv_law: {fixed: 1.5}
notice: {factor: 3.0, cap: null, every: null}
gantry_disabled: 4.0
pause_after_agv: 0
"""
    ).rules
    law, base = SeparationLaw(t1=0.5, t2=1.0, intrusion=0.8), sim.RULE_SETS["ariac2023"]
    assert (rules.name, rules.gantry_law, rules.agv_law) == ("ours", law, FixedDistance(1.5))
    notice = replace(base.notice, law=Scaled(law, 3.0), parting=1.0, every=None, silent=20.0)
    assert rules.notice == notice
    assert (rules.gantry_disabled, rules.grace) == (4.0, base.grace)
    assert (rules.pause_after_violation, rules.pause_after_agv) == (10.0, 0.0)


def test_omitted_keys_are_those_of_the_base():
    assert trial("{name: paper}").rules == sim.PAPER
    assert trial("{based_on: ariac2023, name: ariac2023}").rules == sim.RULE_SETS["ariac2023"]
    noticed = trial("{based_on: ariac2023, notice: {factor: 2.0}}").rules.notice
    assert noticed.law == Scaled(sim.RULE_SETS["ariac2023"].notice.law.law, 2.0, cap=5.0)
    assert (noticed.every, noticed.parting) == (20.0, math.inf)


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("{iso_ts_15066_integral: {t1: 1, t2: 1.5}}", IntegralLaw(t1=1, t2=1.5)),
        (
            "{iso_ts_15066_integral: {t1: 1, t2: 1.5, stopping: null, robot_uncertainty: 0.1}}",
            IntegralLaw(t1=1, t2=1.5, robot_uncertainty=0.1),
        ),
        ("{iso_13855: {time: 1.5, intrusion: 0.85}}", ApproachLaw(time=1.5, intrusion=0.85)),
        ("{fixed: 3}", FixedDistance(3)),
        ("{fixed: {metres: 3.0}}", FixedDistance(3.0)),
    ],
)
def test_laws_by_name(text, law):
    assert trial(f"gantry_law: {text}").rules.gantry_law == law


@pytest.mark.parametrize(
    ("rules", "message"),
    [
        ("papper", "line 5, rules: no rule set and no file is called 'papper'; did you mean"),
        ("based_on: papper", "line 6, rules.based_on: no rule set is called 'papper'"),
        ("agv_laws: {fixed: 2}", "line 6, rules.agv_laws: unknown key"),
        ("grace: -1", "line 6, rules.grace: expected at least 0, found -1"),
        ("notice: {factor: 0}", "line 6, rules.notice.factor: expected more than 0"),
        ("source: paper", "unknown key 'source'"),
        ("gantry_law: {}", "line 6, rules.gantry_law: give one law with its terms"),
        (
            "gantry_law: {iso15066: {}}",
            "line 6, rules.gantry_law: no law is called 'iso15066'; did",
        ),
        (
            "gantry_law: {fixed: -2}",
            "line 6, rules.gantry_law.fixed.metres: metres must be a",
        ),
        ("gantry_law: {fixed: two}", "rules.gantry_law.fixed.metres: expected a number, found"),
        (
            "gantry_law:\n  iso_ts_15066:\n    t1: 1\n    t2: -1.5",
            "line 9, rules.gantry_law.iso_ts_15066.t2: t2 must be a number of at least 0, not -1.5",
        ),
        (
            "notice:\n  law: {iso_ts_15066: {t1: 1}}",
            "line 7, rules.notice.law.iso_ts_15066: t2 is missing",
        ),
        (
            "agv_law: {iso_13855: {time: 1, t1: 1}}",
            "rules.agv_law.iso_13855.t1: iso_13855 has no term 't1'; its terms: time, intrusion,",
        ),
        ("agv_law: {iso_13855: {time: 1.0e+155}}", "time: the number is too large"),
        ("notice: {factor: 1.0e+155}", "notice.factor: expected at most 1e+10"),
        ("agv_law: {iso_13855: {time: .inf}}", "time must be a number"),
        (
            "agv_law: {'nowhere:Law': {}}",
            "line 6, rules.agv_law.nowhere:Law: the law 'nowhere:Law'",
        ),
        ("agv_law: {'braking:Law': {}}", "braking.py defines no class or function 'Law' at its"),
        ("agv_law: {'garbled:Law': {}}", "can't be read (garbled.py, line 1): SyntaxError"),
        ("agv_law: {'braking:': {}}", "'braking:' is not of the form package.module:name"),
        ("agv_law: {'braking:BrakingLaw': 3}", "expected the terms of the law"),
    ],
)
def test_invalid_values_are_reported_with_their_line(folder, rules, message):
    (folder / "garbled.py").write_text("def\n")
    assert message in problems(rules, folder)


@pytest.mark.parametrize(
    ("rules", "message"),
    [
        (
            "agv_law: {'broken:Law': {}}",
            "can't be imported (broken.py, line 2): ZeroDivisionError: division",
        ),
        (
            "agv_law: {'braking:BrakingLaw': {deceleration: -1}}",
            "braking:BrakingLaw(deceleration=-1) failed (braking.py, line 11): ValueError: decel",
        ),
        ("agv_law: {'braking:Silent': {}}", "'braking:Silent' (braking.py, line 25) is no law"),
        (
            "agv_law: {'braking:BrakingLaw': {}}",
            "braking:BrakingLaw(): missing a required argument: 'deceleration'; it takes (decelera",
        ),
        (
            "agv_law: {'braking:BrakingLaw': {deceleration: 1, most: 2}}",
            "got an unexpected keyword argument 'most'; it takes (deceleration",
        ),
        ("agv_law: {'braking:Timid': {}}", "a law must not ask for less when speeds grow"),
        ("agv_law: {'braking:Vague': {}}", "asks for 'far' m at speeds of 0 (human)"),
        ("agv_law: {'braking:Off': {}}", "answers with 3.0, not with an Enclosure"),
        (
            "agv_law: {'braking:Fails': {}}",
            "braking:Fails() failed (braking.py, line 41): ZeroDivisionError: division",
        ),
    ],
)
def test_an_error_of_a_law_is_reported_when_the_run_begins(folder, rules, message):
    (folder / "broken.py").write_text(
        "# A law.\n1 / 0\n\nclass Law:\n    def distance(self, human, robot): ...\n"
    )
    with pytest.raises(UserError) as caught:
        sim.run(trial(rules, folder))
    assert str(caught.value).startswith("t.yaml: line 6, rules.agv_law: the law ")
    assert message in str(caught.value)


def test_a_custom_law_decides(folder):
    rules = "gantry_law:\n  braking:BrakingLaw: {deceleration: 2.0, least: 1.5}"
    run = sim.run(trial(rules, folder))
    violation = first(run, "violation")
    assert violation["required"] == pytest.approx(1.5 + violation["human_speed"])
    assert violation["distance"] == pytest.approx(violation["required"], abs=1e-6)
    times = np.linspace(0.0, 60.0, 301)
    speeds = np.hypot(*run.motions["operator"].velocity(times).T)
    required = run.required("operator", "gantry", times)
    away = np.abs(required - 1.5 - speeds) > 0.011
    # At a jump of speed, the values of both sides are correct.
    assert away.sum() <= 3


@pytest.mark.parametrize("name", ["braking:BrakingLaw", "braking:WayAhead"])
def test_a_custom_law_can_be_sent_between_processes(folder, name):
    law = OwnLaw(name, {"deceleration": 2.0} if "Braking" in name else {}, folder)
    back = pickle.loads(pickle.dumps(law))
    assert back == law
    assert back != OwnLaw("braking:BrakingLaw", {"deceleration": 3.0}, folder)
    assert required_at_speeds(back, 1.0, 0.0) == required_at_speeds(law, 1.0, 0.0)


def test_the_module_beside_the_trial_is_used_regardless_of_earlier_imports(tmp_path):
    distances = []
    for metres in (1.0, 2.0, 1.0):
        folder = tmp_path / str(metres)
        folder.mkdir(exist_ok=True)
        text = f"class Law:\n    def distance(self, human, robot):\n        return {metres}\n"
        (folder / "same_name.py").write_text(text)
        rules = trial("gantry_law: {'same_name:Law': {}}", folder).rules
        distances.append(rules.gantry_law.distance(0.0, 0.0))
    assert distances == [1.0, 2.0, 1.0]


def test_a_law_that_fails_while_the_trial_runs_is_named_with_its_line(folder):
    (folder / "late.py").write_text(
        "class Late:\n"
        "    def distance(self, human_speed, robot_speed):\n"
        "        return 1.0 / (human_speed != 0.5)\n"
    )
    people = "people: [{name: operator, max_speed: 0.5}]"
    text = TRIAL.replace("people: [{name: operator}]", people) + "  gantry_law: {'late:Late': {}}\n"
    with pytest.raises(UserError, match=r"late:Late\(\) failed \(late.py, line 3\): ZeroDiv"):
        sim.run(sim.Trial.parse(text, folder=folder))


INTEGRAL = """
name: ahead
gantry_law: {iso_ts_15066_integral: {t1: 1.0, t2: 1.5, stopping: 0.2, intrusion: 0.8}}
agv_law: {iso_ts_15066_integral: {t1: 0.5, t2: 0.5, intrusion: 0.5}}
"""


def test_the_integral_law_is_a_rule_of_a_trial():
    run = sim.run(trial(INTEGRAL))
    violations = events(run, "violation")
    assert violations
    for event in violations:
        # The person was about to walk on for more than 2.5 s.
        assert event["required"] == pytest.approx(3.5, abs=1e-6)
        assert event["distance"] == pytest.approx(3.5, abs=1e-6)
        just_before = run.required("operator", "gantry", event["t"] - 1e-6)
        assert just_before == pytest.approx(3.5, abs=0.011)
    nearest = run.summary["minimum_separation"]
    assert nearest["required"] == pytest.approx(3.5, abs=1e-6)
    noticed = first(run, "gantry_detected")
    assert noticed["noticing_distance"] == pytest.approx(2 * noticed["required"])


def test_a_recording_contains_the_distances_required_by_an_integral_law(tmp_path):
    run = record(trial(INTEGRAL), tmp_path / "out")
    back = sim.load_run(tmp_path / "out")
    times = np.linspace(0.0, 60.0, 501)
    for machine in ("gantry", "agv1"):
        recorded = back.required("operator", machine, times)
        assert recorded == pytest.approx(run.required("operator", machine, times), abs=1e-8)


def test_a_rule_set_in_a_separate_file(folder):
    (folder / "ours.yaml").write_text("gantry_law: {'braking:BrakingLaw': {deceleration: 2}}\n")
    rules = sim.load_rules(folder / "ours.yaml")
    assert rules.name == "ours"
    assert rules.gantry_law.distance(0.0, 2.0) == 1.5
    text = TRIAL.replace("rules:", "rules: ours.yaml")
    assert sim.Trial.parse(text, folder=folder).rules == rules
    assert sim.RULE_SETS["paper"] == sim.PAPER
    (folder / "bad.yaml").write_text("grace: soon\n")
    with pytest.raises(InputError, match=r"bad.yaml: line 1, grace: expected a number"):
        sim.load_rules(folder / "bad.yaml")


def test_a_trial_with_custom_rules_can_be_written_and_read_again(folder):
    first = trial("gantry_law: {'braking:BrakingLaw': {deceleration: 2.0}}\ngrace: 3", folder)
    assert sim.Trial.parse(first.to_yaml(folder), folder=folder).rules == first.rules
    second = trial(INTEGRAL)
    assert sim.Trial.parse(second.to_yaml(".")).rules == second.rules


CAUSES = """
floorplan: ariac2023
duration: {duration}
people: [{{name: a, personality: stay.asl, at: [-5.0, 3.75]}}, {{name: b, start: {{time: 100}}}}]
gantry:
  controller: oblivious
  at: [{x}, 3.75, 0.0]
  jobs: [{jobs}]
"""


@pytest.mark.parametrize(
    ("x", "jobs", "program", "cause"),
    [
        (-9.0, "{move: [-5.0, 3.0, 0.0]}", "", "gantry"),
        (-7.5, "", "!go. +!go <- move(-10.8, 3.75, 0).", "person"),
        (-5.5, "{wait: 5.0}", "", "person"),
    ],
)
def test_a_violation_has_a_cause(tmp_path, x, jobs, program, cause):
    (tmp_path / "stay.asl").write_text(program)
    text = CAUSES.format(duration=7.9, x=x, jobs=jobs)
    run = sim.run(sim.Trial.parse(text, folder=tmp_path))
    (violation,) = events(run, "violation")
    assert violation["cause"] == cause
    assert (violation["robot_speed"] > 1e-6) == (cause == "gantry")
    counted = {"gantry": 0, "person": 0, cause: 1}
    assert run.summary["violations"] == counted
    assert run.summary["people"]["a"]["violations"] == counted
    assert run.summary["people"]["b"]["violations"] == {"gantry": 0, "person": 0}
    assert run.summary["penalties"] == 1
